"""An 1811 that has something to do every 2 ms: streaming with 2 ms updates, and stall detection during a move.

Speeds are in times real time, by processor time.  The reference is the same board in a move without stall detection.
"""

import sys
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))
sys.path.insert(0, str(Path(__file__).resolve().parent))

from streaming_hour import command, refill

from axistwin import Bench
from axistwin.bench import Controller

RUNS = 3
PERIOD_MS = 2
SECONDS = 30
SWITCHES = {"limits": (-1_000_000_000, 1_000_000_000)}
ENCODER = {"counts_per_rev": 4000, "pulses_per_rev": 25_000}
TRACKING = (
    "B0 61 A8 0F A0",  # 25,000 motor pulses are 4,000 encoder pulses
    "B1 00 00 61 A8",  # pulses per revolution
    "B2 00 00 00 00",  # backlash
    "B4 00 00 00 32",  # rotor teeth
    "19 01",  # a stall ends the move
)
MOVE = ("31 00 00 00 00 13 88 00 03 D0 90", "32 00")  # 5,000 pulses/s, continuous


def main() -> None:
    """Print the speeds."""
    host, switches = (max(refilled(SECONDS, axis) for _ in range(RUNS)) for axis in ({}, SWITCHES))
    buffer = max(buffered() for _ in range(RUNS))
    print(f"streaming with {PERIOD_MS} ms updates and a host that refills: {host:.0f} times real (goal >= 200)")
    print(f"  the stored buffer without the host: {buffer:.0f} times real")
    print(f"  with limit switches, which follow each velocity: {switches:.0f} times real")
    plain, watched = (max(moving(first) for _ in range(RUNS)) for first in ((), TRACKING))
    asked = max(moving(TRACKING, SECONDS, ask_every=0.01) for _ in range(RUNS))
    print(f"stall detection in motion: {watched:,.0f} times real (goal >= 1,000)")
    print(f"  the same move without stall detection: {plain:,.0f} times real")
    print(f"  with a host that asks for the state of the motor 100 times a second: {asked:,.0f} times real")


def streaming(axis: dict[str, object]) -> tuple[Bench, Controller, int]:
    """Return a board in velocity-time mode with a full buffer, and the last velocity."""
    bench = Bench()
    board = bench.add("1811", motor=axis)
    bench.run(1.1)
    command(bench, board, 0x52, 2, 4, 0, 0, 0xFF, 0xFF, *PERIOD_MS.to_bytes(2, "big"))
    return bench, board, refill(bench, board, 0x1000)


def refilled(seconds: float, axis: dict[str, object]) -> float:
    """Return the speed of a stream with a host that refills the buffer."""
    bench, board, velocity = streaming(axis)
    command(bench, board, 0x42)
    began, end = process_time(), bench.seconds + seconds
    while bench.seconds < end:
        velocity = refill(bench, board, velocity)
        bench.run(PERIOD_MS / 1000 * 100)
    assert board.axes["motor"].moving
    return seconds / (process_time() - began)


def buffered() -> float:
    """Return the speed of the output of the 210 velocities in a full buffer."""
    bench, board, _ = streaming({})
    command(bench, board, 0x42)
    began, since = process_time(), bench.seconds
    bench.run(0.4)
    assert board.axes["motor"].velocity, "it does not move"
    return (bench.seconds - since) / (process_time() - began)


def moving(first: tuple[str, ...], seconds: float = 3600.0, ask_every: float = 3600.0) -> float:
    """Return the speed of a continuous move after these commands, in which a host asks for the state now and then."""
    bench = Bench()
    board = bench.add("1811", motor={"encoder": ENCODER})
    bench.run(1.1)
    for text in (*first, *MOVE):
        command(bench, board, *bytes.fromhex(text))
    bench.run(1)
    began, since = process_time(), bench.seconds
    while bench.seconds < since + seconds:
        bench.run(ask_every)
        state(bench, board)
    took = process_time() - began
    assert board.axes["motor"].velocity == 5000, "it does not move"
    return (bench.seconds - since) / took


def state(bench: Bench, board: Controller) -> int:
    """Return the state of the motor (88h)."""
    command(bench, board, 0x88)
    bench.run_until(lambda: board.bus.read(1) & 0x08, 1)
    message = [board.bus.read(0) for _ in range(16)]
    board.bus.write(1, 0x80)
    return message[1]


if __name__ == "__main__":
    main()
