"""A remedy leads out: an example in a message, taken literally, is accepted or leads to the next message."""

import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from axistwin import sweeps
from axistwin.core.errors import AxistwinError, installed
from axistwin.links import pacing, urls
from axistwin.real.standin.wiring import BoardPin
from axistwin.records.traces import reading

from .command import run
from .told import bare, examples

SCENE = """seed = 1
[[controller]]
model = "if1"
name = "table"
host = "moves.if1"
axes.X.motor.torque = [[0, 1.2], [5000, 0.4]]
[[controller]]
model = "smartmotor"
name = "knife"
program = "home.sms"
axes.shaft.motor = "frame23"
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("moves.if1").write_text("X10$\n")
    Path("home.sms").write_text("KP=100 END\n")
    Path("scene.toml").write_text(SCENE)


def raised(function: Callable[..., object], *given: object) -> str:
    try:
        function(*given)
    except AxistwinError as error:
        return str(error)
    return ""


# Texts that one function reads


def trace(line: str) -> None:
    Path("a.csv").write_text(f"time_ns,signal,value\n0,if1.output1,0\n{line}\n")
    reading.read(Path("a.csv"))


READERS = [
    *((sweeps.read_values, "{}", bad) for bad in ("5..1", "x..y", "[", "[]", "1..5:1", "-1..5:3:log", "0..99999999")),
    *((sweeps.measure, "{}", bad) for bad in ("", "x", "final")), (sweeps.measure, "count {}", "x"),
    (sweeps.measure, "from {}", "a to b"), *((sweeps.claim, "{}", bad) for bad in ("", "x")),
    (sweeps.claim, "never {}", "x"), (sweeps.claim, "always {}", "x"), (sweeps.claim, "never table.X passes {}", "a"),
    *((urls.parse, "{}", bad) for bad in ("", "x", "tcp:x", "rfc2217:x", "bus:x", "serial:", "pty")),
    (pacing.read_speed, "{}", "x"), (BoardPin.read, "{}", "?"), (trace, "{}", "1,2"),
    (trace, "{}", "x,if1.output1,1"),
    *((lambda text, scheme=scheme: urls.parse_as(scheme, text), "{}", "x") for scheme in ("tcp", "rfc2217", "bus")),
]  # fmt: skip


@pytest.mark.parametrize(("read", "form", "bad"), READERS)
def test_an_example_for_a_text_is_accepted(read: Callable[[str], object], form: str, bad: str) -> None:
    message = raised(read, form.format(bad))
    assert examples(message), message
    for example in examples(message):
        assert raised(read, form.format(bare(example))) == "", message


# Conversations


@pytest.mark.parametrize(("model", "form", "bad"), [
    ("if1", "; patience: {}", "x"), ("if1", "; options: {}", "X='a"), ("if1", "{}", "+x"), ("if1", "! {}", "input1"),
    ("if1", "! input1 {}", "x"), ("smartmotor", "! A {}", "x"), ("smartmotor", "! ambient {}", "x"),
    ("smartmotor", "! master {}", "x"), ("1811", "! read {}", "x"), ("1811", "! write {}", "x")])  # fmt: skip
def test_an_example_for_a_line_of_a_conversation_is_accepted(model: str, form: str, bad: str) -> None:
    def error_of(text: str) -> str:
        Path("a.talk").write_text(f"{form.format(text)}\n")
        done = run("run", model, "a.talk")
        return done.err if done.code else ""

    message = error_of(bad).strip()
    for example in examples(message):
        assert error_of(bare(example)) == "", message


# The command line

FMU = pytest.mark.skipif(not installed("pythonfmu3"), reason="the extra [fmu] is not installed")
SWEEPS = (
    "sweep scene.toml --for 0.05", "sweep scene.toml --for 0.05 --out a.parquet --vary x",
    "sweep scene.toml --for 0.05 --out a.parquet --vary table.X=1..2:2",
    "sweep scene.toml --for 0.05 --out a.parquet --vary table.X.load.torque=0.1..0.2",
    "sweep scene.toml --for 0.05 --out a.parquet --design random --vary table.X.load.torque=0.1..0.2",
)  # fmt: skip
COMMANDS = (
    "check", "run if1", "examples drill", "run if1 moves.if1 --trace a.csv --trace-limit x",
    *(pytest.param(line, marks=pytest.mark.slow) for line in SWEEPS),
    pytest.param("fmu scene.toml --out a.b.fmu", marks=FMU),
    pytest.param("fmu scene.toml --out a.fmu --command 'start: ! input1 high'", marks=FMU),
    pytest.param("fmu scene.toml --out a.fmu --command x", marks=FMU),
)  # fmt: skip


@pytest.mark.parametrize("line", COMMANDS)
def test_the_messages_lead_to_a_command_that_is_accepted(line: str) -> None:
    """An example is a whole command, an option that is missing, or the value of the last option."""
    told = [""]
    while (done := run(*shlex.split(line))).code:
        message = done.err.strip()
        assert message not in told
        told.append(message)
        example = examples(message)[0]
        if "axistwin " in example:
            line = bare(example).removeprefix("axistwin ")
        elif example.startswith("--"):
            line = f"{line} {example}"
        else:
            *words, last = shlex.split(line)
            setting, assigned, values = last.partition("=")
            if "begin the line" in message:
                last = f"start: {bare(example)}"
            elif not assigned or "=" in example:
                last = bare(example)
            else:
                last = f"{setting}={example}" if example.startswith(values) else f"{example}={values}"
            line = shlex.join([*words, last])
    assert len(told) > 1


STAND_IN = """
[[controller]]
model = "if1"
name = "desk"
[stand-in]
board = [{ name = "small", port = "COM3" }]
axis = [{ axis = "desk.X", step = "P2", direction = "P3", enable = "!P4", travel = [0, 9] }]
input = [{ to = "desk.limit_plus", pin = "^P8" }]
output = [{ from = "desk.output1", pin = "P10" }]
"""


@pytest.mark.parametrize(("good", "bad"), [
    ("desk.limit_plus", "limit_plus"), ("desk.limit_plus", "desk.output2"), ("desk.output1", "output1"),
    ("desk.output1", "desk.input1"), ('"P2"', '"?"'), ('enable = "!P4", ', ""), ('step = "P2", ', "")])  # fmt: skip
def test_an_example_for_a_stand_in_is_accepted(good: str, bad: str) -> None:
    def error_of(text: str) -> str:
        Path("desk.toml").write_text(STAND_IN.replace(good, text))
        done = run("stand-in", "desk.toml", "--dry-run")
        return done.err if done.code else ""

    message = error_of(bad).strip()
    assert message
    for example in examples(message):
        if " = " in example:
            assert error_of(f"{example}, ") == "", message
        else:
            assert error_of(f'"{example}"' if bad.startswith('"') else example) == "", message


@pytest.mark.skipif(not installed("caproto"), reason="the extra [epics] is not installed")
def test_an_option_of_a_scene_is_told_its_controller() -> None:
    """The value is wrong, so that the program ends; what it says then is about the value."""
    line = ("ioc", "scene.toml", "--prefix", "P:")
    (example,) = examples(run(*line, "--option", "load=5").err.strip())
    assert example == "--option knife.load=5"  # the host in the scene keeps table to itself
    assert "'load'" in run(*line, *example.split()).err


@pytest.mark.parametrize(("model", "program"), [("if1", "moves.if1"), ("1811", "moves.181x")])
def test_a_scene_without_ports_is_told_one_that_it_may_have(model: str, program: str) -> None:
    Path("moves.181x").write_text("null\n")
    Path("hosted.toml").write_text(f'[[controller]]\nmodel = "{model}"\nhost = "{program}"\n')
    key = run("serve", "hosted.toml").err.strip().rpartition(f"e.g. to {model}: ")[2]
    assert key.startswith("ports = ")
    with Path("hosted.toml").open("a") as file:
        file.write(key)
    assert run("check", "hosted.toml").code == 0
