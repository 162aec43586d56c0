"""A SmartMotor's stored program, from its source in an `.sms` file: put into the motor, and started.

It is loaded over the motor's serial port as by any host, in no time, before anybody looks; then the motor is switched
off and on again.  Comments are not sent.
"""

import codecs
import re
from pathlib import Path

from axistwin.bench import Bench, Controller, line_format
from axistwin.bench.actions import motor_of
from axistwin.errors import ProgramError, UsageError
from axistwin.sim.serial_port import SerialPort

ACKNOWLEDGE = b"\x06"
END = b"\xff\xff"
READY = b"UCI UDI ZS "
"""An unwired motor is in a limit fault, in which it takes no program."""
MARKS = {
    codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16",
}  # fmt: skip
"""What today's editors put in front of a text; files of that age are in all kinds of 8-bit codes."""
END_OF_FILE = "\x1a"
"""Ctrl-Z, with which editors of that age ended a file."""
_line_end = re.compile(r"\r\n|[\r\n\v\f]")
_foreign = re.compile(r"[^\0-\x1b\x1f-\x7f]")
_code = re.compile(r"""(?:"[^"]*(?:"|$)|[^"'])*""")


def load_source(path: Path) -> bytes:
    """The text of a source file as it is sent.

    Raises UsageError if it cannot be read.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from None
    try:
        text = data.decode(next((code for mark, code in MARKS.items() if data.startswith(mark)), "latin-1"))
    except UnicodeDecodeError as error:
        raise UsageError(
            f"{path} cannot be read: it begins like {error.encoding} and is not: save it as text"
        ) from None
    return as_sent(text)


def as_sent(text: str) -> bytes:
    """The text of a source as it is sent: lines ended by LF, what is no ASCII (in comments) as `?`."""
    lines = _line_end.split(text.partition(END_OF_FILE)[0])
    if not lines[-1]:
        lines.pop()  # there is nothing behind the end of the last line
    return "".join(f"{_foreign.sub('?', line.expandtabs(1))}\n" for line in lines).encode()


def store_program(source: bytes, file: str, bench: Bench) -> None:
    """Load it into the only motor on the bench, and switch that off and on.  Raises ProgramError if it is not taken."""
    store(source, file, only_motor(bench, file))


def check_motor(controller: Controller) -> None:
    """Raises UsageError if it has no place for a stored program."""
    if motor_of(controller) is None:
        raise UsageError(f"{controller.name} is a {controller.product.model}: a stored program is for a SmartMotor")


def check(source: bytes, file: str, controller: Controller) -> None:
    """Raises UsageError or ProgramError if this motor, as it is wired here, will not take the program when it is run.

    A motor like it, alone on a bench of its own, is given the program.
    """
    check_motor(controller)
    if controller.name not in controller.ports:
        raise UsageError(f"{controller.name} shares its line with others: a program cannot be loaded into it")
    alike = Bench().add(controller.product.model, controller.name, **controller.given)
    store(source, file, alike)


def store(source: bytes, file: str, motor: Controller) -> None:
    """Load it into this motor, and switch that off and on.  Raises ProgramError if it is not taken."""
    port = motor.serial
    instant, port.instant = port.instant, True
    try:
        _load(port, source, file)
    finally:
        port.instant = instant
    motor.power_cycle()
    port.read()


def run(source: bytes, file: str, motor: Controller) -> None:
    """Load it into a motor that is switched off and on for it, whatever it does, and run it.

    The host has its usual format again.  Raises ProgramError if the program is not taken.
    """
    port, usual = motor.serial, motor.product.line
    assert usual is not None, "a motor has a serial port"
    port.drop_pending()
    port.host.format = line_format(motor.given.get("line"), usual)[0]
    motor.power_cycle()
    store(source, file, motor)
    port.write(b"RUN\r")


def only_motor(bench: Bench, file: str) -> Controller:
    """The motor that a source file is for."""
    found = [controller for controller in bench.controllers.values() if motor_of(controller) is not None]
    if len(found) != 1:
        raise ProgramError(
            f"a stored program is for one SmartMotor, here are {len(found)}: write a conversation (.talk)", file=file
        )
    if found[0].name not in found[0].ports:
        raise ProgramError(f"{found[0].name} shares its line with others: write a conversation (.talk)", file=file)
    return found[0]


def _load(port: SerialPort, source: bytes, file: str) -> None:
    """By the protocol of LOAD: the motor asks with 06 for each block, whose length is its own affair."""
    port.write(READY + b"LOAD ")
    if not port.read().endswith(ACKNOWLEDGE):
        raise ProgramError(f"the motor takes no program: it does not answer LOAD at {port.host.format}", file=file)
    sent = _without_comments(source)
    port.write(sent + END + b"RCKS\r")
    if not port.read().endswith(b"P\r"):
        advice = f"give it a larger option program_bytes (these are {len(sent)} bytes)"
        raise ProgramError(f"the motor has no room for it: {advice}", file=file)


def _without_comments(source: bytes) -> bytes:
    """What is left to be sent."""
    found = (_code.match(line) for line in source.decode().splitlines())
    lines = (match[0].rstrip(" ") for match in found if match is not None)
    return "".join(f"{line}\n" for line in lines if line).encode()
