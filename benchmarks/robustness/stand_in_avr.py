"""Edge times of Klipper's unmodified firmware on simulated AVR boards, and the cause of each late edge.

    AXISTWIN_KLIPPER=... AXISTWIN_AVR8JS=... python benchmarks/robustness/stand_in_avr.py [--seed 1] [--seconds 1.0]

An ATmega328P moves one axis at a random rate, without inputs and with up to six, and at 20,000 pulses/s; an ATmega2560
moves three axes at 5,000 pulses/s.  The number of edges must be right.  Times are split in two: the planned tick
against the requested time (planning and clock), and the edge against its planned tick (the board).  The first may be
off by 2 µs.  The second may be off by 20 µs with one axis and two inputs, otherwise by 45 µs: the board's events wait
for each other, and the firmware defers them all by 16 µs if its tasks had no time.  Each edge that is late by more than
5 µs must follow another event of the board within 60 µs, or be late by at most 10 µs because a command
disables interrupts.  Prints figures, causes and a verdict; the exit code is 1 if one fails.
"""

import argparse
import random
import sys
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from tests.standin.avr_board import HZ, AvrBoard
from tests.standin.metal import Metal
from tests.standin.test_avr import MEGA, UNO

from axistwin.real.standin.events import Failed, Stopped
from axistwin.real.standin.wiring import AxisPins, BoardPin, InputPin

EVENTS = {
    "endstop_event": "input read",
    "trsync_report_event": "trigger report",
    "timer_event": "timer overflow",
    "periodic_event": "event every 0.1 s",
    "digital_load_event": "output",
    "digital_toggle_event": "output",
    "stepper_load_next": "next step command",
    "sched_add_timer": "timer started",
    "command_sendf": "response",
    "__vector_18": "byte received",
    "__vector_19": "byte sent",
    "__vector_25": "byte received",
    "__vector_26": "byte sent",
}
"""The firmware's events that can delay a step; the vectors are those of the serial port."""
FEW, MANY = (2.0, 20.0), (2.0, 45.0)
LATE_US, BEFORE_US, DISABLED_US = 5.0, 60.0, 10.0
NO_EVENT = "NO EVENT"
NAMES = ("plus", "minus", "stop", "home", "a", "b")
INPUTS = tuple(
    InputPin(f"table.{name}", BoardPin(f"PC{n}", pull=1), stops=stops)
    for n, (name, stops) in enumerate(zip(NAMES, (+1, -1, 0, None, None, None), strict=True))
)


class Case(NamedTuple):
    """A measurement: `rate` in pulses/s, `most_us`: largest errors of host and board."""

    name: str
    mcu: str
    axes: tuple[AxisPins, ...]
    inputs: tuple[InputPin, ...]
    rate: float
    most_us: tuple[float, float]


class Figures(NamedTuple):
    """Times of one axis in µs: errors of the planned ticks, and latenesses of the edges."""

    pulses: int
    made: int
    host_us: "np.typing.NDArray[np.float64]"
    board_us: "np.typing.NDArray[np.float64]"
    causes: Counter[str]
    chain: str
    """Events before the latest edge, with their times after the tick at which this edge was due."""


def cases(seed: int) -> list[Case]:
    """Return the measurements."""
    rate, uno, mega = random.Random(seed).uniform(3000, 4000), "atmega328p", "atmega2560"
    limits = INPUTS[:2]
    return [
        Case("328P, no input", uno, (UNO,), (), rate, FEW),
        Case("328P, a limit and an input", uno, (UNO,), (INPUTS[0], INPUTS[3]), rate, FEW),
        Case("328P, three stop inputs and three others", uno, (UNO,), INPUTS, rate, MANY),
        Case("328P, no input", uno, (UNO,), (), 20_000, MANY),
        Case("328P, two limits", uno, (UNO,), limits, 20_000, MANY),
        Case("2560, no input", mega, MEGA, (), 5000, MANY),
        Case("2560, two limits", mega, MEGA, limits, 5000, MANY),
    ]


def measured(case: Case, seconds: float) -> list[Figures]:
    """Move all axes at the same time; return the figures of each."""
    pulses = round(case.rate * seconds)
    board = AvrBoard(case.mcu, {axis.step.name: axis.direction.name for axis in case.axes}, EVENTS)
    for n in range(len(NAMES)):
        board.set(f"PC{n}", 1)
    try:
        metal = Metal(board, axes=case.axes, inputs=case.inputs, outputs=()).start(6.0)
        first = len(metal.lines)
        trains = {axis.axis: metal.even(pulses, case.rate) + 37e-6 * n for n, axis in enumerate(case.axes)}
        metal.move_all({axis: (+1, times) for axis, times in trains.items()}, seconds + 0.3)
        if stops := [event for event in metal.events if isinstance(event, Stopped | Failed)]:
            print(f"{case.name}: {stops}")
        return [figures(metal, axis, trains[axis.axis], first) for axis in case.axes]
    finally:
        board.close()


def figures(metal: Metal, axis: AxisPins, times: "np.typing.NDArray[np.float64]", first: int) -> Figures:
    """Compare the requested times, the planned ticks in the journal and the edges."""
    board = metal.small
    planned = np.array(ticks(metal.lines[first:], axis.axis))
    made = np.array([cycle for cycle, _ in board.pulses[axis.step.name]])
    if not len(planned) == len(made) == len(times):
        return Figures(len(times), len(made), np.empty(0), np.empty(0), Counter(), "")
    host = planned / HZ * 1e6 - times * 1e6
    late = (made - planned) / HZ * 1e6
    offset = np.median(late)
    calls = np.array([cycle for _, cycle in board.calls])
    causes = Counter[str]()
    for edge, by_us in zip(made, late - offset, strict=True):
        if by_us <= LATE_US:
            continue
        some = range(*np.searchsorted(calls, [edge - BEFORE_US * HZ / 1e6, edge]))
        names = sorted({EVENTS[board.calls[n][0]] for n in some})
        causes[" + ".join(names) or ("interrupts disabled" if by_us <= DISABLED_US else NO_EVENT)] += 1
    worst = int(late.argmax())
    begin = float(planned[worst] + offset * HZ / 1e6)
    near = range(*np.searchsorted(calls, [begin - BEFORE_US * HZ / 1e6, made[worst]]))
    chain = ", ".join(f"{EVENTS[board.calls[n][0]]} {(calls[n] - begin) / HZ * 1e6:+.0f} µs" for n in near)
    return Figures(len(times), len(made), host - np.median(host), late - offset, causes, chain)


def ticks(lines: list[str], axis: str) -> list[int]:
    """Return the planned tick of each pulse of an axis, from the journal."""
    found = []
    for kind, *values in (line.split() for line in lines):
        if kind == "pulses" and values[0] == axis:
            tick, interval, count, add = map(int, values[2:])
            for _ in range(count):
                found.append(tick)
                interval += add
                tick += interval
    return found


def report(case: Case, found: Figures, axis: Any) -> bool:
    """Print the figures of an axis; return True if they hold."""
    name = f"{case.name}, {axis.axis} at {case.rate:.0f}/s"
    if found.made != found.pulses:
        print(f"FAILED: {name}: {found.made} of {found.pulses} pulses")
        return False
    host, worst = float(np.abs(found.host_us).max()), float(found.board_us.max())
    most_host, most = case.most_us
    held = host <= most_host and worst <= most and NO_EVENT not in found.causes
    print(f"{'held' if held else 'FAILED'}: {name}: {found.made} of {found.pulses} pulses; host: worst {host:.1f} of "
          f"{most_host:.0f} µs; board: sd {found.board_us.std():.1f}, 99 % {np.percentile(found.board_us, 99):.1f}, "
          f"worst {worst:.1f} of {most:.0f} µs; {sum(found.causes.values())} late edges")  # fmt: skip
    for cause, number in found.causes.most_common(3):
        print(f"    {number} after: {cause}")
    print(f"    before the worst: {found.chain}")
    return held


def main() -> int:
    """Run all measurements."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1.0)
    given, held = parser.parse_args(), True
    for case in cases(given.seed):
        for found, axis in zip(measured(case, given.seconds), case.axes, strict=True):
            held = report(case, found, axis) and held
        sys.stdout.flush()
    print(f"{'held' if held else 'FAILED'}: edge times, seed {given.seed}")
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
