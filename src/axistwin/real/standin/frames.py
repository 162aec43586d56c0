"""Message blocks of a motion board: length, sequence number, content, CRC, sync byte (Klipper's Message Blocks).

<1 byte length><1 byte sequence><content><2 bytes CRC><1 byte sync>
"""

from collections.abc import Iterator

SYNC = 0x7E
LEAST, MOST = 5, 64  # Shortest and longest block, in bytes.
MOST_CONTENT = MOST - LEAST
_DESTINATION, _SEQUENCE = 0x10, 0x0F


def crc16(data: bytes) -> int:
    """Return the 16-bit CCITT CRC of a message block.  `data` is the block without its CRC and sync byte."""
    crc = 0xFFFF
    for byte in data:
        byte ^= crc & 0xFF
        byte ^= (byte << 4) & 0xFF
        crc = ((byte << 8) | (crc >> 8)) ^ (byte >> 4) ^ (byte << 3)
    return crc


def block(sequence: int, content: bytes) -> bytes:
    assert len(content) <= MOST_CONTENT, "the content fits into a block"
    head = bytes([len(content) + LEAST, _DESTINATION | sequence & _SEQUENCE]) + content
    return head + crc16(head).to_bytes(2, "big") + bytes([SYNC])


class Reader:
    """Finds the message blocks in a stream of bytes, and drops damaged blocks."""

    def __init__(self) -> None:
        self._data = bytearray()
        self.damaged = 0  # Number of times that damaged bytes have been discarded.

    def feed(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Add received bytes, and yield the sequence number and content of each complete block."""
        self._data += data
        while self._data:
            size = self._data[0]
            if LEAST <= size <= MOST and (len(self._data) < 2 or self._data[1] & ~_SEQUENCE == _DESTINATION):
                if len(self._data) < size:
                    return
                if _whole(found := bytes(self._data[:size])):
                    del self._data[:size]
                    yield found[1] & _SEQUENCE, found[2:-3]
                    continue
            self._drop()

    def _drop(self) -> None:
        self.damaged += self._data[0] != SYNC
        at = self._data.find(SYNC)
        del self._data[: at + 1 if at >= 0 else len(self._data)]


def _whole(data: bytes) -> bool:
    return data[-1] == SYNC and crc16(data[:-3]) == int.from_bytes(data[-3:-1], "big")


def integer(value: int) -> bytes:
    """Encode an integer in 1 to 5 bytes, as Klipper's protocol requires."""
    if value >= 1 << 31:
        value -= 1 << 32
    groups = next((n for n in range(1, 5) if -(1 << 7 * n - 2) <= value < 3 << 7 * n - 2), 5)
    return bytes((value >> 7 * n) & 0x7F | (0x80 if n else 0) for n in reversed(range(groups)))


def read_integer(data: bytes, at: int) -> tuple[int, int]:
    """Decode the integer at `at`; return it and the next index.  Raises IndexError if `data` is too short."""
    byte = data[at]
    value = (byte & 0x7F) - (0x80 if byte & 0x60 == 0x60 else 0)
    while byte & 0x80:
        at += 1
        byte = data[at]
        value = (value << 7) | (byte & 0x7F)
    return value, at + 1
