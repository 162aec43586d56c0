"""Load a SmartMotor's stored program from its source in an `.sms` file, and start it.

The program is loaded over the motor's serial port in zero time, before observers are connected.  Then the motor's power
is cycled.  Comments are not sent.
"""

import re
from pathlib import Path

from axistwin.bench import Bench, Controller, line_format
from axistwin.bench.actions import motor_of
from axistwin.bench.talk.conversation import END_OF_FILE, MOST_MIB
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.storage import contents, encoding_of, split_at_end
from axistwin.sim.serial_port import SerialPort

ACKNOWLEDGE = b"\x06"
END = b"\xff\xff"
READY = b"UCI UDI ZS "  # Clears the limit fault of an unwired motor, in which it accepts no program.
_line_end = re.compile(r"\r\n|[\r\n\v\f]")
_foreign = re.compile(r"[^\0-\x1b\x1f-\x7f]")
_odd_end = re.compile("[\x1c-\x1e\x85\u2028\u2029]")  # Characters that end a line in Python, but not in a motor.
_code = re.compile(r"""(?:"[^"]*(?:"|$)|[^"'])*""")


def load_source(path: Path) -> bytes:
    """Read a source file as the bytes for the motor.  Raises UsageError if it cannot be read."""
    return as_sent(read_source(path))


def read_source(path: Path) -> str:
    """Return the text of a source file, with LF after each line.  Raises UsageError if the file cannot be read."""
    data, _ = split_at_end(contents(path, MOST_MIB))
    try:
        return _lines(data.decode(encoding_of(data)))
    except UnicodeDecodeError as error:
        raise UsageError(f"{path} cannot be read as {error.encoding}: expected a text file") from None


def as_sent(text: str) -> bytes:
    """Convert source text to bytes: each line ends in LF, each non-ASCII character becomes `?`."""
    return _foreign.sub("?", _lines(text)).encode()


def _lines(text: str) -> str:
    lines = _line_end.split(text.partition(END_OF_FILE)[0])
    if not lines[-1]:
        lines.pop()  # A program that ends with LF has an empty last line, which is not sent to the motor.
    return "".join(f"{_odd_end.sub('?', line.expandtabs(1))}\n" for line in lines)


def store_program(source: bytes, file: str, bench: Bench) -> None:
    """Load a program into the only SmartMotor, and cycle its power.  Raises ProgramError if it is refused."""
    store(source, file, only_motor(bench, file))


def check_motor(controller: Controller) -> None:
    """Raise UsageError if the controller is not a SmartMotor."""
    if motor_of(controller) is None:
        raise UsageError(f"{controller.name} cannot store a program: expected a SmartMotor")


def check(source: bytes, file: str, controller: Controller) -> None:
    """Raise UsageError or ProgramError if an equal motor on a bench of its own refuses the program."""
    check_motor(controller)
    if controller.name not in controller.ports:
        raise UsageError(
            f"{controller.name} shares its serial line with other motors: expected a motor with its own serial line"
        )
    store(source, file, Bench().add(controller.product.model, controller.name, **controller.given))


def store(source: bytes, file: str, motor: Controller) -> None:
    """Load a source into this motor, and cycle its power.  Raises ProgramError if refused."""
    port = motor.serial
    instant, port.instant = port.instant, True
    try:
        _load(port, source, file)
    finally:
        port.instant = instant
    motor.power_cycle()
    port.read()


def run(source: bytes, file: str, motor: Controller) -> None:
    """Cycle a motor's power, load a source in the default line format and run it.  Raises ProgramError if refused."""
    port, usual = motor.serial, motor.product.line
    assert usual is not None, "a motor has a serial port"
    port.drop_pending()
    port.host.format = line_format(motor.given.get("line"), usual)[0]
    motor.power_cycle()
    store(source, file, motor)
    port.write(b"RUN\r")


def only_motor(bench: Bench, file: str) -> Controller:
    """Return the only SmartMotor.  Raises ProgramError if there is none, or several."""
    motors = [controller for controller in bench.controllers.values() if motor_of(controller) is not None]
    if len(motors) != 1:
        raise ProgramError(
            f"the simulation has {len(motors)} SmartMotors, but an .sms file needs exactly one: use a .talk file",
            file=file,
        )
    motor = motors[0]
    if motor.name not in motor.ports:
        raise ProgramError(
            f"cannot load an .sms file into {motor.name} on a shared serial line: "
            "use a .talk file, or connect the motor to a separate line",
            file=file,
        )
    return motor


def _load(port: SerialPort, source: bytes, file: str) -> None:
    """Send a program by LOAD; the motor requests each block with the byte 06.  Raises ProgramError if it is refused."""
    port.write(READY + b"LOAD ")
    if not port.read().endswith(ACKNOWLEDGE):
        host_format = port.host.format
        raise ProgramError(
            f"the motor did not send the byte 06 after LOAD: check that the motor uses the line format {host_format}",
            file=file,
        )
    sent = _without_comments(source)
    port.write(sent + END + b"RCKS\r")
    if not port.read().endswith(b"P\r"):
        raise ProgramError(
            f"the program has {len(sent)} bytes, too many for the program memory of the motor: "
            "shorten the program, or increase the option program_bytes",
            file=file,
        )


def _without_comments(source: bytes) -> bytes:
    found = (_code.match(line) for line in source.decode().splitlines())
    lines = (match[0].rstrip(" ") for match in found if match is not None)
    return "".join(f"{line}\n" for line in lines if line).encode()
