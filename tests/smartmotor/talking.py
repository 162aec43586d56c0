"""What the tests of the SmartMotor say and look at, in a few words."""

from pathlib import Path
from typing import Any

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.sim.serial_port import SerialPort

ACKNOWLEDGE, END = b"\x06", b"\xff\xff"


def ready(bench: Bench, *, line: str = "instant", state: Path | None = None, **options: Any) -> Controller:
    """A SmartMotor whose limit inputs are inputs, without faults, half a second after it was switched on (3.1)."""
    motor = bench.add("smartmotor", line=line, state=state, **options)
    return clear(bench, motor)


def clear(bench: Bench, motor: Controller) -> Controller:
    """From just switched on to without faults; nothing is started in the first 200 ms."""
    motor.serial.write(b"UCI UDI ZS ")
    bench.run(0.5)
    assert motor.serial.read() == b""
    return motor


def tell(bench: Bench, motor: Controller | SerialPort, text: str | bytes, seconds: float = 0.001) -> bytes:
    """The host sends this, and a CR; what it has received so long after."""
    port = motor.serial if isinstance(motor, Controller) else motor
    port.write((text if isinstance(text, bytes) else text.encode("latin-1")) + b"\r")
    bench.run(seconds)
    return port.read()


def ask(bench: Bench, motor: Controller | SerialPort, text: str, seconds: float = 0.001) -> str:
    """The answer to a report, without its CR."""
    answer = tell(bench, motor, text, seconds)
    assert answer.endswith(b"\r"), answer
    return answer[:-1].decode("latin-1")


def send(bench: Bench, motor: Controller, data: bytes, seconds: float = 0.001) -> bytes:
    """These very bytes, and what comes back."""
    motor.serial.write(data)
    bench.run(seconds)
    return motor.serial.read()


def load(bench: Bench, motor: Controller, program: str | bytes, block: int = 8) -> None:
    """Download a program with its handshake, and see that it is sound."""
    data = program if isinstance(program, bytes) else program.encode("latin-1")
    assert send(bench, motor, b"LOAD ") == ACKNOWLEDGE
    for at in range(0, len(data), block):
        part = data[at : at + block]
        assert send(bench, motor, part) == (ACKNOWLEDGE if len(part) == block else b"")
    assert send(bench, motor, END + b" ") == b""
    assert ask(bench, motor, "RCKS").endswith("P")


def upload(bench: Bench, motor: Controller, command: str = "UPLOAD") -> bytes:
    """What UPLOAD or UP sends, acknowledged 8 bytes by 8 bytes, up to FF."""
    data = send(bench, motor, command.encode() + b" ")
    while data and not data.endswith(b"\xff"):
        assert len(data) % 8 == 0
        data += send(bench, motor, ACKNOWLEDGE)
    return data.removesuffix(b"\xff")
