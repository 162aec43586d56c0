"""Legacy hosts drive the stand-in through a pseudo terminal, in real time: BASIC programs, and a host with pyserial.

    python benchmarks/robustness/stand_in_hosts.py [--programs 1 2 ... 11] [--no-pyserial]

`axistwin stand-in` emulates an IF1 (program 6: an IF2) on a pseudo terminal; a simulated board in another process makes
the pulses.  The hosts are the sample programs of the manual's appendix 3 on PC-BASIC, as the tests run them, and a
program with pyserial.  The moves at the pins of the board must be those that the program orders.  Programs 3, 6 and 9
store a sequence that input 1 starts and repeats; the board's input 1 is closed.  Reads the manual; prints the moves and
a verdict; the exit code is 1 if one fails.
"""

import argparse
import asyncio
import os
import sys
import tempfile
import time
from itertools import cycle, islice
from pathlib import Path

import serial

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.basic.hosting import KEYS
from tests.basic.interpreter import run_basic
from tests.basic.listings import runnable, source
from tests.basic.test_sample_programs import FORTH_AND_TEN_TIMES_BACK_AND_FORTH, PASSES
from tests.standin.command import StandInCommand

PINS = {"X": (2, 3), "Y": (5, 6), "Z": (11, 12)}
SCENE = """
[[controller]]
model = "{model}"
name = "table"
line = "{line}"
options = {{ self_test_s = 0.2 }}
ports = ["pty:{folder}/host"]

[stand-in]
horizon_ms = 500
watchdog_ms = 500

[[stand-in.board]]
name = "small"
port = "board"

[[stand-in.input]]
to = "table.input1"
pin = "P9"
""" + "".join(
    f"""
[[stand-in.axis]]
axis = "table.{axis}"
step = "P{step}"
direction = "P{direction}"
enable = "!P4"
"""
    for axis, (step, direction) in PINS.items()
)
LINES = {0: "9600 8N1", 1: "9600 8N2", 3: "1200 8N2", 5: "4800 8N2", 8: "9600 8N2", 10: "9600 8N2"}
READING_S, AT_REST_S, LONGEST_S, SEQUENCE_S = 1.5, 4.0, 120.0, 45.0
SHOWN = 6
Moves = list[dict[str, int]]
Pulses = dict[str, list[tuple[int, int]]]
"""Tick and direction of each pulse, by step pin."""
GAP_TICKS, START_TICKS, EACH = 96_000, 80_000, 1000
"""Pause between two moves, 6 ms; difference of the starts of two axes, 5 ms; pulses of each move of a sequence."""
SEVEN = [{"X": 1000}, {"Y": 1000}, {"X": -1000}, {"Y": -1000}]
ELEVEN = [*SEVEN, {"X": 5000, "Y": 5000}, {"X": -5000, "Y": -5000}]
TEN = [*FORTH_AND_TEN_TIMES_BACK_AND_FORTH, {"X": 5000, "Y": 500}, {"X": -5000, "Y": -500}]
JOINED = [*FORTH_AND_TEN_TIMES_BACK_AND_FORTH[:-1], {"X": 6000, "Y": 500}, {"X": -5000, "Y": -500}]
"""Moves of program 10 if no pause separates the last move of its loop from the next move."""
EXPECTED = dict.fromkeys((1, 2, 4, 5, 8), FORTH_AND_TEN_TIMES_BACK_AND_FORTH) | {7: SEVEN, 10: TEN, 11: ELEVEN}


class StandIn(StandInCommand):
    """The command with an interface at a pseudo terminal.  `terminal`: the host's device."""

    def __init__(self, folder: Path, model: str, line: str) -> None:
        super().__init__(folder, SCENE.format(model=model, line=line, folder=folder))
        self.terminal = folder / "host"
        time.sleep(0.5)

    def wait_for_rest(self) -> None:
        """Wait until no pulse has been sent for some seconds."""
        ends, size, since = time.monotonic() + LONGEST_S, 0, time.monotonic()
        while time.monotonic() < min(ends, since + AT_REST_S):
            time.sleep(0.1)
            if (now := self.journal.stat().st_size) != size:
                size, since = now, time.monotonic()


def moves(made: Pulses) -> Moves:
    """Return the moves in order: the net pulses of the axes that moved together.  A pause separates two moves."""
    every = sorted((tick, axis, way) for axis, (pin, _) in PINS.items() for tick, way in made.get(str(pin), ()))
    found: Moves = []
    last = 0
    for tick, axis, way in every:
        if not found or tick - last > GAP_TICKS:
            found.append({})
        found[-1][axis] = found[-1].get(axis, 0) + way
        last = tick
    return found


def sequence_moves(made: Pulses) -> Moves:
    """Return the moves of a sequence, which have no pauses: 1000 pulses of each axis, with a common start."""
    parts = []
    for axis, (pin, _) in PINS.items():
        pulses = made.get(str(pin), [])
        for first in range(0, len(pulses), EACH):
            some = pulses[first : first + EACH]
            parts.append((some[0][0], axis, sum(way for _, way in some)))
    found: Moves = []
    last = -GAP_TICKS
    for tick, axis, net in sorted(parts):
        if tick - last > START_TICKS:
            found.append({})
        found[-1][axis] = net
        last = tick
    return found


def basic(program: int, stand_in: StandIn, folder: Path) -> str:
    """Run a sample program on PC-BASIC; return an error message, or ""."""

    async def read() -> None:
        await asyncio.sleep(READING_S)

    home = folder / "basic"
    home.mkdir()
    com1 = f"PORT:{os.path.realpath(stand_in.terminal)}"
    try:
        screen = asyncio.run(run_basic(source(runnable(program)), com1, KEYS, read, home, seconds=LONGEST_S))
    except AssertionError as error:
        return str(error)
    if program in PASSES:
        time.sleep(SEQUENCE_S)
    else:
        stand_in.wait_for_rest()
    return screen if "rror" in screen or "imeout" in screen else ""


def pyserial(stand_in: StandIn) -> str:
    """Move the axes with pyserial, as a host of today does; return an error message, or ""."""
    with serial.Serial(str(stand_in.terminal), 9600, timeout=5) as host:
        for text, seconds in ((b"(", 0.3), (b"U61\r", 1.5)):
            host.write(text)
            time.sleep(seconds)
        for text in (b"X2000 @ 4000 $ \r", b"X-Y+700 @ 1000 $ \r", b"Z-30 $ \r"):
            host.write(text)
            time.sleep(2.0)
        host.reset_input_buffer()
        host.write(b"N\r")
        answer = host.read_until(b"\r")
        stand_in.wait_for_rest()
    return "" if answer == b"30\r" else f"N was answered by {answer!r}"


def run(program: int) -> tuple[Moves, str]:
    """Run a host, 0: pyserial; return the moves at the pins, and error messages."""
    model, line = "if2" if program == 6 else "if1", LINES.get(program, "2400 8N2")
    with tempfile.TemporaryDirectory() as folder:
        stand_in = StandIn(Path(folder), model, line)
        try:
            wrong = basic(program, stand_in, Path(folder)) if program else pyserial(stand_in)
        finally:
            made: Pulses = stand_in.close()["pulses"]
            stops = [line for line in stand_in.stops() if not line.endswith("end of the run")]
    return (sequence_moves if program in PASSES else moves)(made), "\n".join([wrong, *stops])


PYSERIAL = [{"X": 2000}, {"X": -700, "Y": 700}, {"Z": -30}]


def expected(program: int, number: int) -> Moves:
    """Return the moves that a program orders; `number`: of a sequence that repeats for ever, return so many."""
    return list(islice(cycle(PASSES[program]), number)) if program in PASSES else EXPECTED[program]


def written(made: Moves) -> str:
    """Return the number of moves, and the first ones as text."""
    texts = ["/".join(f"{axis}{net:+d}" for axis, net in sorted(move.items())) for move in made[:SHOWN]]
    return f"{len(made)} moves: {' '.join(texts)}{' ...' if len(made) > SHOWN else ''}"


def main() -> int:
    """Run the hosts."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--programs", type=int, nargs="*", default=list(range(1, 12)))
    parser.add_argument("--no-pyserial", action="store_true")
    given, held = parser.parse_args(), True
    for program in [*given.programs, *([] if given.no_pyserial else [0])]:
        made, wrong = run(program)
        wanted = PYSERIAL if not program else expected(program, max(len(made) - 1, 0))
        found = made[: len(wanted)] if program in PASSES else made
        good = not wrong and len(made) > 2 and (found == wanted or (program == 10 and found == JOINED))
        held = held and good
        name = f"program {program}" if program else "pyserial"
        print(f"{'held' if good else 'FAILED'}: {name}: {written(made)} {wrong}", flush=True)
    print("held: every move at the pins is one of the host's" if held else "FAILED")
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
