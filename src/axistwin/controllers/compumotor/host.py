"""A host program that sends commands and receives messages by the handshake of chapter Reading and writing.

The host writes a command when SB bit 4 reports an IDB that is ready, and reads a message when SB bit 3 reports one.
The host's own work takes no time.
"""

from collections import deque
from collections.abc import Callable

from axistwin.controllers.compumotor.language import LONGEST
from axistwin.controllers.compumotor.registers import Control, Status
from axistwin.sim.registers import CONTROL, DATA, NOBODY_DRIVES, RegisterPort
from axistwin.sim.signal import Signal


class Host:
    """Host that sends commands to a board and receives messages, through the registers of the board."""

    def __init__(self, port: RegisterPort) -> None:
        self.port = port
        self._commands: deque[bytes] = deque()
        self._received: Signal[bytes] = Signal()
        self._due = False
        self._unsubscribe = port.status_changes.subscribe(self._changed)
        self._changed()

    @property
    def pending(self) -> int:
        return len(self._commands)

    def write(self, command: bytes) -> None:
        self._commands.append(command)
        self._changed()

    def subscribe_received(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `callback` with each message that the host has read from the board.  Return an unsubscribe function."""
        return self._received.subscribe(callback)

    def close(self) -> None:
        self._unsubscribe()
        self._commands.clear()
        self._received = Signal()

    def _changed(self) -> None:
        if not self._due:
            self._due = True
            # Call `_serve` as a separate simulation event, which follows the present event at the same virtual time.
            self.port.clock.call_later(0, self._serve)

    def _serve(self) -> None:
        self._due = False
        status = self.port.read(CONTROL)
        if status == NOBODY_DRIVES:
            return
        if status & Status.MESSAGE_READY and self._received:
            message = bytes(self.port.read(DATA) for _ in range(LONGEST))
            self.port.write(CONTROL, Control.MESSAGE_TAKEN)
            self._received.emit(message)
        if status & Status.INPUT_READY and self._commands:
            for value in self._commands.popleft():
                self.port.write(DATA, value)
            self.port.write(CONTROL, Control.COMMAND_READY)
