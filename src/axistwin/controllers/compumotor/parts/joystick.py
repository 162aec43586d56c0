"""The joystick connector and the remote power shutdown."""

from collections.abc import Callable, Mapping

from axistwin.controllers.compumotor.parts.pulses import PulseGenerator
from axistwin.sim.clock import Event
from axistwin.sim.pins import Pin


class Joystick:
    """The connector for an 852 joystick, whose pulses drive the motor and are counted while it is enabled."""

    def __init__(self, pins: Mapping[str, Pin], pulses: PulseGenerator) -> None:
        self._pins, self._pulses = pins, pulses
        self.enabled = False
        self.on_move: Callable[[bool], None] = lambda begins: None
        """Function that is called with True at the start and with False at the end of a motion by the joystick."""
        self.disabled: Event | None = None
        self._moved = False
        self._unsubscribe = [
            pins["step_in"].subscribe(self._step),
            pins["direction_in"].subscribe(lambda pin: self._face()),
            pins["at_zero"].subscribe(lambda pin: self._update()),
        ]

    def close(self) -> None:
        for unsubscribe in self._unsubscribe:
            unsubscribe()
        self.enabled = False

    @property
    def moving(self) -> bool:
        return self.enabled and not self._pins["at_zero"].level

    def enable(self, disabled: Event) -> None:
        """Let the joystick control the motor.  `disabled`: event with which command 10h ends this."""
        self.enabled, self.disabled = True, disabled
        self._pins["remote_acknowledge"].set(True)
        self._face()
        self._update()

    def disable(self) -> None:
        self.enabled = False
        self._pins["remote_acknowledge"].set(False)
        self._update()

    def _update(self) -> None:
        if self.moving is not self._moved:
            self._moved = self.moving
            if self._moved:
                self._pulses.leave_zero()
            self.on_move(self._moved)

    def _face(self) -> None:
        if self.enabled:
            self._pulses.face(+1 if self._pins["direction_in"].level is self._pulses.cw_is_plus else -1)

    def _step(self, pin: Pin) -> None:
        if self.enabled and pin.level:
            self._face()
            self._pulses.pulse()


class Shutdown:
    """Remote power shutdown, by the shutdown input if the joystick or 13h enables the input, else by command 12h."""

    def __init__(self, pins: Mapping[str, Pin], pulses: PulseGenerator, joystick: Joystick) -> None:
        self._pins, self._pulses, self._joystick = pins, pulses, joystick
        self.commanded = self.input_enabled = self.on = False
        self.close = pins["shutdown_in"].subscribe(lambda pin: self.refresh())

    def refresh(self) -> None:
        """Update the shutdown output; a moving motor is not shut down."""
        by_input = self._joystick.enabled or self.input_enabled
        wanted = not self._pins["shutdown_in"].level if by_input else self.commanded
        if not (wanted and (self._pulses.moving or self._joystick.moving)):
            self.on = wanted
            self._pins["shutdown"].set(wanted)
