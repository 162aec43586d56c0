"""A SmartMotor's stored program, from its source in an `.sms` file: put into the motor, and started.

It is loaded over the motor's serial port as by any host, in no time, before anybody looks; then the motor is switched
off and on again.  Comments are not sent.
"""

from pathlib import Path

from axistwin.apps.machine import motor_of
from axistwin.bench import Bench, Controller
from axistwin.errors import ProgramError, UsageError
from axistwin.sim.serial import SerialPort

ACKNOWLEDGE = b"\x06"
END = b"\xff\xff"
READY = b"UCI UDI ZS "
"""An unwired motor is in a limit fault, in which it takes no program."""


def load_source(path: Path) -> bytes:
    """The text of a source file as it is sent: lines ended by LF, what is no ASCII (in comments) as `?`.

    Raises UsageError if it cannot be read.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from None
    lines = data.decode("latin-1").splitlines()  # files of that age are in all kinds of 8-bit codes
    return "".join(f"{line.expandtabs(1)}\n" for line in lines).encode("ascii", "replace")


def store_program(source: bytes, file: str, bench: Bench) -> None:
    """Load it into the only motor on the bench, and switch that off and on.  Raises ProgramError if it is not taken."""
    motor = only_motor(bench, file)
    port = motor.serial
    instant, port.instant = port.instant, True
    try:
        _load(port, source, file)
    finally:
        port.instant = instant
    motor.power_cycle()
    port.read()


def only_motor(bench: Bench, file: str) -> Controller:
    """The motor that a source file is for."""
    found = [controller for controller in bench.controllers.values() if motor_of(controller) is not None]
    if len(found) != 1:
        raise ProgramError(
            f"a stored program is for one SmartMotor, here are {len(found)}: write a conversation (.talk)", file=file
        )
    return found[0]


def _load(port: SerialPort, source: bytes, file: str) -> None:
    """By the protocol of LOAD: the motor asks with 06 for each block, whose length is its own affair."""
    port.write(READY + b"LOAD ")
    if not port.read().endswith(ACKNOWLEDGE):
        raise ProgramError("the motor takes no program: it does not answer LOAD", file=file)
    port.write(source + END + b"RCKS\r")
    if not port.read().endswith(b"P\r"):
        raise ProgramError("the motor has no room for it: give it a larger option program_bytes", file=file)
