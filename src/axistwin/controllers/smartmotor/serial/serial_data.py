"""Communications (section 2 of the base language): echo, addresses, sleep, baud rate, opening and closing of channels.

What a channel does with its characters is in `channel.py`.
"""

import re
from dataclasses import replace

from axistwin.controllers.smartmotor.chapters import host_mode, io
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.processor import Processor
from axistwin.controllers.smartmotor.serial.channel import GLOBAL, LAST_ADDRESS, Channel
from axistwin.sim.frames import Parity, UartFormat
from axistwin.units import MS

BAUD_RATES = (2400, 4800, 9600, 19200, 38400)


def query(motor: Processor) -> None:
    """Q: host mode's status, in binary."""
    motor.send(host_mode.status(motor))


def echo(motor: Processor, channel: int = 0) -> None:
    """ECHO, ECHO1: send every character back that comes in, addresses and terminators too."""
    motor.channels[channel].echoing = True


def echo_off(motor: Processor, channel: int = 0) -> None:
    """ECHO_OFF, ECHO_OFF1: as at power-up."""
    motor.channels[channel].echoing = False


def sleep(motor: Processor, channel: int = 0) -> None:
    """SLEEP, SLEEP1: execute nothing on this channel but WAKE.  The echo continues."""
    motor.channels[channel].asleep = True


def wake(motor: Processor, channel: int = 0) -> None:
    """WAKE, WAKE1: end SLEEP."""
    motor.channels[channel].asleep = False


def silent(motor: Processor, channel: int = 0) -> None:
    """SILENT, SILENT1: what the program prints and reports on this channel is not sent."""
    motor.channels[channel].silent = True


def talk(motor: Processor, channel: int = 0) -> None:
    """TALK, TALK1: end SILENT."""
    motor.channels[channel].silent = False


def address(motor: Processor, number: int) -> None:
    """SADDRn: the motor's address, 0 to 120; anything else sets Bs.  The addressed motor stays addressed."""
    if 0 <= number <= LAST_ADDRESS - GLOBAL:
        motor.i[s.ADDR] = number
    else:
        motor.syntax_error()


def baud(motor: Processor, rate: int) -> None:
    """BAUDn: channel 0 at 2400, 4800, 9600, 19200 or 38400 bit/s; else Bs is set.

    It takes effect at once: a character on the wire ends at the old rate, the next one begins at the new rate.
    """
    fmt = motor.channels[0].uart.format
    if rate not in BAUD_RATES or fmt is None:
        motor.syntax_error()
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
    """OCHN(type,channel,parity,baud,stop,data,mode): RS2 or RS4, 0 or 1, N O E, a baud rate, 1 or 2, 7 or 8, C or D.

    C: commands; D: data for LEN and GETCHR.  RS4 takes pin G (channel 0) or pins E and F (channel 1); RS2 on channel 1
    does not exist.  Anything else sets Bs.  A time-out in ms may follow the mode: a command that has not ended so long
    after its first character is dropped, flag Bs; 0, or none: it may take any time.
    """
    match = OPENING.fullmatch(parameters)
    if match is None or int(match["baud"]) not in BAUD_RATES or (match["type"], match["channel"]) == ("RS2", "1"):
        motor.syntax_error()
        return
    fmt = UartFormat(int(match["baud"]), int(match["data"]), PARITIES[match["parity"]], int(match["stop"]))
    channel = motor.channels[int(match["channel"])]
    channel.set_up(fmt, data_mode=match["mode"] == "D", timeout_ns=int(match["timeout"] or 0) * MS)
    _wire(motor, channel, rs485=match["type"] == "RS4")


def close_channel(motor: Processor, parameters: str) -> None:
    """CCHN(type,channel): the channel neither receives nor sends any more.  Anything else sets Bs."""
    match = CLOSING.fullmatch(parameters)
    if match is None:
        motor.syntax_error()
        return
    channel = motor.channels[int(match["channel"])]
    _wire(motor, channel, rs485=False)
    channel.shut()


def rs4(motor: Processor) -> None:
    """RS4: channel 0 is RS-485; pin G is its direction line, high while the motor transmits."""
    _wire(motor, motor.channels[0], rs485=True)


def rs2(motor: Processor) -> None:
    """RS2: channel 0 is RS-232; pin G, if it has been the direction line, is an input."""
    _wire(motor, motor.channels[0], rs485=False)


def _wire(motor: Processor, channel: Channel, *, rs485: bool) -> None:
    if rs485:
        io.take_for_channel(motor, channel.number)
    elif channel.direction:
        io.direction_in(motor, "G")
    channel.direction = motor.pins["G"] if rs485 and channel.number == 0 else None
