"""Computing time of a trace of all signals: a moving, polled controller of each family, traced and untraced.

The IF1 and the 1811 repeat moves, the SmartMotor runs a program, with servo and motor physics; a host requests all
three positions ten times a second.
"""

import sys
import tempfile
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.records.traces.signals import EVERYTHING
from axistwin.records.traces.trace import tracing

SECONDS, RUNS = 60, 3
GOAL = 3.0
SEQUENCE = ":X400@2000S1:P0,20:X-R1:P0,20:Y100S2:Y-R2:=0,1:$\r"
MOVES = ("31 00 00 00 00 13 88 00 03 D0 90", "D9 01", "20 01 FF FF", "33 00 00 03 E8", "D8", "41 01")
PROGRAM = "UCI UDI ZS A=100 V=400000 MP O=0 C1 P=4000 G TWAIT a=a+1 WAIT=800 P=0 G TWAIT b=@P WAIT=800 GOTO1 "


def main() -> None:
    """Print the ratios."""
    run(None, "default")  # the kernels are compiled before the measurement
    for suffix, signals in (("csv", "default"), ("vcd", "default"), ("parquet", "default"), ("parquet", EVERYTHING)):
        rows, ratio = min((measured(suffix, signals) for _ in range(RUNS)), key=lambda found: found[1])
        what = "everything" if signals == EVERYTHING else "pins, axes and streams"
        print(f"tracing {what} into .{suffix}, {rows / 1e6:.1f} MB: {ratio:.2f} times the time (goal <= {GOAL:g})")


def measured(suffix: str, signals: str) -> tuple[int, float]:
    """Return the bytes written, and the ratio of traced to untraced time."""
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / f"a.{suffix}"
        traced, plain = run(path, signals), run(None, signals)
        return path.stat().st_size, traced / plain


def run(path: Path | None, signals: str) -> float:
    """Return the seconds of one run."""
    bench, hosts = at_work()
    began = perf_counter()
    if path is None:
        session(bench, hosts)
    else:
        with tracing(bench, path, (signals,)):
            session(bench, hosts)
    return perf_counter() - began


def session(bench: Bench, hosts: list[Controller]) -> None:
    """Run a host that polls ten times a second."""
    if1, board, motor = hosts
    for _ in range(10 * SECONDS):
        if1.serial.write(b"E\r")
        command(board, "83")
        motor.serial.write(b"RP ")
        bench.run(0.1)
        if1.serial.read(), motor.serial.read()
        while board.bus.read(1) & 8:
            for _ in range(16):
                board.bus.read(0)
            board.bus.write(1, 0x80)
            bench.run(0.002)


def at_work() -> tuple[Bench, list[Controller]]:
    """Return three controllers in endless motion."""
    bench = Bench()
    if1, board = bench.add("if1"), bench.add("1811")
    motor = bench.add("smartmotor", "motor", shaft={"motor": "frame23"})
    bench.run(1.6)
    for message in ("(", "U61\r", SEQUENCE):
        if1.serial.write(message.encode())
        bench.run(1.2)
    for text in MOVES:
        command(board, text)
        bench.run(0.02)
    load(bench, motor)
    for axis in (if1.axes["X"], board.axes["motor"], motor.axes["shaft"]):
        assert bench.run_until(lambda axis=axis: axis.moving, 10)
    return bench, [if1, board, motor]


def load(bench: Bench, motor: Controller) -> None:
    """Download the motor's program in blocks of 8 bytes, and start it."""
    motor.serial.write(b"UCI UDI ZS LOAD ")
    data = PROGRAM.encode() + b"\xff\xff"
    for at in range(0, len(data), 8):
        bench.run(0.1)
        motor.serial.write(data[at : at + 8])
    bench.run(0.1)
    motor.serial.write(b" RUN ")
    bench.run(0.5)


def command(board: Controller, text: str) -> None:
    """Write a command string, as a host does."""
    for byte in bytes.fromhex(text):
        board.bus.write(0, byte)
    board.bus.write(1, 0x10)


if __name__ == "__main__":
    main()
