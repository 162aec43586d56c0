"""Odd options of `Bench.add`, and scenes with odd values at any place of the schema: no exception but AxistwinError.

    python benchmarks/robustness/options.py [--cases 100000] [--seed 1] [--only options|scenes]

Each case is built; what is accepted is also used: the host initialises the controller and sends a short move.  Half of
the cases are options, half are scenes.  It takes two minutes of processor time.  The verdict is the last line; exit
code 1 if anything was found.
"""

import argparse
import os
import random
import signal
import sys
import traceback
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import fields
from fractions import Fraction
from math import inf, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench, Scene
from axistwin.bench import Controller, host_at, product
from axistwin.bench.faults.kinds import KINDS
from axistwin.controllers.registry import OURS
from axistwin.core.errors import AxistwinError
from axistwin.plant import axes, servo
from axistwin.plant.axes import servo_axis
from axistwin.plant.encoder import EncoderData
from axistwin.plant.servo import SERVO_MOTORS, ServoLoad
from axistwin.plant.torque import Load, StepperMotor

BOUND_S = 20.0
"""Processor time of a case, unless it asks for more virtual time."""
LONGEST_LINE = 800
WORDS = ("", "x", "x" * 300, "\0", "\n", "12.5 mm", "9600 8N2", "instant", "if1", "smartmotor", "1811", "table.X",
         "a.b.c", "table.output1", "frame23", "../x", "/", "tcp://127.0.0.1:0", "pty:/tmp/x", "X passes 100",
         "input1 high",
         "load a.sms", "fault lose 3", "€", "6400/360")  # fmt: skip
NUMBERS = (0, 1, -1, 2, 3, 50, 1000, 0.5, 1.0, 5.0, 1e-9, 1e-300, 1e308, -1e308, nan, inf, -inf, 2**31, 2**53, 2**63,
           10**30, -(10**30), 10**400, Fraction(1, 3))  # fmt: skip
MILD = (0, 1, 2, 3, 0.001, 1e-9, 0.5, 7, 1000, 1e6, 12345678901)
OTHERS = (None, True, False, [], [1], [0, 100], [100, 0], [1, 2, 3], [[0, 1.2], [5000, 0.4]], [nan, inf], [[]], {},
          {"a": 1}, {"torque": []}, (0, 5), b"x", Path("x"), 1j, object)  # fmt: skip
PLAIN = (str, int, float, bool, list, dict)
"""Types of values in TOML."""
SESSIONS = {
    "digiplan": ((1.1, b"("), (0.1, b"U61\r"), (1.1, b"X40@1000$\r"), (0.2, b"E\r")),
    "compumotor": tuple(
        (1.1 * (n == 0) + 0.05, bytes.fromhex(data))
        for n, data in enumerate(("31 00 00 00 00 03 E8 00 03 D0 90", "33 00 00 00 28", "83"))
    ),
    "smartmotor": ((0.3, b"UCI UDI ZS A=100 V=400000 MP O=0 P=50 G RPA "), (0.05, b"RTEMP RUIA RW ")),
}
"""What a host says to each family, each after a pause in seconds."""
BASES: tuple[dict[str, Any], ...] = (
    {
        "seed": 3,
        "controller": [
            {"model": "if2", "name": "table", "host": "go.if1", "line": "9600 8N2",
             "options": {"wiring": "3-wire", "strobe_ms": 1.0},
             "axes": {"X": {"limits": [-100, 20000], "units": {"per": 80, "of": "mm"},
                            "encoder": {"counts_per_rev": 4000, "backlash": 3}, "load": {"torque": 0.1},
                            "motor": {"torque": [[0, 1.2], [5000, 0.4]], "inertia": 1e-5}}}},
            {"model": "1811", "name": "board", "options": {"part_number": "94-003657-01A", "buffer_bytes": 600},
             "axes": {"motor": {"home": [0, 10], "encoder": {"counts_per_rev": 4000}}}},
        ],
        "wire": [{"from": "table.output1", "to": "table.input1", "delay_ms": 2.5}],
        "fault": [{"kind": "lose", "on": "table.serial", "at": 0.01, "count": 3},
                  {"kind": "jam", "on": "table.X", "when": "table.X passes 10", "duration": 0.5}],
        "script": [{"at": 0.02, "on": "table", "do": ["input1 high", "X.load 0.2"]}],
        "operator": {"button": [{"name": "go", "pin": "table.input2"}],
                     "lamp": [{"name": "on", "pin": "table.output2"}],
                     "selector": [{"name": "way", "positions": {"a": "table.input3", "b": ""}}]},
    },
    {
        "controller": [
            {"model": "smartmotor", "name": "left", "program": "go.sms", "history": 1000,
             "variables": {"a": 3, "KP": 50},
             "axes": {"shaft": {"motor": "frame17", "limits": [-5000, 5000], "load": {"inertia_kg_m2": 1e-5}}}},
            {"model": "smartmotor", "name": "right", "options": {"statements_per_sample": 2, "index_at": 5},
             "master": "left.shaft", "master_ratio": [1, 2]},
        ],
        "chain": [{"motors": ["left", "right"], "name": "line", "ports": ["tcp://127.0.0.1:0"]}],
        "script": [{"at": 0.02, "on": "left", "do": ["A 2.5V", "ambient 40"]}],
    },
)  # fmt: skip


class TooLongError(BaseException):
    """The time limit of a case has passed."""


class Chooser:
    """Draws the values of one case."""

    def __init__(self, seed: str) -> None:
        self.chance = random.Random(seed)

    def any(self, *good: object) -> Any:
        """Return one of the good values, or anything else."""
        if good and self.chance.random() < 0.5:
            return self.chance.choice(good)
        return self.chance.choice(self.chance.choice((NUMBERS, NUMBERS, WORDS, OTHERS)))

    def of(self, kind: Any) -> Any:
        """Return a value for a type hint of an option."""
        if get_origin(kind) in (Union, UnionType):
            kind = self.chance.choice(get_args(kind))
        if get_origin(kind) is Literal:
            return self.any(*get_args(kind))
        good = {bool: (True, False), int: (1, 2, 50, 600), float: (0.5, 1, 3.0, 60)}.get(kind, ())
        if get_origin(kind) is tuple:
            good = (("message_ready", "failed"), [], ["x"])
        return self.any(*good)

    def table(self, kind: type, *more: str) -> Any:
        """Return a table of some fields of a dataclass, or anything else."""
        if self.chance.random() < 0.15:
            return self.any()
        hints = get_type_hints(kind)
        names = [*(field.name for field in fields(kind)), *more, "unknown"]
        chosen = self.chance.sample(names, self.chance.randint(0, min(3, len(names))))
        return {name: self.of(hints.get(name, str)) for name in chosen}

    def axis(self, servo: bool) -> Any:
        """Return the options of an axis."""
        if self.chance.random() < 0.1:
            return self.any()
        made = {
            "limits": lambda: self.any([0, 100], (-5, 5), ["1 mm", "2 mm"]),
            "home": lambda: self.any([0, 10]),
            "units": lambda: self.any({"per": self.any(80, "6400/360"), "of": self.any("mm", "deg")}),
            "encoder": lambda: self.table(EncoderData),
            "motor": lambda: self.servo_motor() if servo else self.stepper_motor(),
            "load": lambda: self.table(ServoLoad if servo else Load),
            "unknown": self.any,
        }
        names = [*(axes.SERVO if servo else axes.STEPPER), "unknown"]
        return {name: made[name]() for name in self.chance.sample(names, self.chance.randint(1, 3))}

    def stepper_motor(self) -> Any:
        """Return the data sheet of a stepper motor."""
        found = self.table(StepperMotor)
        if isinstance(found, dict) and self.chance.random() < 0.7:
            found["torque"] = self.any([[0, 1.2], [5000, 0.4]], [[self.any(0), self.any(1.0)]])
        return found

    def servo_motor(self) -> Any:
        """Return the data sheet of a servo motor."""
        return self.any(*SERVO_MOTORS) if self.chance.random() < 0.4 else self.table(servo.ServoMotor, "model")


class Campaign:
    """Builds and uses odd controllers and scenes, and notes what is wrong."""

    def __init__(self, seed: int, folder: Path, bound_s: float = BOUND_S) -> None:
        self.seed, self.folder, self._bound_s = seed, folder, bound_s
        self.found: list[str] = []
        self.ends: Counter[str] = Counter()
        (folder / "state").mkdir(exist_ok=True)
        (folder / "go.if1").write_text("X40@1000S1$\n+0.1\nX-10$\n")
        (folder / "go.sms").write_text("UCI UDI ZS A=100 V=400000 MP O=0 P=50 G TWAIT END\n")

    def run(self, cases: int, only: str = "") -> None:
        """Make this many cases."""
        os.chdir(self.folder)
        for number in range(cases):
            what = only or ("options", "scenes")[number % 2]
            chooser = Chooser(f"{self.seed} {number}")
            with _watchdog(self._bound_s):
                self._one(f"{what} {number}", chooser, what == "options")

    def _one(self, name: str, chooser: Chooser, options: bool) -> None:
        case: Any = None
        kind = name.split()[0]
        try:
            case = added(chooser, self.folder) if options else scene(chooser)
            (use_options if options else use_scene)(case)
            self.ends[f"{kind} used"] += 1
        except AxistwinError as error:
            self.ends[f"{kind} refused"] += 1
            line = str(error)
            if not line or len(line) > LONGEST_LINE or "\n" in line:
                self.found.append(f"{name}: {case!r}: no short line: {line[:100]!r}")
        except TooLongError:
            self.found.append(f"{name}: {case!r}: no end after {self._bound_s:g} s")
        except Exception:  # noqa: BLE001  # whatever it is, it is to be seen
            self.found.append(f"{name}: {case!r}: {_last(traceback.format_exc())}")


def added(chooser: Chooser, folder: Path) -> tuple[Any, dict[str, Any]]:
    """Return a model and keywords of `Bench.add`."""
    model = chooser.chance.choice(list(OURS))
    made = product(model)
    hints = get_type_hints(made.options)
    own = {field.name: (lambda name=field.name: chooser.of(hints[name])) for field in fields(made.options)}
    axes = {axis: (lambda: chooser.axis(made.make_axis is servo_axis)) for axis in made.axes}
    common = {
        "state": lambda: chooser.any(str(folder / "state")),
        "line": lambda: chooser.any("9600 8N2", "instant", "300 7E1"),
        "history": lambda: chooser.any(2, 100),
        "name": lambda: chooser.any("a", "b"),
        "unknown": chooser.any,
    }
    makers: dict[str, Any] = {**own, **axes, **common}
    names = chooser.chance.sample(list(makers), min(len(makers), chooser.chance.choice((1, 1, 1, 2, 4))))
    return (model if chooser.chance.random() < 0.97 else chooser.any()), {name: makers[name]() for name in names}


def use_options(case: tuple[Any, dict[str, Any]]) -> None:
    """Add the controller, and use it."""
    bench = Bench()
    talk(bench, bench.add(case[0], **case[1]))
    for controller in bench.controllers.values():
        controller.power(False)


def talk(bench: Bench, controller: Controller) -> None:
    """Let a host initialise the controller and move it."""
    with host_at(bench, controller.name) as host:
        for pause_s, data in SESSIONS[controller.product.family]:
            bench.run(pause_s)
            host.write(data)
        bench.run(0.1)
    for register in controller.registers.values():
        register.read()
    for axis in controller.axes.values():
        axis.pulse_times() if hasattr(axis, "pulse_times") else axis.velocity


def scene(chooser: Chooser) -> dict[str, Any]:
    """Return a scene with one to three odd values or keys, at any place."""
    found = _copied(chooser.chance.choice(BASES))
    for _ in range(chooser.chance.choice((1, 1, 2, 3))):
        places = list(_places(found))
        numbers = [(place, key) for place, key in places if type(place[key]) in (int, float)]
        place, key = chooser.chance.choice(numbers if numbers and chooser.chance.random() < 0.5 else places)
        match chooser.chance.randrange(9):
            case 0:
                place.pop(key)
            case 1 if isinstance(place, dict):
                place[chooser.chance.choice(("unknown", "mdoel", "name", "host", "state", "ports", key[:-1]))] = (
                    place.pop(key)
                )
            case 2:
                other, at = chooser.chance.choice(list(_places(found)))
                place[key] = _copied(other[at])
            case 3 if isinstance(place, list):
                place.append(_copied(place[key]))
            case 4 | 5 if type(place[key]) in (int, float):
                place[key] = chooser.chance.choice(MILD)
            case _:
                place[key] = _plain(chooser)
    if chooser.chance.random() < 0.4:
        found.setdefault("fault", [])
        if isinstance(found["fault"], list):
            found["fault"].append(fault(chooser))
    if chooser.chance.random() < 0.3:
        found["script"] = [{"at": 0.01, "on": chooser.any("table", "left"), "do": act(chooser)}]
    return found


def fault(chooser: Chooser) -> dict[str, Any]:
    """Return a fault with odd values for most of its parameters."""
    kind = chooser.chance.choice(list(KINDS.values()))
    on = chooser.chance.choice(
        ("table.serial", "table.input1", "table.X", "table", "left", "left.shaft", "board.motor")
    )
    made = {"kind": kind.name, "on": on, "at": chooser.chance.choice(MILD[:6])}
    for parameter in kind.parameters:
        if chooser.chance.random() < 0.8:
            good = (*parameter.words, *MILD, "high", "all")
            made[parameter.name] = chooser.chance.choice(good) if chooser.chance.random() < 0.8 else _plain(chooser)
    return made


def act(chooser: Chooser) -> str:
    """Return an action of a script."""
    parts = ("X", "shaft", "input1", "A", "D", "power", "break", "ambient", "master", "line", "load", "mend",
             "joystick", "supply")  # fmt: skip
    part = chooser.chance.choice((*parts, "fault jam X", "fault lose serial"))
    what = chooser.chance.choice(("", ".load", ".jam", ".push", ".displace", ".brake", ".lost", ".torque"))
    value = chooser.any("high", "low", "on", "off", "5", "2.5V", "4 in 2", "0.1", "go.sms", "go.if1")
    return f"{part}{what} {value}"


def use_scene(case: dict[str, Any]) -> None:
    """Build the scene, look at all that commands look at, and run it."""
    made = Scene.given(case)
    _ = made.models, made.ports, list(made.named_programs()), made.hosted, made.build_errors()
    bench = made.build()
    bench.run(4 if len(str(case)) % 4 == 0 else 0.05)
    for controller in bench.controllers.values():
        controller.power(False)


def _plain(chooser: Chooser) -> Any:
    while True:
        value = chooser.any()
        if isinstance(value, PLAIN) and not isinstance(value, type):
            return _copied(value)


def _copied(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _copied(inner) for key, inner in value.items()}
    return [_copied(inner) for inner in value] if isinstance(value, list | tuple) else value


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    keys: Sequence[Any] = (
        list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    )
    for key in keys:
        yield value, key
        yield from _places(value[key])


def _last(text: str) -> str:
    """Return place and text of an exception."""
    lines = text.strip().splitlines()
    place = [line.strip() for line in lines if line.strip().startswith('File "')][-1]
    return f"{lines[-1][:200]} ({place.rpartition('/src/')[2]})"


@contextmanager
def _watchdog(bound_s: float) -> Iterator[None]:
    def over(*_: object) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGPROF, over)
    signal.setitimer(signal.ITIMER_PROF, bound_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign, and print the findings and the verdict."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=("options", "scenes"), default="")
    given = parser.parse_args(arguments)
    began, here = process_time(), Path.cwd()
    with TemporaryDirectory() as directory, suppress(KeyboardInterrupt):
        campaign = Campaign(given.seed, Path(directory))
        use_options(("smartmotor", {}))  # compiles the servo code, which is no part of a case
        campaign.run(given.cases, given.only)
        os.chdir(here)
    for line in campaign.found:
        print(line)
    for end, count in sorted(campaign.ends.items()):
        print(f"{count:7} {end}")
    verdict = "FAILED" if campaign.found else "passed"
    took_s = process_time() - began
    print(f"{verdict}: seed {given.seed}, {given.cases} cases in {took_s:.0f} s of processor time: ", end="")
    print(f"{len(campaign.found)} found")
    return 1 if campaign.found else 0


if __name__ == "__main__":
    sys.exit(main())
