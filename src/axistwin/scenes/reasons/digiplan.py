"""Why an IF1 or IF2 does not move."""

import re
from collections.abc import Iterator

from axistwin.bench.acts import Act, Say, Wait
from axistwin.bench.programs.command_lines import ATTEMPTS, PATIENCE_S, READY_S, SELF_TEST_S, greeting
from axistwin.controllers.digiplan.chapters.faults import LIMITS, LineFault, MotionFault
from axistwin.controllers.digiplan.chapters.terminals import TERMINALS
from axistwin.controllers.digiplan.state import Stage
from axistwin.core.units import MS, to_ns
from axistwin.scenes.reasons.reasons import Cause, Reason, Reasons
from axistwin.scenes.reasons.remedies import at_limit

_INPUT = re.compile(r"([HL])(\d)")
DRIVEN = {
    "estop": "the emergency stop is open",
    "limit_plus": "the plus limit is open: only moves in the minus direction begin",
    "limit_minus": "the minus limit is open: only moves in the plus direction begin",
    "x_fault": "the drive of X reports a fault",
    "y_fault": "the drive of Y reports a fault",
}
"""Reason why a move cannot start, for each input that must be high during a move."""


class DigiplanReasons(Reasons):
    """Says why an IF1 or IF2 does not move."""

    suggestions = (
        ("X1000$", "index X by 1000 steps"),
        ("X-1000@800$", "index X back, at 800 steps/s"),
        ("N", "report the position in this move"),
        ("K", "report the motion status"),
        (":X400:X-400:=2,1:$", "a sequence: forth and back, three times"),
    )

    @property
    def ready(self) -> bool:
        return self.value("state") == Stage.READY.value

    @property
    def begins(self) -> bool:
        (listing,) = self.controller.programs.values()
        return listing.running == 0 and not int(self.value("N"))

    def reasons(self) -> Iterator[Reason]:
        controller = self.controller
        if not controller.powered:
            yield self.off()
            return
        if rate := list(self.line()):
            yield from rate
            return
        stage = self.value("state")
        if stage == Stage.RESET.value:
            yield Reason("the self-test takes about a second", "wait", Cause.START)
        elif stage == Stage.WAIT.value:
            yield Reason(
                "the baud rate is not known yet", "type  (  and then  U61  (the data format), or  :init", Cause.START
            )
        elif stage == Stage.FORMAT.value:
            yield Reason(
                "the data format is not known yet", "type  U61  (8 data bits, no parity), or  :init", Cause.START
            )
        if stage != Stage.READY.value:
            if not controller.pins["estop"].level:
                yield self._open("estop", 0)
            return
        faults = int(self.value("K")) & ~MotionFault.COMMUNICATION.value
        open_inputs = [name for name in DRIVEN if not controller.pins[name].level]
        for name in open_inputs:
            yield self._open(name, faults)
        yield from self.awaited()
        locked = bool(int(self.value("F")) & LineFault.LOCKED.value)
        if faults and not open_inputs:
            yield from self._unread(MotionFault(faults), locked)
        if int(self.value("K")) & MotionFault.COMMUNICATION.value:
            yield Reason(
                f"a message was refused, and F has not been read since ({self.bits('F', int(self.value('F')))})",
                "type  F",
                Cause.REFUSED,
            )
        if locked and controller.awaited is None:
            yield from self._locked(faults)
        port = controller.serial
        if not (port.host.dtr and port.host.rts):
            held = next((name for name in ("dsr", "cts") if port.control_lines[name].held), "")
            remedy = self.remedies.mend(held) if held else "type  :drive dtr on  and  :drive rts on"
            yield Reason("DSR or CTS is off, so the interface does not answer", remedy, Cause.COMMAND)

    def _open(self, name: str, faults: int) -> Reason:
        text, remedy = f"{DRIVEN[name]} ({TERMINALS[name]})", self._closed(name, faults)
        if name == "estop":
            waits = self._first_waits if self._given_up else ()
            return Reason(text, remedy, Cause.STOP, name, "high", self._given_up, waits)
        if name in LIMITS:
            return Reason(text, remedy, pin=name, level="high", short=self.at(name.removeprefix("limit_")))
        return Reason(text, remedy, pin=name, level="high", short=DRIVEN[name])

    def _closed(self, name: str, faults: int) -> str:
        read = "  and then  K" if faults else ""
        found = at_limit(self.controller, name == "limit_plus") if name in LIMITS else None
        if found is None:
            return self.restored(name, "high", then=read)
        side = "minus" if name == "limit_plus" else "plus"
        locked = int(self.value("F")) & LineFault.LOCKED.value  # A locked interface reports, but makes no moves.
        line = f"type  {']  and then  ' if locked else ''}{'K  and then  ' if faults else ''}{found[0]}{found[2]}$"
        return self.restored(
            name, "high", then=read, away=f"{found[0]} stands on the switch: move away in {side}: {line}"
        )

    def _unread(self, faults: MotionFault, locked: bool) -> Iterator[Reason]:
        """Yield why motion stays blocked after a fault: its flags must be read with `K`, or the power cycled."""
        if locked and MotionFault.EMERGENCY_STOP in faults:
            yield Reason(
                "after an emergency stop a locked interface is reset only by its power, not by K",
                self.remedies.power("off", "on"),
                Cause.AFTER_STOP,
                cycle=True,
                waits=self._first_waits if self._ended else (),
            )
        elif not (locked and self._ended):
            cause = Cause.AFTER_STOP if MotionFault.EMERGENCY_STOP in faults else Cause.FAULT
            short = " and ".join(f"{str(fault.name).lower().replace('_', ' ')} fault" for fault in faults)
            yield Reason(f"a fault has not been read ({self.bits('Q', faults.value)})", "type  K", cause, short=short)

    @property
    def _ended(self) -> bool:
        listing = next(iter(self.controller.programs.values()))
        return self.controller.product.model == "if2" and bool(listing.lines) and listing.running is None

    def _locked(self, faults: int) -> Iterator[Reason]:
        listing = next(iter(self.controller.programs.values()))
        if not self._ended:
            if listing.running is None:
                yield Reason("communication is locked by [", "type  ]", Cause.COMMAND)
            return
        ended = f"{listing.ended_by or 'its last step'} has ended the stored sequence at step {self.value('O')}"
        begins = "it begins again" if self._begins_by_itself else "send  (  and  U61,  and it begins again"
        if not faults & MotionFault.EMERGENCY_STOP.value:
            remedy = self.remedies.power("off", "on")
            yield Reason(
                f"{ended}, and only a power-up starts it", f"{remedy}: {begins}{self._first_wait}",
                Cause.FAULT if listing.ended_by else Cause.ENDED, cycle=True, waits=self._first_waits, short=ended,
            )  # fmt: skip
        yield Reason(
            "communication is locked by [, which keeps the sequence without power",
            "type  ]  to give up the stored sequence: the next power-off loses it, unless  [  is sent again",
            Cause.COMMAND,
        )

    @property
    def _begins_by_itself(self) -> bool:
        return not self.controller.terminals["dsr"].level

    @property
    def _given_up(self) -> bool:
        """True if the power must be cycled after an emergency stop, because the interface is locked."""
        return bool(int(self.value("F")) & LineFault.LOCKED.value)

    @property
    def _first_waits(self) -> tuple[tuple[str, str], ...]:
        (listing,) = self.controller.programs.values()
        inputs = _INPUT.findall(listing.lines[0]) if listing.lines else ()
        return tuple((f"input{digit}", "high" if word == "H" else "low") for word, digit in inputs)

    @property
    def _first_wait(self) -> str:
        levels = [self.remedies.drive(pin, level) for pin, level in self._first_waits]
        return f", and waits: {' and '.join(levels)}" if levels else ""

    def initialisation(self) -> Iterator[Act]:
        """Yield actions that send `(` until an answer arrives, and then the data format."""
        if self.value("state") == Stage.RESET.value:
            yield Wait(to_ns(SELF_TEST_S))
        _, message = greeting(self.controller.serial.host.format)
        for _ in range(ATTEMPTS):
            if self.value("state") != Stage.WAIT.value:
                break
            yield Say(b"(")
            yield Wait(to_ns(PATIENCE_S))
        if self.value("state") == Stage.FORMAT.value:
            yield Say(message)
            yield Wait(to_ns(READY_S) + 100 * MS)
