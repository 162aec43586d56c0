"""What the tests of C1 and C2 share: time in samples, a wired motor with its program running, edges on pins."""

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ask, load, ready, tell

SAMPLE_NS = 245_760

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


def samples(bench: Bench, count: int) -> None:
    """To a whole sample, and so many further."""
    bench.clock.run_to((-(-bench.now // SAMPLE_NS) + count) * SAMPLE_NS)


def wired(bench: Bench, **options) -> Controller:
    """Limit switches on pins C and D, closed; no faults."""
    motor = ready(bench, **options)
    motor.pins["C"].drive(False)
    motor.pins["D"].drive(False)
    tell(bench, motor, "UCP UDM ZS", 0.01)
    assert ask(bench, motor, "RW") == "128"
    return motor


def running(bench: Bench, motor: Controller, program: str) -> None:
    """The program runs, for a hundred samples already, and the motor stands at a whole sample."""
    load(bench, motor, program.strip() + "\n")
    tell(bench, motor, "RUN", 0)
    samples(bench, 100)


def values(bench: Bench, motor: Controller, names: str) -> list[int]:
    answer = tell(bench, motor, " ".join(f"R{name}" for name in names), 0)
    return [int(value) for value in answer.split()]


def value(bench: Bench, motor: Controller, name: str) -> int:
    return values(bench, motor, name)[0]


def fault(bench: Bench, motor: Controller, on: bool = True) -> None:
    """The positive limit switch opens."""
    motor.pins["C"].drive(on)


def trigger(bench: Bench, motor: Controller, low: int = 20, high: int = 20) -> None:
    """Pin G low for so many samples, and high again."""
    motor.pins["G"].drive(False)
    samples(bench, low)
    motor.pins["G"].drive(True)
    samples(bench, high)


def delays(**options) -> tuple[int, int]:
    """Samples from the cause to the first statement of C1 and of C2."""
    found = []
    for functions, pin, name in ((32, "C", "c"), (64, "G", "g")):
        bench = Bench()
        motor = wired(bench, **options)
        running(bench, motor, f"F={functions}{COUNTING}")
        start = int(ask(bench, motor, "RCLK", 0))
        motor.pins[pin].drive(pin == "C")
        samples(bench, 50)
        found.append(value(bench, motor, name) - start)
    return found[0], found[1]


def main_with(c2: str) -> str:
    """A main program that counts m, C2 that counts j and then does this, and a place C9 to go to."""
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
