"""A host that does the handshake of chapter Reading and writing: commands in, messages out, nothing else.

It writes a command when SB bit 4 tells that the IDB is ready, and takes a message as soon as SB bit 3 tells that there
is one.  Its own work takes no time.
"""

from collections import deque
from collections.abc import Callable

from axistwin.controllers.compumotor.language import LONGEST
from axistwin.controllers.compumotor.registers import Control, Status
from axistwin.sim.registers import CONTROL, DATA, NOBODY_DRIVES, RegisterPort


class Host:
    """Attends to the registers of a board until it is closed."""

    def __init__(self, port: RegisterPort) -> None:
        self.port = port
        self._commands: deque[bytes] = deque()
        self._hearers: list[Callable[[bytes], None]] = []
        self._due = False
        self._unwatch = port.subscribe_status(self._changed)
        self._changed()

    @property
    def pending(self) -> int:
        """Commands that the board has not taken yet."""
        return len(self._commands)

    def write(self, command: bytes) -> None:
        """Send a command as soon as the board takes it."""
        self._commands.append(command)
        self._changed()

    def subscribe_received(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `callback` with each message that has been read.  Returns what ends it."""
        self._hearers.append(callback)
        return lambda: self._hearers.remove(callback)

    def close(self) -> None:
        """Leave the registers alone."""
        self._unwatch()
        self._commands.clear()
        self._hearers.clear()

    def _changed(self) -> None:
        if not self._due:
            self._due = True
            self.port.clock.call_later(0, self._attend)  # the board does one thing after the other

    def _attend(self) -> None:
        self._due = False
        byte = self.port.read(CONTROL)
        if byte == NOBODY_DRIVES:
            return
        status = Status(byte)
        if Status.MESSAGE_READY in status and self._hearers:
            self._take_message()
        if Status.INPUT_READY in status and self._commands:
            for value in self._commands.popleft():
                self.port.write(DATA, value)
            self.port.write(CONTROL, Control.COMMAND_READY)

    def _take_message(self) -> None:
        message = bytes(self.port.read(DATA) for _ in range(LONGEST))
        self.port.write(CONTROL, Control.MESSAGE_TAKEN)
        for callback in tuple(self._hearers):
            callback(message)
