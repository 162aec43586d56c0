"""Speed of a sequence of 1,000 moves of 25,000 pulses on an 1811, times real time."""

from time import perf_counter

from axistwin import Bench

MOVES, PULSES = 1000, 25_000
GOAL = 10_000
RUNS = 3
PROGRAM = (
    "31 00 00 00 00 61 A8 00 03 D0 90",  # 25,000 pulses/s, 250,000 pulses/s²
    "D9 01",
    "20 01 03 E8",  # the next command 1,000 times
    "33 00 00 61 A8",  # 25,000 pulses
    "D8",
    "41 01",
)


def main() -> None:
    """Print the ratio."""
    ratio, seconds = max(measure() for _ in range(RUNS))
    print(f"{MOVES:,} moves of {PULSES:,} pulses, {seconds:,.0f} s: {ratio:,.0f} times real (goal >= {GOAL:,})")


def measure() -> tuple[float, float]:
    """Return the ratio of virtual to real seconds, and the virtual seconds."""
    bench = Bench()
    board = bench.add("1811")
    bench.run(1.1)
    for command in PROGRAM:
        for byte in bytes.fromhex(command):
            board.bus.write(0, byte)
        board.bus.write(1, 0x10)
        bench.run(0.002)
    motor, began, began_s = board.axes["motor"], perf_counter(), bench.seconds
    while motor.pulses < MOVES * PULSES:
        bench.run(60)
    took = perf_counter() - began
    return (bench.seconds - began_s) / took, bench.seconds - began_s


if __name__ == "__main__":
    main()
