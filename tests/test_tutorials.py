"""The commands in the tutorials are run, and must print exactly what the pages show.

A file is a block after a line that names it; a console is a block of `$ command` lines, each with its output.
"""

import os
import re
import socket
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import axistwin
from axistwin.bench import Bench
from axistwin.cli.serving.host_lines import lines
from axistwin.links.urls import PortUrl

HOME = Path(__file__).resolve().parents[1]
TUTORIALS = HOME / "docs" / "tutorials"
PATIENCE_S = 300

FILE = re.compile(
    r"^This is `(?P<name>[\w./-]+)`(?:, [^\n]*)?\.\n\n```(?:\w*)\n(?P<body>.*?)^```$", re.DOTALL | re.MULTILINE
)
CONSOLE = re.compile(r"^```console\n(?P<body>.*?)^```$", re.DOTALL | re.MULTILINE)
ACT = re.compile(r"^\$ (?P<command>.*)\n(?P<shown>(?:(?!\$ ).*\n)*)", re.MULTILINE)


def page(name):
    return (TUTORIALS / f"{name}.md").read_text(encoding="utf-8")


def files(text):
    return {found["name"]: found["body"] for found in FILE.finditer(text)}


def acts(text):
    return [found.groups() for console in CONSOLE.finditer(text) for found in ACT.finditer(console["body"])]


def printed(command, directory):
    """Return the standard output of a command, in the environment of a user who has installed axistwin."""
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(HOME / "src"),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",  # the plugin is named instead, because this copy need not be installed
        "PYTEST_ADDOPTS": "-p axistwin.testing.pytest_plugin -p no:cacheprovider",
        "COLUMNS": "80",
    }
    for name in ("PYTEST_XDIST_WORKER", "PYTEST_CURRENT_TEST"):
        environment.pop(name, None)
    done = subprocess.run(
        command, shell=True, cwd=directory, env=environment, capture_output=True, text=True, timeout=PATIENCE_S
    )
    return done.stdout


def lay_out(text, directory):
    for name, body in files(text).items():
        place = directory / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(body, encoding="utf-8")


@pytest.mark.parametrize(
    "name", ["pyvisa", *(pytest.param(name, marks=pytest.mark.slow) for name in ("pyserial", "replace"))]
)
def test_a_tutorial_prints_what_it_shows(name, tmp_path):
    if name == "replace":
        pytest.importorskip("pytrinamic", reason="pytrinamic is not installed")
    text, ran = page(name), 0
    for block in sorted((*FILE.finditer(text), *CONSOLE.finditer(text)), key=re.Match.start):
        lay_out(block[0], tmp_path)  # in the order in which a reader creates them
        for command, expected in acts(block[0]):
            assert printed(command, tmp_path) == expected, command
            ran += 1
    assert ran == len(re.findall(r"^\$ ", text, re.MULTILINE)) > 0


def test_the_lines_for_asyn_are_those_that_serve_shows():
    text = page("epics")
    line = Bench().add("if1").serial.host.format
    for url in (PortUrl("tcp", "127.0.0.1", 5001), PortUrl("pty", path="/dev/ttyUSB0")):
        asyn = [shown[10:] for shown in lines("if1", url, line) if "asyn" in shown.lower() or "Eos" in shown]
        for shown in asyn:
            assert shown in text.splitlines(), shown
    assert 'drvAsynIPPortConfigure("if1", "127.0.0.1:2217 COM", 0, 0, 0)' in text


def test_what_the_ioc_says_is_understood():
    """Each exchange of the protocol file, sent as StreamDevice sends it, is understood."""
    commands = re.findall(r"^(\w+) *\{(.*)\}", files(page("epics"))["feeder.proto"], re.MULTILINE)
    exchanges = {name: re.findall(r'(out|in) "(.*?)"', body) for name, body in commands}
    with axistwin.serve("if1", speed="manual", X={"limits": [-10, 2500]}) as twin:
        url = twin.ports["if1"]
        with socket.create_connection((url.host, url.port), timeout=PATIENCE_S) as ioc:
            heard = []

            def say(name, *values):
                for direction, words in exchanges[name]:
                    if direction == "out":
                        ioc.sendall((words % values + "\r").encode())
                        twin.advance(0.5)
                    else:
                        answer = ioc.recv(64).decode().removesuffix("\r")
                        assert re.fullmatch({"%d": r"-?\d+", "%c": "."}[words], answer)
                        heard.append(answer)

            twin.advance(1.5)
            ioc.sendall(b"(")
            twin.advance(0.1)
            assert ioc.recv(8) == b"U\r"
            say("initialise")
            twin.advance(1.2)
            say("feed", 100)
            say("state")
            say("position")
            assert heard == ["C", "100"]


def test_the_scene_of_the_ioc_is_one(tmp_path):
    lay_out(page("epics"), tmp_path)
    assert axistwin.Scene.load(tmp_path / "feeder.toml").ports == [("if1", "tcp://127.0.0.1:5001")]
    compile((tmp_path / "test_ioc.py").read_text(), "test_ioc.py", "exec")


EXCHANGE = re.compile(
    r"^\| (?:[a-z-]+|`[A-Z]+`(?: on| off)?) \| `(?P<sent>.*?)` \| (?:`(?P<answer>.*?)` )?\|", re.MULTILINE
)


@pytest.fixture
def smartmotor_driver(tmp_path):
    """Return a motor of the EPICS tutorial's scene, its clock, and a function that sends a message as the IOC does."""
    lay_out(page("epics"), tmp_path)
    with axistwin.serve(tmp_path / "motor.toml", speed="manual") as twin:
        url = twin.ports["motor"]
        with socket.create_connection((url.host, url.port), timeout=PATIENCE_S) as ioc:

            def ask(message, answered=True):
                ioc.sendall(message.encode() + b"\n")
                twin.advance(0.5)
                return ioc.recv(20).decode() if answered else None

            twin.advance(0.5)
            yield twin, ask


def test_the_exchanges_of_the_smartmotor_driver_are_those_of_the_page(smartmotor_driver):
    twin, ask = smartmotor_driver
    exchanges = EXCHANGE.findall(page("epics"))
    assert len(exchanges) == 19
    for sent, answer in exchanges:
        message = sent.replace("\\r", "\r")
        assert ask(message, bool(answer)) == (f"{answer}\r" if answer else None), sent
        twin.advance(2.0 if sent == "G" else 0.0)
    assert ask("RBo") == "1\r"


def test_after_a_following_error_the_smartmotor_driver_needs_zs(smartmotor_driver):
    twin, ask = smartmotor_driver
    motor = twin.bench["motor"]
    twin.do(lambda: motor.axes["shaft"].jam())
    for message in ("A=300", "V=400000", "P=4000", "G"):
        ask(message, answered=False)
    assert ask("RBe") == "1\r"
    twin.do(lambda: motor.axes["shaft"].jam(on=False))
    for message in ("MP\ra=@P\rP=a\rG", "P=4000", "G"):
        ask(message, answered=False)
    assert ask("RP") == "0\r"
    for message in ("ZS", "MP\ra=@P\rP=a\rG", "P=4000", "G"):
        ask(message, answered=False)
    twin.advance(1.5)
    assert ask("RP") == "4000\r"


def test_what_ci_does_is_done_here():
    """The commands of CI install existing packages, and run the tests that the tutorial shows."""
    workflow = files(page("ci"))[".github/workflows/test.yml"]
    install, test = re.findall(r"- run: (.*)$", workflow, re.MULTILINE)
    project = tomllib.loads((HOME / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert install == f"pip install wheels/{project['name']}-*.whl pytest"
    assert "fast" in project["optional-dependencies"]
    assert project["entry-points"]["pytest11"] == {"axistwin": "axistwin.testing.pytest_plugin"}
    assert any({*test.split()} <= {*command.split()} for command, _ in acts(page("pyserial")))


@pytest.mark.slow
def test_the_examples_of_the_page_on_testing_run(tmp_path):
    text = (HOME / "docs" / "testing.md").read_text(encoding="utf-8")
    test, program, checks = re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    (tmp_path / "test_page.py").write_text(test + checks, encoding="utf-8")
    assert printed("pytest -qq", tmp_path).startswith("....... ")
    exec(compile(program, "docs/testing.md", "exec"), {})
