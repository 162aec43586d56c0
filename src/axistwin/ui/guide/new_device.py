"""Generate a device of the user's own from a few answers: the device, its test, a scene with a host, a page."""

from collections.abc import Iterator
from dataclasses import dataclass
from keyword import iskeyword
from string import Template
from struct import pack
from sys import stdlib_module_names

from axistwin.bench.models import is_model, models
from axistwin.core.errors import UsageError
from axistwin.devices.framing import add8
from axistwin.links.urls import PortUrl
from axistwin.plant.machine_units import MachineUnits
from axistwin.sim.frames import UartFormat
from axistwin.sim.line_format import line_format

STEPS = "steps"
DATAGRAMS = "datagrams"
ENDINGS = {"cr": r"\r", "lf": r"\n", "crlf": r"\r\n"}
FRAMINGS = (*ENDINGS, DATAGRAMS)
MOST_AXES = 8
MOST_TRAVEL = 1_000_000  # In the unit.
LEAST_STEPS, MOST_STEPS = 100, 100_000_000  # Of a travel.
MOST_VALUE = 2_000_000_000
FINEST = 1000  # Integer values of datagrams are thousandths of a unit, if that is not steps.


@dataclass(frozen=True)
class Answers:
    """The user's answers to the questions of `axistwin new --device`."""

    name: str  # Name of the model and of its file; the class has it with a capital letter.
    framing: str
    line: str  # Format of the serial line, e.g. "9600 8N1".
    axes: int
    units: MachineUnits | None  # Unit of positions on the line; None: steps of the motor.
    travel: int  # Place of the plus limit switch, in the unit.
    port: PortUrl

    @property
    def title(self) -> str:
        return self.name.replace("_", " ").title().replace(" ", "")

    @property
    def unit(self) -> str:
        return self.units.of if self.units else STEPS

    @property
    def velocity(self) -> int:
        """Steps per second: a tenth of the travel, and with ramps of 0.1 s a rate that half of it reaches."""
        return max(100, self.steps(self.travel) // 10)

    @property
    def range(self) -> int:
        """The farthest position that a host may name, in the unit: far beyond the travel, as in real controllers."""
        return max(self.travel, min(self.value(10 * MOST_TRAVEL), 100 * MOST_TRAVEL))

    @property
    def goal(self) -> int:
        """Where the first move ends, in the unit."""
        return self.travel // 2

    def steps(self, position: int) -> int:
        return round(position * self.units.per) if self.units else position

    def value(self, steps: int) -> int:
        return int(steps / self.units.per) if self.units else steps

    def check(self) -> None:
        """Raise UsageError for a travel of too few or too many steps."""
        if not LEAST_STEPS <= self.steps(self.travel) <= MOST_STEPS:
            raise UsageError(
                f"a travel of {self.travel} {self.unit} has {self.steps(self.travel)} steps: "
                f"expected {LEAST_STEPS} to {MOST_STEPS}, e.g. --travel 250 --units '80 per mm'"
            )


def read_name(text: str) -> str:
    """Return the name of a model and module.  Raises UsageError for a name that cannot be both."""
    taken = {"axistwin", "pytest", "test", *stdlib_module_names}
    if not text.isascii() or not text.isidentifier() or text != text.lower() or text.startswith("_") or iskeyword(text):
        raise UsageError(f"invalid name {text!r}: expected small letters, digits and _, e.g. stage")
    if text in taken or is_model(text):
        raise UsageError(
            f"the name {text!r} is in use ({', '.join(models())} are models): expected another, e.g. stage"
        )
    return text


def read_framing(text: str) -> str:
    if text not in FRAMINGS:
        raise UsageError(f"invalid framing {text!r}: expected one of {', '.join(FRAMINGS)}")
    return text


def read_line(text: str) -> str:
    """Return the format of a serial line.  Raises UsageError."""
    found, instant = line_format(text, UartFormat())
    if instant:
        raise UsageError("invalid line 'instant': expected the format of the device, e.g. 9600 8N1")
    return f"{found.baudrate} {found.bytesize}{found.parity}{found.stopbits:g}"


def read_units(text: str) -> MachineUnits | None:
    """Return None for `steps`, else the unit of a text such as `80 per mm`.  Raises UsageError."""
    if text == STEPS:
        return None
    try:
        return MachineUnits.written(text)
    except UsageError:
        raise UsageError(f"invalid units {text!r}: expected steps, or how many are one unit, e.g. 80 per mm") from None


def files(answers: Answers) -> dict[str, str]:
    """Return the contents of the files by name; the first is the device.  Raises UsageError."""
    answers.check()
    words = _words(answers) | (_datagrams(answers) if answers.framing == DATAGRAMS else _lines(answers))
    device, test = (DATAGRAMS_DEVICE, DATAGRAMS_TEST) if answers.framing == DATAGRAMS else (LINES_DEVICE, LINES_TEST)
    made = {
        f"{answers.name}.py": device, f"test_{answers.name}.py": test, "scene.toml": SCENE, "first.talk": TALK,
        "README.md": PAGE,
    }  # fmt: skip
    return {name: Template(text).substitute(words) for name, text in made.items()}


def _words(answers: Answers) -> dict[str, object]:
    names = [str(n) for n in range(1, answers.axes + 1)]
    steps, per = answers.steps(answers.goal), answers.units.per if answers.units else 1
    seconds = steps / answers.velocity + 0.1
    constant = f"STEPS = {str(per).replace('/', ' / ')}  # Steps of the motor per {answers.unit}.\n"
    return {
        "name": answers.name, "title": answers.title, "line": answers.line, "unit": answers.unit, "port": answers.port,
        "count": f"{answers.axes} ax{'i' if answers.axes == 1 else 'e'}s",
        "constant": constant if answers.units else "",
        "axes": "".join(
            f'        "{n}": Positioner(VELOCITY, ACCELERATION, minus="minus{n}", plus="plus{n}"),\n' for n in names
        ),
        "pins": "".join(
            f'        "minus{n}": Input(level=True), "plus{n}": Input(level=True),  # high within the travel\n'
            for n in names
        ),
        "bits": ", ".join(f'{int(n) - 1}: "axis {n} moves"' for n in names),
        "limits": "\n".join(_limits(answers, names)), "last": answers.axes, "range": answers.range,
        "velocity": answers.velocity, "acceleration": 10 * answers.velocity, "steps": steps,
        "seconds": f"{seconds:g}", "before": f"{seconds - 0.02:g}",
        "wait": f"{seconds + 0.2 + 240 / int(answers.line.split()[0]):.1f}",
    }  # fmt: skip


def _limits(answers: Answers, names: list[str]) -> Iterator[str]:
    for name in names:
        yield f"\n[controller.axes.{name}]"
        if answers.units is None:
            yield f"limits = [-100, {answers.travel}]    # in steps: a limit switch opens beyond each"
        else:
            yield f'units = {{ per = "{answers.units.per}", of = "{answers.unit}" }}'
            yield f'limits = ["-1 {answers.unit}", "{answers.travel} {answers.unit}"]    # a switch opens beyond each'


def _lines(answers: Answers) -> dict[str, object]:
    ending = ENDINGS[answers.framing]
    position = answers.steps(answers.goal)
    shown = str(position) if answers.units is None else f"{float(position / answers.units.per):.4f}"
    return {
        "ending": ending, "goal": answers.goal, "shown": shown, "kind": "float" if answers.units else "int",
        "to_steps": " * STEPS" if answers.units else "",
        "written": 'f"{self.axes[axis].position / STEPS:.4f}"' if answers.units else "self.axes[axis].position",
        "told": "str" if answers.units else "int", "counts": ", counts=STEPS" if answers.units else "",
        "confirmed": "", "sent": f"1PA{answers.goal}{ending}", "asked": f"1TP{ending}", "answered": f"{shown}{ending}",
    }  # fmt: skip


def _datagrams(answers: Answers) -> dict[str, object]:
    goal = answers.goal * (FINEST if answers.units else 1)
    position, place = answers.steps(answers.goal), "self.axes[str(axis)].position"
    shown = round(position / answers.units.per * FINEST) if answers.units else position
    return {
        "goal": goal, "shown": shown, "values": f"thousandths of {answers.unit}" if answers.units else STEPS,
        "counts": f", counts=STEPS / {FINEST}" if answers.units else "",
        "most": MOST_VALUE,
        "to_steps": f" * STEPS / {FINEST}" if answers.units else "",
        "written": f"round({place} / STEPS * {FINEST})" if answers.units else place,
        "confirmed": f"< {_escaped(1, 0, 0)}\n", "sent": _escaped(1, 1, goal),
        "asked": _escaped(3, 1, 0), "answered": _escaped(3, 0, shown),
    }  # fmt: skip


def _escaped(*values: int) -> str:
    data = pack(">BBi", *values)
    return "".join(f"\\x{byte:02X}" for byte in data + add8(data))


LINES_DEVICE = """\
\"\"\"$title: a controller of my own, written from its manual.\"\"\"

from axistwin.devices import Device, Input, Lines, Positioner, Refused, Why, command, query, register
from axistwin.drivers import TextDriver

VELOCITY, ACCELERATION = $velocity, $acceleration  # Of the motors, in steps per second and per second squared.
$constant

class $title(Device):
    \"\"\"$count with limit switches; positions on the line are in $unit.\"\"\"

    model, title, line = "$name", "$title", "$line"
    framing = Lines(b"$ending")
    axes = {
$axes    }
    pins = {
$pins    }
    driver = TextDriver(
        move="{axis}PA{position}", stop="{axis}ST", position="{axis}TP", busy="{axis}MD", at_rest=1$counts
    )  # how a host program moves an axis

    def refused(self, reason: Refused, data: bytes) -> str:
        \"\"\"Answer a request that is not carried out; the manual says how.\"\"\"
        return "?UNKNOWN" if reason.why is Why.UNKNOWN else "?REFUSED"

    @command("{axis}PA{position:$kind -$range..$range $unit}", section="Absolute move")
    def move_absolute(self, axis: str, position: $kind) -> None:
        self.axes[axis].move_to(position$to_steps)

    @command("{axis}PR{distance:$kind -$range..$range $unit}", section="Relative move")
    def move_relative(self, axis: str, distance: $kind) -> None:
        self.axes[axis].move_by(distance$to_steps)

    @command("{axis}ST", section="Stop")
    def stop(self, axis: str) -> None:
        self.axes[axis].stop()

    @query("{axis}TP", section="Tell position")
    def tell_position(self, axis: str) -> $told:
        return $written

    @query("{axis}MD", section="Motion done")
    def motion_done(self, axis: str) -> str:
        return "0" if self.axes[axis].moving else "1"

    @register({$bits}, section="Status")
    def status(self) -> int:
        return sum(axis.moving << bit for bit, axis in enumerate(self.axes.values()))
"""

MADE = """\
@pytest.fixture
def made():
    bench = Bench()
    controller = bench.add($title, line="instant")
    bench.run(1)
    return bench, controller


"""

KEEPS = """\
@pytest.mark.parametrize("check", device_checks($title))
def test_what_every_device_keeps(check):
    check()


"""

LINES_TEST = (
    """\
\"\"\"Tests of $name.py; run `pytest` in this folder.\"\"\"

import pytest
from $name import $title

from axistwin import Bench
from axistwin.testing import device_checks


"""
    + MADE
    + """\
def ask(made, request, seconds=0.01):
    \"\"\"Return what a host receives within `seconds` after a request.\"\"\"
    bench, controller = made
    controller.serial.write(request)
    bench.run(seconds)
    return controller.serial.read()


"""
    + KEEPS
    + """\
def test_a_move_takes_its_time(made):
    # $steps steps at $velocity/s, and a ramp of 0.1 s: $seconds s
    assert ask(made, b"1PA$goal$ending", $before) == b""
    assert ask(made, b"1MD$ending", 0.03) == b"0$ending"
    assert ask(made, b"1MD$ending") == b"1$ending"
    assert ask(made, b"1TP$ending") == b"$shown$ending"
    assert made[1].axes["1"].position == $steps


def test_bad_input_moves_nothing(made):
    assert ask(made, b"NONSENSE$ending") == b"?UNKNOWN$ending"
    assert ask(made, b"1PA999999999$ending", 1) == b"?REFUSED$ending"
    assert made[1].axes["1"].position == 0
"""
)

DATAGRAMS_DEVICE = """\
\"\"\"$title: a controller of my own, written from its manual.\"\"\"

from struct import pack, unpack

from axistwin.devices import Datagrams, Device, Input, Positioner, Refused, Request, Why, add8, command, query, register
from axistwin.drivers import TextDriver

VELOCITY, ACCELERATION = $velocity, $acceleration  # Of the motors, in steps per second and per second squared.
$constant

def datagram(code: int, axis: str, value: float = 0) -> bytes:
    \"\"\"Return what a host sends.\"\"\"
    data = pack(">BBi", code, int(axis), round(value))
    return data + add8(data)


class $title(Device):
    \"\"\"$count with limit switches; values are $values.\"\"\"

    model, title, line = "$name", "$title", "$line"
    framing = Datagrams(">BBi code axis value", ">BBi code error value", check=add8)  # B: a byte, i: four, big-endian
    axes = {
$axes    }
    pins = {
$pins    }
    driver = TextDriver(
        move=lambda axis, position: datagram(1, axis, position), stop=lambda axis: datagram(2, axis),
        position=lambda axis: datagram(3, axis), busy=lambda axis: datagram(4, axis), at_rest=1,
        confirmed=True, size=7, value=lambda answer: unpack(">i", answer[2:6])[0]$counts,
    )  # how a host program moves an axis

    def answer(self, result: int | None, request: Request) -> dict[str, int]:
        return {"code": request.values["code"], "error": 0, "value": result or 0}

    def refused(self, reason: Refused, data: bytes) -> dict[str, int]:
        \"\"\"Answer a request that is not carried out; the manual says how.\"\"\"
        return {"code": data[0], "error": 1 if reason.why is Why.UNKNOWN else 2, "value": 0}

    @command("code=1 {axis:int 1..$last} {value:int -$most..$most}", section="Absolute move")
    def move_absolute(self, axis: int, value: int) -> None:
        self.axes[str(axis)].move_to(value$to_steps)

    @command("code=2 {axis:int 1..$last}", section="Stop")
    def stop(self, axis: int) -> None:
        self.axes[str(axis)].stop()

    @query("code=3 {axis:int 1..$last}", section="Tell position")
    def tell_position(self, axis: int) -> int:
        return $written

    @query("code=4 {axis:int 1..$last}", section="Motion done")
    def motion_done(self, axis: int) -> int:
        return int(not self.axes[str(axis)].moving)

    @register({$bits}, section="Status")
    def status(self) -> int:
        return sum(axis.moving << bit for bit, axis in enumerate(self.axes.values()))
"""

DATAGRAMS_TEST = (
    """\
\"\"\"Tests of $name.py; run `pytest` in this folder.\"\"\"

from struct import pack, unpack

import pytest
from $name import $title

from axistwin import Bench
from axistwin.devices import add8
from axistwin.testing import device_checks


"""
    + MADE
    + """\
def ask(made, code, axis, value=0, seconds=0.01):
    \"\"\"Return code, error and value of the answer.\"\"\"
    bench, controller = made
    data = pack(">BBi", code, axis, value)
    controller.serial.write(data + add8(data))
    bench.run(seconds)
    return unpack(">BBix", controller.serial.read())


"""
    + KEEPS
    + """\
def test_a_move_takes_its_time(made):
    # $steps steps at $velocity/s, and a ramp of 0.1 s: $seconds s
    assert ask(made, 1, 1, $goal, $before) == (1, 0, 0)
    assert ask(made, 4, 1, 0, 0.03) == (4, 0, 0)
    assert ask(made, 4, 1) == (4, 0, 1)
    assert ask(made, 3, 1) == (3, 0, $shown)
    assert made[1].axes["1"].position == $steps


def test_bad_input_moves_nothing(made):
    assert ask(made, 99, 1) == (99, 1, 0)
    assert ask(made, 1, 9, 1) == (1, 2, 0)
    assert made[1].axes["1"].position == 0
"""
)

SCENE = """\
# A scene with a device of my own.  All keys are described by `axistwin docs scenes`.
title = "$title"

[[controller]]
model = "$name"
name = "$name"
host = "first.talk"                # a simulated host says these lines
ports = ["$port"]    # for `axistwin --device $name.py serve scene.toml`, in place of it
$limits
"""

TALK = """\
; A first move.
> $sent
$confirmed+$wait
> $asked
< $answered
= 1.position $steps
"""

PAGE = """\
# $title

| file | contents |
| --- | --- |
| `$name.py` | the device, to be changed by its manual |
| `test_$name.py` | its tests: run `pytest` here |
| `scene.toml`, `first.talk` | a machine with the device, and what a host says to it |

```
axistwin --device $name.py run scene.toml            the host's lines, at full speed
axistwin --device $name.py serve scene.toml          a port for your own host: $port
axistwin --device $name.py serve scene.toml --panel 8080    and a panel in the browser
axistwin --device $name.py term $name                talk to the device
axistwin --device $name.py commands $name            its commands
axistwin --device $name.py check scene.toml          errors in the scene
axistwin docs devices                                how to go on
```
"""
