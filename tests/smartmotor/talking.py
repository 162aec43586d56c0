"""A host of a SmartMotor: commands, reports, programs, and virtual time in samples.

Every family's `talking` offers `ready`, `send`, `ask`, `advance`, `until_idle` and `status_word`.
"""

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.sim.serial_port import SerialPort

from .bits import BI

SAMPLE_NS = 245_760
SAMPLE_S = SAMPLE_NS / 1e9
UNIT = 65_536
"""V and A are in 1/65536 count per sample, and per sample²."""
ACKNOWLEDGE, END = b"\x06", b"\xff\xff"

# Motors


def ready(bench: Bench, *, line: str = "instant", state: Path | None = None, **options: Any) -> Controller:
    """Return a SmartMotor without faults, half a second after power-up, with its limit pins as inputs (3.1)."""
    return clear(bench, bench.add("smartmotor", line=line, state=state, **options))


def clear(bench: Bench, motor: Controller) -> Controller:
    """Clear the faults of a motor that has just been switched on; no program starts in the first 200 ms."""
    assert send(bench, motor, b"UCI UDI ZS ", 0.5) == b""
    return motor


def bare(bench: Bench, **options: Any) -> Controller:
    """Return a SmartMotor half a second after power-up, before any command: open limits are a fault (2.0)."""
    motor = bench.add("smartmotor", line="instant", **options)
    bench.run(0.5)
    return motor


def wired(bench: Bench, **options: Any) -> Controller:
    """Return a SmartMotor without faults and with closed limit switches on pins C and D, at a whole sample."""
    motor = ready(bench, **options)
    motor.pins["C"].drive(False)
    motor.pins["D"].drive(False)
    assert send(bench, motor, "UCP UDM ZS RW", 0.01) == b"128\r"
    advance(bench)
    return motor


# Characters


def send(bench: Bench, motor: Controller | SerialPort, what: str | bytes, seconds: float = 0.001) -> bytes:
    """Send a command line with its CR, or the given bytes; return the bytes received within `seconds`."""
    port = motor.serial if isinstance(motor, Controller) else motor
    port.write(what if isinstance(what, bytes) else what.encode("latin-1") + b"\r")
    bench.run(seconds)
    return port.read()


def ask(bench: Bench, motor: Controller | SerialPort, what: str, seconds: float = 0.001) -> str:
    """Send a report command and return its answer without the CR."""
    answer = send(bench, motor, what, seconds)
    assert answer.endswith(b"\r"), answer
    return answer[:-1].decode("latin-1")


def value(bench: Bench, motor: Controller, expression: str) -> int:
    """Return the value of an expression, by PRINT, without advancing time."""
    return int(ask(bench, motor, f"PRINT({expression},#13)", 0))


def values(bench: Bench, motor: Controller, expressions: Iterable[str]) -> list[int]:
    """Return the value of each expression; a string such as "ab" means the variables a and b."""
    return [value(bench, motor, expression) for expression in expressions]


def status_word(bench: Bench, motor: Controller, seconds: float = 0.001, *, ignored: int = BI) -> int:
    """Return RW without the bits in `ignored`; few tests concern index marks, so Bi is ignored by default."""
    return int(ask(bench, motor, "RW", seconds)) & ~ignored


# Time


def advance(bench: Bench, samples: int = 1) -> None:
    """Advance to the nth sample from now."""
    bench.clock.run_to((bench.now // SAMPLE_NS + samples) * SAMPLE_NS)


def until_idle(bench: Bench, motor: Controller, seconds: float = 10.0) -> None:
    """Advance until no trajectory and no program is in progress; fail after `seconds`."""
    busy = motor.registers["RBt"], motor.registers["line"]
    assert bench.run_until(lambda: not any(register.read() for register in busy), seconds)


def positions(bench: Bench, motor: Controller, samples: int) -> list[int]:
    """Return the shaft's position at each of the next samples."""
    found = []
    for _ in range(samples):
        advance(bench)
        found.append(motor.axes["shaft"].position)
    return found


def steps(bench: Bench, motor: Controller, samples: int) -> list[int]:
    """Return the counts by which the shaft turns in each of the next samples."""
    places = [motor.axes["shaft"].position, *positions(bench, motor, samples)]
    return [after - before for before, after in pairwise(places)]


# Programs


def load(bench: Bench, motor: Controller, program: str | bytes, block: int = 8) -> None:
    """Download a program block by block, with its acknowledgements, and check its sum."""
    data = program if isinstance(program, bytes) else program.encode("latin-1")
    assert send(bench, motor, b"LOAD ") == ACKNOWLEDGE
    for at in range(0, len(data), block):
        part = data[at : at + block]
        assert send(bench, motor, part) == (ACKNOWLEDGE if len(part) == block else b"")
    assert send(bench, motor, END + b" ") == b"" and ask(bench, motor, "RCKS").endswith("P")


def run(bench: Bench, motor: Controller, program: str, samples: int = 100) -> None:
    """Download a program, start it with RUN, and advance."""
    load(bench, motor, program.strip() + "\n")
    send(bench, motor, "RUN", 0)
    advance(bench, samples)


def upload(bench: Bench, motor: Controller, command: str = "UPLOAD") -> bytes:
    """Return the bytes that UPLOAD or UP sends before FF, with an acknowledgement for each 8 of them."""
    data = send(bench, motor, command.encode() + b" ")
    while data and not data.endswith(b"\xff"):
        assert len(data) % 8 == 0
        data += send(bench, motor, ACKNOWLEDGE)
    return data.removesuffix(b"\xff")
