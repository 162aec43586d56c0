"""Speed of an hour of streaming with a refilled buffer, times real time."""

import sys
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench
from axistwin.bench import Controller

HOUR = 3600
PERIOD_MS = 100
LEAST_FREE = 200  # bytes: then the host refills


def command(bench: Bench, board: Controller, *data: int) -> None:
    """Write a command string, as a host does."""
    bench.run_until(lambda: board.bus.read(1) & 0x10, 1)
    for byte in data:
        board.bus.write(0, byte)
    board.bus.write(1, 0x10)


def free_bytes(bench: Bench, board: Controller) -> int:
    """Return the free bytes of the streaming buffer (E2h)."""
    command(bench, board, 0xE2)
    bench.run_until(lambda: board.bus.read(1) & 0x08, 1)
    message = [board.bus.read(0) for _ in range(16)]
    board.bus.write(1, 0x80)
    return int.from_bytes(message[1:5], "big")


def refill(bench: Bench, board: Controller, velocity: int) -> int:
    """Write E1h commands, seven velocities each, until the buffer is full; return the last velocity."""
    for _ in range(free_bytes(bench, board) // 20):
        velocities = [velocity + 16 * k for k in range(7)]
        command(bench, board, 0xE1, *(byte for v in velocities for byte in v.to_bytes(2, "big")))
        velocity = 0x1000 + (velocities[-1] - 0x1000 + 16) % 0x2000
    return velocity


def main() -> None:
    """Print the ratio."""
    bench = Bench()
    board = bench.add("1811")
    bench.run(1.1)
    command(bench, board, 0x52, 2, 4, 0, 0, 0xFF, 0xFF, *PERIOD_MS.to_bytes(2, "big"))
    velocity = refill(bench, board, 0x1000)
    command(bench, board, 0x42)
    begin, end = perf_counter(), bench.seconds + HOUR
    while bench.seconds < end:
        velocity = refill(bench, board, velocity)
        bench.run(PERIOD_MS / 1000 * LEAST_FREE / 2)
    took, axis = perf_counter() - begin, board.axes["motor"]
    assert axis.moving
    print(f"an hour of streaming, {PERIOD_MS} ms per velocity: {HOUR / took:,.0f} times real (goal >= 1,000)")
    print(f"  {axis.position:,} pulses, {took / (HOUR * 1000 / PERIOD_MS) * 1e6:.0f} µs per velocity")


if __name__ == "__main__":
    main()
