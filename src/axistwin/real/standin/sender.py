"""A motion board on a serial port.  A separate thread serves the port, so that the emulation cannot delay it."""

from threading import Event as Flag
from threading import Thread
from time import monotonic

import serial

from axistwin.core.errors import LinkError, reason
from axistwin.real.standin.channel import Channel
from axistwin.real.standin.dictionary import Dictionary
from axistwin.real.standin.klipper import KlipperBoard
from axistwin.real.standin.output import Deliver, Output

WAIT_S = 0.002  # Longest time to wait for a byte from the board; commands are sent at least at this interval.
WRITE_S = 1.0  # Longest time in seconds for a board to take its bytes.
IDENTIFY_S = 3.0
_CHUNK = 40


def open_port(port: str, baud: int) -> serial.Serial:
    """Open the serial port of a board.  Raises LinkError if the port cannot be opened."""
    try:
        return serial.Serial(port, baud, timeout=WAIT_S, write_timeout=WRITE_S, exclusive=True)
    except (OSError, ValueError) as error:  # OSError also catches its subclass `serial.SerialException`.
        raise LinkError(f"cannot open {port} ({reason(error)}): `axistwin boards` lists the connected boards") from None


def identify(port: str, baud: int) -> Dictionary:
    """Read the data dictionary of the board on a port.  Raises LinkError if no board answers."""
    data, dictionary, channel = bytearray(), Dictionary(), Channel()
    ends_s, asked_s = monotonic() + IDENTIFY_S, 0.0
    with open_port(port, baud) as line:
        while (now := monotonic()) < ends_s:
            if now - asked_s > 0.25:
                asked_s = now
                channel.send(dictionary.encode("identify", offset=len(data), count=_CHUNK))
            line.write(channel.due(now))
            for content in channel.receive(line.read(max(1, line.in_waiting)), now):
                name, values = dictionary.decode(content)
                if name == "identify_response" and values["offset"] == len(data):
                    if not values["data"]:
                        return Dictionary.unpack(bytes(data))
                    data += values["data"]
                    asked_s, ends_s = 0.0, now + IDENTIFY_S
    raise LinkError(f"no answer on {port} at {baud} baud: expected a board with Klipper's firmware")


class Sender(Thread, Output):
    """A thread that serves one board, and calls `deliver` with each of its events."""

    _board: KlipperBoard

    def __init__(self, board: KlipperBoard, port: serial.Serial, deliver: Deliver) -> None:
        Thread.__init__(self, name=f"board {board.wiring.name}", daemon=True)
        Output.__init__(self, board, deliver)
        self._port, self._end = port, Flag()

    def run(self) -> None:
        """Exchange bytes with the board until `close` is called or the port fails."""
        try:
            while not self._end.is_set():
                self._turn(self._port.read(max(1, self._port.in_waiting)))
        except OSError as error:
            self._gone(f"the board has disappeared ({error}): connect it, then start again")
        except Exception as error:
            self._gone(f"internal error ({error!r}): start again")
            raise
        finally:
            self._port.close()

    def _gone(self, reason: str) -> None:
        with self._lock:
            self._board.fail(reason, gone=True)
        self._report()

    def _turn(self, data: bytes) -> None:
        with self._lock:
            now_s = monotonic()
            self._board.receive(data, now_s)
            out = self._board.due(now_s)
        if out:
            self._port.write(out)
        self._report()

    def close(self) -> None:
        self._end.set()
        self.join(1.0)
