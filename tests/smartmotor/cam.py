"""A motor in cam mode: its tables, the master turned to a count, and where chapter 9 puts the shaft then."""

from axistwin import Bench
from axistwin.bench import Controller

SAMPLE_NS = 245_760
TABLE = [0, 250, 500, 250, 0, 500, 1000, 750, 500]
EXAMPLE = """MF4
{f}
D=2000
BASE=8000
SIZE=8
aw[0]=0
aw[1]=250
aw[2]=500
aw[3]=250
aw[4]=0
aw[5]=500
aw[6]=1000
aw[7]=750
aw[8]=500
O=0
MC
G
"""


def say(bench: Bench, motor: Controller, words: str) -> bytes:
    """The host sends this at this very moment; what comes back at once."""
    motor.serial.write(words.encode("latin-1"))
    bench.run(0)
    return motor.serial.read()


def value(bench: Bench, motor: Controller, what: str) -> int:
    """What PRINT says an expression is worth."""
    return int(say(bench, motor, f"PRINT({what},#13) "))


def pass_samples(bench: Bench, count: int = 1) -> None:
    """So many samples; it is exactly at a sample then."""
    bench.clock.run_to((bench.now // SAMPLE_NS + count) * SAMPLE_NS)


def turn_to(bench: Bench, motor: Controller, count: int, per_sample: int = 50) -> int:
    """Turn the master until it has been moved `count` edges in all; where the shaft is after that."""
    way = count - motor.master.count
    needed = -(-abs(way) // per_sample) or 1
    motor.master.move(way, needed * SAMPLE_NS / 1e9)
    pass_samples(bench, needed + 3)
    assert motor.master.count == count
    return motor.axes["shaft"].position


def course(bench: Bench, motor: Controller, counts: list[int], per_sample: int = 50) -> list[int]:
    """The shaft's positions at these counts of the master."""
    return [turn_to(bench, motor, count, per_sample) for count in counts]


def start(bench: Bench, motor: Controller, f: str = "F=16", dwell: int = 2000, mc: str = "MC") -> None:
    """The cam of examples 1 and 2, from the host."""
    table = " ".join(map(str, TABLE))
    say(bench, motor, f"MF4 {f} D={dwell} BASE=8000 SIZE=8 aw[0] {table}. O=0 {mc} G ")
    assert say(bench, motor, "RMODE RBs ") == b"C\r0\r"


def relative(count: int, table: list[int], base: int, dwell: int) -> tuple[int, int]:
    """9.3: the position, times the interval between two entries, and the interval."""
    interval = base // (len(table) - 1)
    cycle, at = divmod(count, base + dwell)
    index, part = divmod(min(at, base), interval)
    step = table[index + 1] - table[index] if part else 0
    return (cycle * table[-1] + table[index]) * interval + part * step, interval
