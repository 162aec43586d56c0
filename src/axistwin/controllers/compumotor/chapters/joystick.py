"""Chapters Joystick interface and Remote power shutdown: commands 10h to 14h, 95h."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from axistwin.controllers.compumotor.chapters.pulses import PulseGenerator
from axistwin.sim.clock import Event, Procedure
from axistwin.sim.pins import Pin

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board


class Joystick:
    """An 852 joystick at the board: while it is enabled its pulses go straight through, and are counted."""

    def __init__(self, pins: dict[str, Pin], pulses: PulseGenerator) -> None:
        self._pins, self._pulses = pins, pulses
        self.enabled = False
        self.on_move: Callable[[bool], None] = lambda begins: None
        """Called when it begins to move the motor, and when it ends."""
        self._disabled: Event | None = None
        self._moved = False
        self._unwatch = [pins["step_in"].subscribe(self._step), pins["at_zero"].subscribe(lambda pin: self._look())]

    def close(self) -> None:
        """The power is gone."""
        for unwatch in self._unwatch:
            unwatch()
        self.enabled = False

    @property
    def moving(self) -> bool:
        """Whether it has the motor, and has it moving."""
        return self.enabled and not self._pins["at_zero"].level

    def control(self, disabled: Event) -> Procedure:
        """It has the motor until `disabled` happens or the command is ended."""
        self.enabled, self._disabled = True, disabled
        self._pins["remote_acknowledge"].set(True)
        self._look()
        try:
            yield disabled
        finally:
            self.enabled = False
            self._pins["remote_acknowledge"].set(False)
            self._look()

    def disable(self) -> None:
        """It gives the motor back."""
        if self.enabled and self._disabled is not None and not self._disabled.triggered:
            self._disabled.succeed()

    def _look(self) -> None:
        """A move is from zero velocity to zero velocity, or until the joystick is disabled."""
        if self.moving is not self._moved:
            self._moved = self.moving
            if self._moved:
                self._pulses.leave_zero()
            self.on_move(self._moved)

    def _step(self, pin: Pin) -> None:
        if self.enabled and pin.level:
            cw = self._pins["direction_in"].level
            self._pulses.face(+1 if cw is self._pulses.cw_is_plus else -1)
            self._pulses.pulse()


def disable_joystick(board: "Board") -> None:
    """Command 10h: the joystick has no more control, whether the motor is moving or not."""
    board.joystick.disable()


def enable_joystick(board: "Board") -> Procedure:
    """Command 11h: the joystick has control until 10h.  Ignored if shut down or moving."""
    if board.shut_down or board.moving:
        return
    board.motion.end = None
    yield from board.joystick.control(board.clock.event())
    board.refresh()


class Shutdown:
    """Who may shut the motor down: the joystick if enabled, else the input if enabled (13h), else command 12h."""

    def __init__(self, board: "Board") -> None:
        self._board = board
        self.commanded = False
        self.input_enabled = False
        self.on = False
        """True while the motor is shut down."""
        self._unwatch = board.pins["shutdown_in"].subscribe(lambda pin: self.refresh())

    def close(self) -> None:
        """The power is gone."""
        self._unwatch()

    def refresh(self) -> None:
        """The output follows whoever has the say; a moving motor is not shut down."""
        by_input = self._board.joystick.enabled or self.input_enabled
        wanted = not self._board.pins["shutdown_in"].level if by_input else self.commanded
        if not (wanted and self._board.moving):
            self.on = wanted
            self._board.pins["shutdown"].set(wanted)


def shut_down(board: "Board", on: bool) -> None:
    """Command 12h: remote power shutdown on or off.

    Ignored if the joystick or the shutdown input is enabled, or while moving.  While on, there are no moves.
    """
    if not (board.occupied or board.shutdown.input_enabled):
        board.shutdown.commanded = on
        board.shutdown.refresh()


def enable_shutdown_input(board: "Board", on: bool) -> None:
    """Command 13h: the shutdown input counts, or not.  Ignored if the joystick is enabled."""
    if not board.joystick.enabled:
        board.shutdown.input_enabled = on
        board.shutdown.refresh()


def set_direction_sense(board: "Board", ccw_is_plus: bool) -> None:
    """Command 14h: CW is + (00) or CCW is +.  Moves keep their signs, positions their values.  Ignored while moving."""
    if not board.occupied:
        board.pulses.cw_is_plus = not ccw_is_plus
        board.loop.encoder.face(-1 if ccw_is_plus else +1)


def request_joystick(board: "Board") -> bytes:
    """Command 95h: the joystick's request, FF while its input is high."""
    return b"\xff" if board.pins["remote_enable"].level else b"\0"
