"""Communications (section 2 of the base language): echo, addresses, sleep, baud rate, opening and closing of channels.

The handling of characters is in `channel.py`.
"""

import re
from dataclasses import replace

from axistwin.controllers.smartmotor.chapters import host_mode, io
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.language.vocabulary import GLOBAL, LAST_ADDRESS
from axistwin.controllers.smartmotor.processor import Processor
from axistwin.controllers.smartmotor.serial.channel import Channel
from axistwin.core.units import MS
from axistwin.sim.frames import Parity, UartFormat

BAUD_RATES = (2400, 4800, 9600, 19200, 38400)


def query(motor: Processor) -> None:
    """Q: send the state of host mode to the host, in five bytes of which the first is F9h."""
    motor.send(host_mode.status(motor))


def echo(motor: Processor, channel: int = 0) -> None:
    """ECHO, ECHO1: send every received character back, including addresses and terminators."""
    motor.channels[channel].echoing = True


def echo_off(motor: Processor, channel: int = 0) -> None:
    """ECHO_OFF, ECHO_OFF1: switch the echo of received characters off.  After power-up, the echo is off."""
    motor.channels[channel].echoing = False


def sleep(motor: Processor, channel: int = 0) -> None:
    """SLEEP, SLEEP1: execute only WAKE on this channel.  The echo continues."""
    motor.channels[channel].asleep = True


def wake(motor: Processor, channel: int = 0) -> None:
    """WAKE, WAKE1: end SLEEP."""
    motor.channels[channel].asleep = False


def silent(motor: Processor, channel: int = 0) -> None:
    """SILENT (channel 0), SILENT1 (channel 1): suppress all output and reports of the program."""
    motor.channels[channel].silent = True


def talk(motor: Processor, channel: int = 0) -> None:
    """TALK, TALK1: end SILENT."""
    motor.channels[channel].silent = False


def address(motor: Processor, number: int) -> None:
    """SADDRn: set the motor's address, 0 to 120.  Any other value sets the flag Bs and does not change the address.

    The motor stays addressed.
    """
    if 0 <= number <= LAST_ADDRESS - GLOBAL:
        motor.i[s.ADDR] = number
    else:
        motor.syntax_error(f"{number} is out of range: expected 0 to {LAST_ADDRESS - GLOBAL}")


def baud(motor: Processor, rate: int) -> None:
    """BAUDn: set the baud rate of channel 0 to 2400, 4800, 9600, 19200 or 38400 bit/s.

    Any other value sets the flag Bs and does not change the baud rate.  The new baud rate takes effect at once: a
    character on the wire ends at the old rate, and the next character is sent at the new rate.
    """
    fmt = motor.channels[0].uart.format
    if rate not in BAUD_RATES or fmt is None:
        motor.syntax_error(f"no such baud rate: expected one of {', '.join(map(str, BAUD_RATES))}")
        return
    motor.channels[0].uart.format = replace(fmt, baudrate=rate)


PARITIES: dict[str, Parity] = {"N": "N", "O": "O", "E": "E"}
OPENING = re.compile(
    r"(?P<type>RS[24]),(?P<channel>[01]),(?P<parity>[NOE]),(?P<baud>\d{4,5}),"
    r"(?P<stop>[12]),(?P<data>[78]),(?P<mode>[CD])(,(?P<timeout>\d{1,6}))?",
    re.ASCII,
)
CLOSING = re.compile(r"(RS[24]|IIC),(?P<channel>[01])")


def open_channel(motor: Processor, parameters: str) -> None:
    """OCHN(type,channel,parity,baud,stop,data,mode): open a serial channel with the given settings.

    The settings are RS2 or RS4, 0 or 1, N O E, a baud rate, 1 or 2, 7 or 8, C or D.

    The mode is C for commands, or D for data that LEN and GETCHR read.  RS4 uses pin G (channel 0) or pins E and F
    (channel 1); channel 1 has no RS2.  Invalid parameters set Bs.  A time-out in ms may follow the mode: a command that
    is still incomplete after this time is dropped and sets Bs.  With 0, or without this value, no time-out exists.
    """
    match = OPENING.fullmatch(parameters)
    if match is None or int(match["baud"]) not in BAUD_RATES or (match["type"], match["channel"]) == ("RS2", "1"):
        motor.syntax_error("invalid parameters: expected e.g. OCHN(RS2,0,N,9600,1,8,C) or OCHN(RS4,1,N,9600,1,8,C)")
        return
    fmt = UartFormat(int(match["baud"]), int(match["data"]), PARITIES[match["parity"]], int(match["stop"]))
    channel = motor.channels[int(match["channel"])]
    channel.set_up(fmt, data_mode=match["mode"] == "D", timeout_ns=int(match["timeout"] or 0) * MS)
    _wire(motor, channel, rs485=match["type"] == "RS4")


def close_channel(motor: Processor, parameters: str) -> None:
    """CCHN(type,channel): close a channel, which then neither receives nor sends.  Other arguments set Bs."""
    match = CLOSING.fullmatch(parameters)
    if match is None:
        motor.syntax_error("invalid parameters: expected CCHN(RS2,0), CCHN(RS4,0) or CCHN(RS4,1)")
        return
    channel = motor.channels[int(match["channel"])]
    _wire(motor, channel, rs485=False)
    channel.shut()


def rs4(motor: Processor) -> None:
    """RS4: switch serial channel 0 to RS-485.  Pin G is the direction line, which is high while the motor transmits."""
    _wire(motor, motor.channels[0], rs485=True)


def rs2(motor: Processor) -> None:
    """RS2: switch serial channel 0 to RS-232.  Pin G becomes an input if the pin was the direction line."""
    _wire(motor, motor.channels[0], rs485=False)


def _wire(motor: Processor, channel: Channel, *, rs485: bool) -> None:
    if rs485:
        io.take_for_channel(motor, channel.number)
    elif channel.direction:
        io.direction_in(motor, "G")
    channel.direction = motor.pins["G"] if rs485 and channel.number == 0 else None
