"""Chapter Serial data format: frames, the data format message, and the format of a received message."""

import re
from dataclasses import dataclass
from functools import cached_property

from axistwin.sim.frames import Parity, UartFormat

CR, LF = 0x0D, 0x0A
BAUD_RATES = (110, 300, 600, 1200, 2400, 4800, 9600)
FORMAT_MESSAGE = re.compile(r"([UV])([1-8])([1-9])")
PARITIES: dict[int, Parity] = {1: "N", 2: "N", 3: "O", 4: "E", 5: "O", 6: "E", 7: "N", 8: "O", 9: "E"}


@dataclass(frozen=True)
class Frame:
    """A data format: terminator `U` or `V`, x1 (frame) 1 to 8, x2 (parity, echo, X-on/X-off) 1 to 9."""

    terminator: str = "U"
    x1: int = 6
    x2: int = 1

    @property
    def uart(self) -> tuple[int, Parity, int]:
        """Data bits, parity and stop bits of this data format."""
        return (7 if self.x1 <= 2 else 8), PARITIES[self.x2], (1 if self.x1 % 2 else 2)

    @property
    def echo(self) -> bool:
        """True if the interface sends each processed character back to the host."""
        return self.x2 in (2, 5, 6)

    @property
    def x_on_x_off(self) -> bool:
        """True if the characters X-off and X-on pause and resume the transmission of the host."""
        return self.x2 >= 7

    @cached_property
    def ends_message(self) -> int:
        """Code of the character with which the host ends each message: CR or LF."""
        return CR if self.terminator == "U" else LF

    def answer(self, text: bytes) -> bytes:
        """Return the bytes of an answer to the host, including the terminator."""
        end = b"\r" if self.terminator == "U" else b"\r\n"
        return (text + end).translate(self._texts)

    @cached_property
    def _texts(self) -> bytes:
        return bytes(map(self.text, range(256)))

    def raw(self, byte: int) -> int:
        """Return a byte as it is sent: bit 8 is data, 0 or 1; with 7 data bits bit 8 does not exist.

        The quick status needs all eight bits, so the byte is unchanged if the format fixes bit 8 at 1.
        """
        return byte if self.x1 in (3, 4, 7, 8) else byte & 0x7F

    def text(self, byte: int) -> int:
        """Return a character with its highest bit (80h) set or cleared, as the data format requires."""
        return byte | 0x80 if self.x1 in (7, 8) else self.raw(byte)


@dataclass(frozen=True)
class MessageFormat:
    """Format in which a message was received: baud rate, data bits, parity, bit 8 of the command and its terminator.

    An 8-bit receiver without parity finds the parity bit of a 7-bit sender in bit 8.
    """

    baudrate: int
    bytesize: int
    parity: str
    eighth: tuple[bool, ...] = (False, False)


def read_format(text: str, terminator: int) -> Frame | None:
    """Return the data format of a message; None if the format or the terminator is wrong."""
    match = FORMAT_MESSAGE.fullmatch(text)
    if match is None:
        return None
    frame = Frame(match[1], int(match[2]), int(match[3]))
    return frame if frame.ends_message == terminator else None


def uart_format(baudrate: int, frame: Frame) -> UartFormat:
    """Return the UART setting for a baud rate and a data format."""
    return UartFormat(baudrate, *frame.uart)
