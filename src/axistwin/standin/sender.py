"""A motion board on a serial port.  A separate thread serves the port, so that the emulation cannot delay it."""

from collections.abc import Callable
from threading import Event as Flag
from threading import Lock, Thread
from time import monotonic
from typing import TYPE_CHECKING

import serial

from axistwin.errors import LinkError, reason
from axistwin.standin.board import Board
from axistwin.standin.channel import Channel
from axistwin.standin.dictionary import Dictionary
from axistwin.standin.events import Event

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

WAIT_S = 0.002
"""Longest time to wait for a byte from the board; commands are sent at least at this interval."""
WRITE_S = 1.0
"""Longest time in seconds for a board to take its bytes."""
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


class Sender(Thread):
    """A thread that serves one board, and calls `deliver` with each of its events."""

    def __init__(self, board: Board, port: serial.Serial, deliver: Callable[["Sender", Event], None]) -> None:
        super().__init__(name=f"board {board.wiring.name}", daemon=True)
        self.wiring = board.wiring
        self._board, self._port, self._deliver = board, port, deliver
        self._lock, self._end = Lock(), Flag()

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

    def _report(self) -> None:
        while self._board.events:
            self._deliver(self, self._board.events.popleft())

    def queue(self, axis: str, direction: int, times_s: "NDArray[np.float64]", tolerance_s: float) -> None:
        """Queue an axis's pulses; the board outputs each at its time in `times_s` plus the horizon."""
        with self._lock:
            self._board.queue(axis, direction, times_s, tolerance_s)

    def set_output(self, source: str, level: bool, at_s: float) -> None:
        """Set an output at `at_s` plus the horizon, a constant delay."""
        with self._lock:
            self._board.set_output(source, level, at_s)

    def stop(self, reason: str, groups: tuple[str, ...] = ()) -> None:
        """Stop the axes of the controllers `groups`, or of all if it is empty, immediately."""
        with self._lock:
            self._board.stop(reason, groups)

    @property
    def stopped(self) -> frozenset[str]:
        """Names of the controllers whose axes are stopped.  Any thread may read this property."""
        return frozenset(tuple(self._board.stopped))

    def resume(self, group: str) -> None:
        """Accept pulses of a stopped controller again."""
        with self._lock:
            self._board.resume(group)

    def restart(self, now_s: float) -> None:
        """Connect to the board again after a failure."""
        with self._lock:
            self._board.restart(now_s)

    def shut_down(self) -> None:
        """Stop all axes and switch all drives off."""
        with self._lock:
            self._board.shut_down()

    def close(self) -> None:
        """End the thread and close the serial port."""
        self._end.set()
        self.join(1.0)
