"""Two or three external actions in the same nanosecond, in any order, on a busy controller of any model.

    python benchmarks/robustness/same_instant.py [--seed 1] [--count 2000]

Pins, power, characters, bytes on the bus, jams, loads, faults.  The controller is busy and is
stopped between two events of one nanosecond.  The actions follow one after the other at this place, or as events, or
inside the call that changes a pin.  No action may raise an exception, and a second run must give the same result.
Prints the errors and a verdict; the exit code is 1 if there are errors.
"""

import argparse
import random
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.bench.faults.kinds import KINDS
from axistwin.bench.faults.table import Kind, On, Parameter, Sort
from axistwin.core.errors import UsageError
from axistwin.core.units import MS
from axistwin.plant.axes import Axis
from axistwin.sim.pins import Pin

Act = Callable[[], object]
MANNERS = ("between", "events", "inside")
"""Place of the actions: between two events, as events, or in the call that changes the next pin."""
MOST_STEPS = 60
"""Largest number of events before the actions."""
AFTER_NS = 1_500 * MS
SAMPLE_NS = 245_760

DIGIPLAN = (
    "", "X900@900$", "XG$", "X-G$", "H1X5$", "L2Y7$", "P1,9$", "P0,5X40$", "X100/Y50@500$", "K\rN\rE\rF", "#", "S12$",
    ":S1:X20@300:P2,3:H1:=2,0:$", ":X5:%:Y9:$", ":%:$", ":XG:H1A:P1,2:=1,0:$", "XG$\rX5$", "B-20X60B$", "X300$\r#", "[",
)  # fmt: skip
"""Commands to an IF1 or IF2."""
DEFAULT, SLOW = "31 00 00 00 00 27 10 00 01 86 A0", "31 00 00 00 00 03 E8 00 00 07 D0"
COMPUMOTOR = (
    (), ("33 00 00 27 10",), ("33 FF FF D8 F0",), ("32 00",), ("32 01", "70"), ("32 00", "73"),
    (SLOW, "33 00 00 03 E8"), ("38 01 00 32 00", "39 00"),
    ("D9 01", "33 00 00 01 00", "28 00", "32 00", "20 02 00 03", "D8", "41 01"),
    ("D9 01", "29 00 00 00 05", "2C 01 01", "D8", "41 01"), ("28 01",), ("29 00 00 00 20",), ("2C 06 01",), ("11",),
    ("11", "10"), ("74 01 01 01", "33 00 00 27 10"), ("77 06 01 00", "32 00"), ("7C 01 01 01", "32 00"),
    ("18 01", "33 00 00 10 00"), ("13 01", "33 00 00 27 10"), ("A1 01", "A3 01", "A5 01", "33 00 00 03 E8"),
    ("33 00 00 27 10", "83", "88", "85"), ("D9 01", "32 00", "28 01", "D8", "41 01", "79"), ("12 01",), ("D9 01",),
)  # fmt: skip
"""Commands for an 1810 or 1811, after the default velocity and acceleration."""
SMARTMOTOR = (
    "", "P=4000 G ", "MV V=200000 G ", "MP P=4000 G S ", "MV V=200000 G X ", "MT T=200 ", "TWAIT ", "BRKSRV P=900 G ",
    "a=0 WHILE a<9 a=a+1 PRINT(a) LOOP ", "MF4 ", "MS ", "RP RPE RW ", "F=32 P=9000 G ", "OFF ", "O=500 P=0 G ",
)  # fmt: skip
"""Commands to a SmartMotor."""
FORMATTED = (b"(", b"U", b"6", b"1", b"\r")


@dataclass(frozen=True)
class Model:
    """A controller, the commands that keep it busy, and the external actions on it."""

    name: str
    build: Callable[[Bench], Controller]
    works: Sequence[Callable[[Controller], None]]


def _write(text: str, it: Controller) -> None:
    it.serial.write(text.encode() + b"\r")


def _order(commands: Sequence[str], it: Controller) -> None:
    assert it.product.attend is not None
    host = it.product.attend(it.bus)
    host.subscribe_received(lambda message: None)
    for command in (DEFAULT, *commands):
        host.write(bytes.fromhex(command))


def _tell(text: str, it: Controller) -> None:
    it.serial.write(text.encode())


def _if(model: str, bench: Bench) -> Controller:
    axis = {"motor": {"torque": [[0, 1.0], [5000, 0.5]]}, "encoder": {}, "limits": (-400, 400)}
    it = bench.add(model, self_test_s=0.01, recalculation_s=0.02, X=axis, Y={"limits": (-400, 400)})
    bench.run(0.05)
    for character in FORMATTED:
        it.serial.write(character)
        bench.run(0.02)
    bench.run(0.2)
    it.serial.read()
    return it


def _board(model: str, bench: Bench) -> Controller:
    it = bench.add(model, initialisation_s=0.01, motor={"encoder": {}, "limits": (-9_000, 9_000), "home": (50, 90)})
    bench.run(0.02)
    return it


def _motor(bench: Bench, **shaft: object) -> Controller:
    it = bench.add("smartmotor", shaft={"limits": (-8_000, 8_000), **shaft})
    bench.run(0.3)
    it.serial.write(b"UCI UDI ZS A=100 V=400000 MP O=0 ")
    bench.run(0.2)
    return it


MODELS = {
    model.name: model
    for model in (
        Model("if1", partial(_if, "if1"), [partial(_write, text) for text in DIGIPLAN]),
        Model("if2", partial(_if, "if2"), [partial(_write, text) for text in DIGIPLAN]),
        Model("1810", partial(_board, "1810"), [partial(_order, commands) for commands in COMPUMOTOR]),
        Model("1811", partial(_board, "1811"), [partial(_order, commands) for commands in COMPUMOTOR]),
        Model("smartmotor", _motor, [partial(_tell, text) for text in SMARTMOTOR]),
        Model("frame17", partial(_motor, motor="frame17"), [partial(_tell, text) for text in SMARTMOTOR]),
    )
}


SAID = (
    b"#\r", b"X5$\r", b"XG$\r", b"[\r", b"]\r", b"%\r", b"K\r", b":$\r", b"(", b"*", b"U61\r",
    b"X ", b"S ", b"Z ", b"G ", b"END ", b"RUN ", b"\x00", b"\xff\xff",
)  # fmt: skip
COMMANDED = (
    "70", "71", "72", "73", "78", "79", "7A", "48", "33 00 00 01 00", "32 01", "10", "11", "42", "50", "41 01", "83",
    "D8", "18 00", "31 00 00 00 00 00 00 00 00 00 00",
)  # fmt: skip


def acts(bench: Bench, it: Controller) -> dict[str, dict[str, Act]]:
    """Return all external actions on the controller, by kind and name."""
    return {
        "power": {"off": partial(it.power, False), "cycle": it.power_cycle, "on": partial(it.power, True)},
        "edge": {f"{name} changes": partial(_change, pin) for name, pin in it.pins.items()},
        "pin": {name: act for pin in it.pins.values() for name, act in _of_a_pin(pin)},
        "axis": {name: act for key, axis in it.axes.items() for name, act in _of_an_axis(key, axis)},
        "host": _of_a_line(it) if it.product.attend is None else _of_a_board(it),
        "fault": {"mend all": partial(bench.faults.mend, "all")} | _faults(bench, it),
    }


def _change(pin: Pin) -> None:
    pin.drive(not pin.level)


def _of_a_pin(pin: Pin) -> Iterator[tuple[str, Act]]:
    yield f"{pin.name} high", partial(pin.drive, True)
    yield f"{pin.name} low", partial(pin.drive, False)
    yield f"{pin.name} released", pin.release


def _of_an_axis(name: str, axis: Axis) -> Iterator[tuple[str, Act]]:
    yield f"{name} jammed", axis.jam
    yield f"{name} free", partial(axis.jam, False)
    yield f"{name} loaded", partial(axis.load, 0.9)


def _of_a_board(it: Controller) -> dict[str, Act]:
    found: dict[str, Act] = {"init": it.bus.init, "read": partial(it.bus.read, 0)}
    found |= {f"control {value:02X}": partial(it.bus.write, 1, value) for value in (0x00, 0x10, 0x20, 0x80, 0x90, 0xF0)}
    return found | {f"command {command}": partial(_strobe, it, bytes.fromhex(command)) for command in COMMANDED}


def _strobe(it: Controller, data: bytes) -> None:
    for value in data:
        it.bus.write(0, value)
    it.bus.write(1, 0x10)


def _of_a_line(it: Controller) -> dict[str, Act]:
    port, host = it.serial, it.serial.host
    return {
        "break": partial(port.send_break, 0.01),
        "dtr off": partial(setattr, host, "dtr", False),
        "dtr on": partial(setattr, host, "dtr", True),
        "rts off": partial(setattr, host, "rts", False),
        "cut": port.to_device.cut,
        "mended": port.to_device.mend,
        "110 baud": partial(setattr, host, "baudrate", 110),
        "dropped": port.drop_pending,
        "instant": partial(setattr, port, "instant", True),
        **{f"says {text!r}": partial(port.write, text) for text in SAID},
    }


def _faults(bench: Bench, it: Controller) -> dict[str, Act]:
    there = ((kind, place) for kind in KINDS.values() for place in _places(it, kind.on))
    return {f"{kind.name} of {place}": partial(_fault, bench, kind, place) for kind, place in there}


def _places(it: Controller, on: On) -> list[str]:
    match on:
        case On.LINE:
            return [f"{it.name}.serial"] if it.product.attend is None else []
        case On.PIN:
            return [f"{it.name}.{pin}" for pin in it.pins]
        case On.AXIS:
            return [f"{it.name}.{axis}" for axis in it.axes]
    return [it.name]


def _fault(bench: Bench, kind: Kind, place: str) -> None:
    """Return a fault with a duration and its required parameters."""
    needed = (each for each in kind.parameters if each.default is None and not each.optional)
    given = {each.name: _value(each) for each in needed}
    with suppress(UsageError):  # this place cannot have a fault of this kind
        bench.faults.add(kind.name, place, seed=1, duration=None if kind.at_once else 0.2, **given)


def _value(parameter: Parameter) -> Any:
    match parameter.sort:
        case Sort.LEVEL:
            return False
        case Sort.WORD:
            return parameter.words[0]
    return max(1, parameter.low or 1)


@dataclass(frozen=True)
class Case:
    """One combination of actions."""

    model: str
    work: int
    steps: int
    """Number of steps before the actions: see `_advance`."""
    manner: str
    acts: tuple[tuple[str, str], ...]
    """Kind and name of each action."""

    def __str__(self) -> str:
        names = ", ".join(name for _, name in self.acts)
        return f"{self.model} work {self.work} after {self.steps} steps, {self.manner}: {names}"


def play(case: Case) -> tuple[object, ...]:
    """Run the case and return all observable results; any exception is a defect."""
    bench = Bench()
    model = MODELS[case.model]
    it = model.build(bench)
    edges: list[tuple[int, str, bool]] = []
    for name, pin in it.pins.items():
        pin.subscribe(lambda pin, name=name: edges.append((bench.now, name, pin.level)))
    model.works[case.work](it)
    _advance(bench, it, case.steps)
    known = acts(bench, it)
    waiting = [known[kind][name] for kind, name in case.acts]
    _happen(case.manner, waiting, bench, it)
    bench.clock.run_to(bench.now + AFTER_NS)
    waiting.clear()
    said = b"" if it.product.attend is not None else it.serial.read()
    axes = [(axis.position, axis.velocity, axis.moving) for axis in it.axes.values()]
    kept = [register.read() for register in it.registers.values()]
    return said, tuple(edges), axes, [pin.level for pin in it.pins.values()], kept, it.powered, bench.now


def _advance(bench: Bench, it: Controller, steps: int) -> None:
    """Advance by a number of events, for a motor by tens of samples.

    The last event may be in the middle of a nanosecond.  The number of events for the samples of a motor can differ
    between computers.
    """
    if it.product.model == "smartmotor":
        bench.clock.run_to((bench.now // SAMPLE_NS + 1 + 10 * steps) * SAMPLE_NS)
        return
    for _ in range(steps):
        if bench.clock.next_event_ns() is not None:
            bench.clock.step()


def _happen(manner: str, happenings: list[Callable[[], object]], bench: Bench, it: Controller) -> None:
    match manner:
        case "between":
            for happening in happenings:
                happening()
        case "events":
            for happening in happenings:
                bench.clock.call_later(0, happening)
        case _:

            def changed(_: Pin) -> None:
                while happenings:
                    happenings.pop(0)()

            for pin in it.pins.values():
                pin.subscribe(changed)


def cases(seed: int, count: int) -> Iterator[Case]:
    """Return this number of random cases; the seed determines the cases."""
    chance = random.Random(seed)
    known = names()
    for n in range(count):
        model = list(MODELS)[n % len(MODELS)]
        kinds = chance.choices(list(known[model]), k=chance.choice((2, 3)))
        chosen = tuple((kind, chance.choice(known[model][kind])) for kind in kinds)
        work, steps = chance.randrange(len(MODELS[model].works)), chance.randrange(MOST_STEPS)
        yield Case(model, work, steps, chance.choice(MANNERS), chosen)


@cache
def names() -> dict[str, dict[str, list[str]]]:
    """Return the actions on each model, by kind."""
    found = {}
    for name, model in MODELS.items():
        bench = Bench()
        found[name] = {kind: list(those) for kind, those in acts(bench, model.build(bench)).items()}
    return found


def wrong(case: Case) -> str:
    """Return the error of a case in one line; empty if there is none."""
    try:
        first = play(case)
        return "" if play(case) == first else f"{case}: not the same again"
    except Exception as error:  # noqa: BLE001  # each is a defect, and is what is looked for
        where = traceback.extract_tb(error.__traceback__)[-1]
        return f"{case}: {type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run all cases."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=2000)
    given = parser.parse_args(arguments)
    found = 0
    for case in cases(given.seed, given.count):
        if told := wrong(case):
            found += 1
            print(told, flush=True)
    verdict = "passed" if not found else "FAILED"
    print(f"{verdict}: {given.count} combinations, seed {given.seed}: {found} raised or were not the same again")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
