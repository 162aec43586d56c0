"""The pytest plug-in, as somebody uses it who tests a host: pytest in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[2] / "src"
HOST_TIMEOUT_S = 50
HOST = """
import pytest, serial

def ask(host, text):
    host.write(text)
    return host.read_until(b"\\r")

@pytest.fixture
def host(axistwin_port):
    with serial.serial_for_url(axistwin_port, timeout=20) as host:
        yield host
"""
CELL = """
[[controller]]
model = "if1"
name = "left"
[[controller]]
model = "if2"
name = "right"
"""


@pytest.fixture
def run(tmp_path):
    """Runs pytest on a file with these tests; returns its exit code and what it prints."""

    def run(tests, *arguments, plugin=True):
        (tmp_path / "test_it.py").write_text(HOST + tests)
        (tmp_path / "cell.toml").write_text(CELL)
        kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
        environment = kept | {"PYTHONPATH": str(SOURCES), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
        words = [
            sys.executable,
            "-m",
            "pytest",
            "-p",
            "no:cacheprovider",
            "--basetemp=out",
            "--strict-markers",
            "-W",
            "error",
        ]
        words += ["-p", "axistwin.testing.pytest_plugin"] if plugin else []
        done = subprocess.run(
            [*words, *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=HOST_TIMEOUT_S
        )
        return done.returncode, done.stdout + done.stderr

    return run


def test_a_model_with_options_a_port_and_the_clock(run, tmp_path):
    code, told = run('''
@pytest.mark.axistwin("if1", self_test_s=0.2)
def test_it(host, axistwin_clock, axistwin_twin):
    axistwin_clock.advance(0.3)
    assert axistwin_twin.call(ask, host, b"(") == b"U\\r"
    assert axistwin_clock.run_until(lambda: axistwin_clock.seconds >= 1, timeout=2)
''')  # fmt: skip
    assert code == 0, told
    assert not list((tmp_path / "out").rglob("axistwin.*"))


def test_scenes_by_path_and_as_a_dict(run):
    code, told = run('''
@pytest.mark.axistwin(scene="cell.toml")
def test_path(axistwin_twin):
    assert list(axistwin_twin.ports) == ["left", "right"]

@pytest.mark.axistwin(scene={"controller": [{"model": "1811"}]}, speed="max")
def test_dict(axistwin_port):
    assert axistwin_port.startswith("bus://")
''')  # fmt: skip
    assert code == 0, told


def test_what_was_said_is_kept_when_a_test_fails(run, tmp_path):
    code, told = run('''
@pytest.mark.axistwin("if1")
def test_it(host, axistwin_twin):
    axistwin_twin.advance(1.5)
    assert axistwin_twin.call(ask, host, b"(") == b"V\\r"
''')  # fmt: skip
    talk, trace = Path("out", "test_it0", "axistwin.talk"), Path("out", "test_it0", "axistwin.csv")
    assert code == 1
    assert f"kept: {talk}\nkept: {trace}\n" in told
    assert "; model: if1\n! flow dtr\n+1.5\n> (\n< U\\r\n" in (tmp_path / talk).read_text()
    assert "if1.led" in (tmp_path / trace).read_text()


def test_without_a_marker_one_is_told_to_write_it(run):
    code, told = run("def test_it(axistwin_port): pass")
    assert code == 1
    assert 'test_it.py::test_it: invalid marker: expected one model or scene, e.g. @pytest.mark.axistwin("if1")' in told


def test_a_scene_that_is_wrong_is_told_with_its_place(run):
    code, told = run(
        '@pytest.mark.axistwin(scene={"controller": [{"model": "if9"}]})\ndef test_it(axistwin_port): pass'
    )
    assert code == 1
    assert "no model 'if9'" in told


def test_who_does_not_use_it_does_not_pay_for_it(run):
    code, told = run('''
def test_it():
    import sys
    loaded = {name for name in sys.modules if name.partition(".")[0] in ("axistwin", "simpy", "pydantic", "click")}
    own = {"axistwin", "axistwin.lazy", "axistwin.testing", "axistwin.testing.pytest_plugin", "axistwin.version"}
    assert loaded - {"simpy"} == own
''')  # fmt: skip
    assert code == 0, told


def test_only_what_is_there_is_named(run, tmp_path):
    code, told = run('''
@pytest.fixture
def broken(axistwin_twin):
    yield
    raise RuntimeError("afterwards")

@pytest.mark.axistwin("if1", colour="red")
def test_setup(axistwin_twin):
    pass

@pytest.mark.axistwin("if1")
def test_teardown(broken):
    pass
''')  # fmt: skip
    named = [tmp_path / line.removeprefix("kept: ") for line in told.splitlines() if line.startswith("kept: ")]
    assert code == 1
    assert [path.parent.name for path in named] == ["test_teardown0", "test_teardown0"]
    assert all(path.exists() for path in named)


def test_two_things_at_once_are_refused(run):
    code, told = run('@pytest.mark.axistwin("if1", "if2")\ndef test_it(axistwin_port): pass')
    assert code == 1
    assert "invalid marker: expected one model or scene" in told
