"""Motors in a cam, in host mode and with interrupt routines, for the tests of several chapters."""

from axistwin import Bench
from axistwin.bench import Controller

from .bits import BITS
from .talking import SAMPLE_NS, advance, ask, run, send, value, wired

# Cam (chapter 9)

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


def turn_to(bench: Bench, motor: Controller, count: int, per_sample: int = 50) -> int:
    """Turn the external encoder to a count; return the shaft's position at that count."""
    distance = count - motor.master.count
    needed = -(-abs(distance) // per_sample) or 1
    motor.master.move(distance, needed * SAMPLE_NS / 1e9)
    advance(bench, needed + 3)
    assert motor.master.count == count
    return motor.axes["shaft"].position


def turn_through(bench: Bench, motor: Controller, counts: list[int], per_sample: int = 50) -> list[int]:
    """Turn the external encoder to each count; return the shaft's positions."""
    return [turn_to(bench, motor, count, per_sample) for count in counts]


def cam(f: str = "F=16", dwell: int = 2000, mc: str = "MC") -> str:
    """Return the commands that start the cam of examples 1 and 2 from the host."""
    table = " ".join(map(str, TABLE))
    return f"MF4 {f} D={dwell} BASE=8000 SIZE=8 aw[0] {table}. O=0 {mc} G"


def start_cam(bench: Bench, motor: Controller, f: str = "F=16", dwell: int = 2000, mc: str = "MC") -> None:
    send(bench, motor, cam(f, dwell, mc), 0)
    assert send(bench, motor, "RMODE RBs", 0) == b"C\r0\r"


def relative(count: int, table: list[int], base: int, dwell: int) -> tuple[int, int]:
    """Return `interval` times the position that 9.3 defines at this count, and `interval` (to avoid fractions)."""
    interval = base // (len(table) - 1)
    cycle, at = divmod(count, base + dwell)
    index, part = divmod(min(at, base), interval)
    step = table[index + 1] - table[index] if part else 0
    return (cycle * table[-1] + table[index]) * interval + part * step, interval


# Host mode (chapter 10)


def position(counts: int) -> str:
    """Return a position record: 0xFA, four bytes, the most significant first, CR (10.1)."""
    return "\xfa" + (counts & 0xFFFF_FFFF).to_bytes(4).decode("latin-1") + "\r"


def clock(samples: int) -> str:
    """Return a clock record: 0xFB, four bytes, the most significant first, CR (10.1)."""
    return "\xfb" + (samples & 0xFFFF_FFFF).to_bytes(4).decode("latin-1") + "\r"


def points(*pairs: tuple[int, int]) -> str:
    """Return a position and a clock record for each pair."""
    return "".join(position(counts) + clock(samples) for counts, samples in pairs)


def start_host_mode(bench: Bench, motor: Controller, before: str, records: str) -> None:
    """Send commands, MD, records and G; the clock of host mode begins at the next sample."""
    for what in (before + "MD", records, "G"):
        assert send(bench, motor, what, 0) == b""


# C1 and C2 (chapter 7)

COUNTING = """
UGI
WHILE 1
m=m+1
LOOP
END
C1
c=CLK
i=i+1
RETURNF
C2
g=CLK
j=j+1
RETURNI
"""


def trigger(bench: Bench, motor: Controller, low: int = 20, high: int = 20) -> None:
    """Drive pin G low for `low` samples, and then high for `high` samples."""
    motor.pins["G"].drive(False)
    advance(bench, low)
    motor.pins["G"].drive(True)
    advance(bench, high)


def open_limit(bench: Bench, motor: Controller) -> None:
    motor.pins["C"].release()
    advance(bench, 3)


def jam(bench: Bench, motor: Controller) -> None:
    """Jam the shaft for 110 samples; at 10 counts per sample the position error exceeds E=1000 in the 101st."""
    motor.axes["shaft"].jam(True)
    advance(bench, 110)
    motor.axes["shaft"].jam(False)


def delays(**options) -> tuple[int, int]:
    """Return the samples from the cause to the first statement of C1 and of C2."""
    found = []
    for functions, pin, name in ((32, "C", "c"), (64, "G", "g")):
        bench = Bench()
        motor = wired(bench, **options)
        run(bench, motor, f"F={functions}{COUNTING}")
        start = int(ask(bench, motor, "RCLK", 0))
        motor.pins[pin].drive(pin == "C")
        advance(bench, 50)
        found.append(value(bench, motor, name) - start)
    return found[0], found[1]


def main_with(c2: str) -> str:
    """Return a program that increments m; its C2 increments j and then executes the lines `c2`; C9 is a jump target."""
    return f"""
UGI
F=64
WHILE 1
m=m+1
LOOP
END
C9
k=k+1
WHILE 1
n=n+1
LOOP
END
C2
j=j+1
{c2}
"""


# The status word


def all_bits(bench: Bench, motor: Controller) -> str:
    """Return the letters of the bits of RW that are 1, least significant first; RBx, RS and RPW must agree."""
    word = int(ask(bench, motor, "RW", 0))
    assert int(ask(bench, motor, "RS", 0)) == word & 0xFF and ask(bench, motor, "RPW", 0).split(",")[1] == str(word)
    singly = send(bench, motor, "".join(f"RB{letter} " for letter in BITS), 0).split()
    assert [int(bit) for bit in singly] == [int(word & value > 0) for value in BITS.values()]
    return "".join(letter for letter, value in BITS.items() if word & value)
