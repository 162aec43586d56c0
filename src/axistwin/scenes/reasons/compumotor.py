"""Why an 1810 or 1811 does not move."""

from collections.abc import Iterator

from axistwin.bench.acts import Act, Wait
from axistwin.controllers.compumotor.card import BEING_DEFINED
from axistwin.controllers.compumotor.registers import Status
from axistwin.controllers.compumotor.state import INDEXER
from axistwin.core.units import S
from axistwin.scenes.reasons.reasons import Cause, Reason, Reasons
from axistwin.scenes.reasons.remedies import at_limit

DEFAULTS = "default_velocity_and_acceleration 00 25000 250000"


class CompumotorReasons(Reasons):
    """Says why an 1810 or 1811 does not move."""

    suggestions = (
        (DEFAULTS, "velocity and acceleration of default moves (31h)"),
        ("go_relative 25000", "one revolution of a 25000 step motor (33h)"),
        ("position_from_absolute_zero", "report the position (83h)"),
        ("move_status", "report limits, home, motion (88h)"),
        ("stop", "decelerate to a stop (70h)"),
    )

    def step(self) -> tuple[str, str] | None:
        """Return the line of the first move; `reasons` asks for the line before it while that has not been given."""
        return None if self.moved else self.suggestions[1]

    @property
    def ready(self) -> bool:
        return bool(int(self.value("status")) & Status.INPUT_READY)

    def reasons(self) -> Iterator[Reason]:
        """Yield why the board cannot start a move; it may ignore a later remedy until the earlier ones are applied."""
        pins = self.controller.pins
        if not self.controller.powered:
            yield self.off()
            return
        if int(self.value("status")) & Status.FAILED:
            yield Reason("the board has failed (status bit 5)", self.remedies.power("off", "on"), cycle=True)
            return
        yield from self._sequences()
        yield from self.awaited()
        if pins["remote_acknowledge"].level:
            yield Reason("the joystick controls the motor (11h)", "type  disable_joystick", Cause.COMMAND)
        if pins["shutdown"].level and not pins["shutdown_in"].level:
            yield Reason(
                "the motor is shut down by its input (13h)", self.restored("shutdown_in", "high"),
                pin="shutdown_in", level="high",
            )  # fmt: skip
        elif pins["shutdown"].level:
            yield Reason("the motor is shut down (12h)", "type  remote_power_shutdown off", Cause.COMMAND)
        reversed_ = self._reversed
        for pin, clockwise in (("cw_limit", True), ("ccw_limit", False)):
            if pins[pin].level:
                side = "plus" if clockwise is not reversed_ else "minus"
                yield Reason(
                    f"the {side} limit is active: only moves away from it begin", self._opened(pin, side, reversed_),
                    pin=pin, level="low", short=self.at(side, "plus" if clockwise else "minus"),
                )  # fmt: skip
        if int(self.value("mode")) != INDEXER:
            yield Reason(
                f"the board is in streaming mode {int(self.value('mode')):02X}h", "type  indexer_mode", Cause.COMMAND
            )
        elif not self.value("acceleration"):
            yield Reason(
                "a move needs velocity and acceleration: 31h has not been given", f"type  {DEFAULTS}", Cause.COMMAND
            )

    def _sequences(self) -> Iterator[Reason]:
        """Yield the reasons why the board stores or ignores the commands of the host."""
        if any(listing.title.endswith(BEING_DEFINED) for listing in self.controller.programs.values()):
            yield Reason(
                "the board stores commands in a sequence (D9h)", "type  end_sequence_definition", Cause.COMMAND
            )
        if number := int(self.value("sequence")):
            yield Reason(
                f"sequence {number} is being performed, and stands at its command {self.value('command')}",
                "type  kill_sequence",
                Cause.COMMAND,
            )

    @property
    def _reversed(self) -> bool:
        """True if CCW is the plus direction (14h), as far as one active limit shows it in the bits of 88h."""
        cw, ccw = self.controller.pins["cw_limit"].level, self.controller.pins["ccw_limit"].level
        return cw is not ccw and bool(int(self.value("move")) & 1) is ccw

    def _opened(self, pin: str, side: str, reversed_: bool) -> str:
        found, other = at_limit(self.controller, pin == "cw_limit"), {"plus": "minus", "minus": "plus"}[side]
        if found is None:
            return self.restored(pin, "low")
        move = f"go_relative {-found[2] if reversed_ else found[2]}"
        return self.restored(pin, "low", away=f"the slide stands on the switch: move away in {other}: type  {move}")

    def initialisation(self) -> Iterator[Act]:
        """Yield an action that waits 1 s for the end of the self-test; nothing if the board is ready."""
        if not self.ready:
            yield Wait(S)
