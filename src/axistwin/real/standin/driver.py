"""Connect a bench to its motion boards: send pulses and outputs, receive inputs, correct positions after a stop."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

from axistwin.bench import Bench
from axistwin.core.units import S
from axistwin.real.standin.events import Event, Failed, InputChanged, Ready, Stopped
from axistwin.real.standin.motors import Motor, motor
from axistwin.real.standin.output import Output
from axistwin.sim.pins import Pin
from axistwin.sim.signal import Signal

INPUT_S = 0.02  # Constant delay, in seconds, from a change of an input at the board to the same change on the bench.


class Driver:
    """Drives motion boards from a bench.  `tell`: function that shows a line of text to the user."""

    def __init__(self, bench: Bench, boards: Sequence[Output], tell: Callable[[str], None]) -> None:
        self.bench, self.boards, self._tell = bench, boards, tell
        self.live = False  # True while pulses are sent to the boards.
        self.stopped: dict[str, str] = {}  # Controllers that are stopped until the user continues, with the reason.
        self.positions: dict[str, int] = {}  # Latest position that a board has reported for each axis.
        self.collected: Signal[[float]] = Signal()  # Pulses before this host time in s are sent.
        self._offset_s = 0.0
        self._board = {axis.axis: board for board in boards for axis in board.wiring.axes}
        self._motors: dict[str, Motor] = {}
        self._origin: dict[str, int] = {}
        self._held: set[str] = set()
        self._still: set[str] = set()  # Stopped and not released; their positions are those of the boards.
        self._at_rest_ns: dict[str, int] = {}  # When the motion of a held controller was first seen to have ended.
        self._failed: set[str] = set()
        self._ready: set[str] = set()
        for board in boards:
            for output in board.wiring.outputs:
                self._pin(output.source).subscribe(partial(self._output_changed, board, output.source))

    def _motor(self, whole: str) -> Motor:
        controller, _, name = whole.rpartition(".")
        return motor(self.bench[controller].axes[name])

    def _pin(self, whole: str) -> Pin:
        controller, _, name = whole.rpartition(".")
        return self.bench[controller].pins[name]

    @property
    def axes(self) -> tuple[str, ...]:
        return tuple(self._board)

    @property
    def commanded(self) -> dict[str, int]:
        """Commanded position of each axis, in pulses.  The motors reach these positions one horizon later."""
        return {whole: self._origin[whole] + motor.pulses for whole, motor in self._motors.items()}

    @property
    def all_ready(self) -> bool:
        return len(self._ready) == len(self.boards)

    @property
    def still(self) -> bool:
        return self._still >= self._board.keys()

    @property
    def failed(self) -> bool:
        return bool(self._failed)

    def begin(self, now_s: float) -> None:
        """Begin to send pulses to the boards.  `now_s` is the time of the host's clock at the present virtual time."""
        self._offset_s = now_s - self.bench.now / S
        self._motors = {whole: self._motor(whole) for whole in self._board}
        self._origin = {whole: self.positions[whole] - self._motors[whole].pulses for whole in self._board}
        self.live = True
        for board in self.boards:
            for output in board.wiring.outputs:
                board.set_output(output.source, self._pin(output.source).level, now_s)

    def collect(self) -> None:
        """Send the new pulses; call it at least five times per horizon, when no event of the bench is due."""
        if self.live:
            for whole, board in self._board.items():
                motor = self._motors[whole]
                for direction, times in motor.runs():
                    board.queue(whole, direction, times / S + self._offset_s, motor.tolerance_s(times))
            self._let_go()
            self.collected.emit(self.bench.now / S + self._offset_s)

    def _let_go(self) -> None:
        """Let the axes of a controller move again when the user has continued, and the interrupted motion has ended."""
        busy = {group for board in self.boards if board.wiring.name not in self._ready for group in board.wiring.groups}
        for group in tuple(self._held - self.stopped.keys() - busy):
            wholes = [whole for whole in self._board if whole.rpartition(".")[0] == group]
            if any(self._motors[whole].moving for whole in wholes):
                self._at_rest_ns.pop(group, None)
            elif self._at_rest_ns.setdefault(group, self.bench.now) < self.bench.now:
                # All axes were at rest at two consecutive checks, so the interrupted motion has ended.
                del self._at_rest_ns[group]
                self._held.discard(group)
                self._still -= set(wholes)
                for whole in wholes:
                    self._motors[whole].let_go()
                for board in {id(board): board for board in self.boards if group in board.wiring.groups}.values():
                    board.resume(group)

    def handle(self, board: Output, event: Event) -> None:
        """Handle an event that a board has reported.  The bench must have been advanced to the present time."""
        match event:
            case Ready(positions, inputs):
                self._ready.add(board.wiring.name)
                self._failed.discard(board.wiring.name)
                self.positions |= positions
                for to, level in inputs.items():
                    self._pin(to).drive(level)
                if self.live:
                    self._still |= positions.keys()
                    self._hold(positions)
            case InputChanged(to, level, at_s):
                due_ns = round((at_s - self._offset_s + INPUT_S) * S)
                self.bench.clock.call_last(max(due_ns, self.bench.now), partial(self._pin(to).drive, level))
            case Stopped(reason, positions, by):
                self.positions |= positions
                self._still |= positions.keys()
                self._stop_others(board, reason, positions)
                self._hold(positions)
                if not by:
                    self._wait_for_user(board, reason)
                else:
                    self._tell(f"{reason}: {_written(positions)}")
            case Failed(reason):
                self._failed.add(board.wiring.name)
                self._ready.discard(board.wiring.name)
                if self.live:
                    positions = {axis.axis: self.positions[axis.axis] for axis in board.wiring.axes}
                    self._still -= positions.keys()
                    self._stop_others(board, reason, positions)
                    self._hold(positions)
                self._wait_for_user(board, reason)

    def _stop_others(self, board: Output, reason: str, axes: Iterable[str]) -> None:
        stopped = {whole.rpartition(".")[0] for whole in axes} - self._held
        for other in self.boards:
            if other is not board and (groups := tuple(group for group in other.wiring.groups if group in stopped)):
                other.stop(f"{board.wiring.name}: {reason}", groups)

    def _wait_for_user(self, board: Output, reason: str) -> None:
        for group in board.wiring.groups:
            self.stopped[group] = reason
        self._tell(f"stopped: {board.wiring.name}: {reason}")

    def _hold(self, positions: Mapping[str, int]) -> None:
        if self.live:
            for whole, position in positions.items():
                self._motors[whole].hold(position - self._origin[whole])
                self._held.add(whole.rpartition(".")[0])
                self._at_rest_ns.pop(whole.rpartition(".")[0], None)

    def stop(self, reason: str) -> None:
        """Stop all motors on all boards immediately, until `go_on`."""
        for board in self.boards:
            board.stop(reason)
        self.stopped |= {group: reason for board in self.boards for group in board.wiring.groups}

    def go_on(self, now_s: float) -> None:
        """Let stopped motors move again, and reconnect failed boards, at the user's command."""
        self._offset_s = max(self._offset_s, now_s - self.bench.now / S)
        for board in self.boards:
            if board.wiring.name in self._failed:
                self._failed.discard(board.wiring.name)
                board.restart(now_s)
        self.stopped.clear()

    def _output_changed(self, board: Output, source: str, pin: Pin) -> None:
        if self.live:
            board.set_output(source, pin.level, self.bench.now / S + self._offset_s)


def _written(positions: Mapping[str, int]) -> str:
    return ", ".join(f"{axis} at {position}" for axis, position in positions.items())
