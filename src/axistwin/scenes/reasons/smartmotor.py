"""Why a SmartMotor does not move."""

from collections.abc import Iterator

from axistwin.bench.acts import Act, Say, Wait
from axistwin.bench.programs.stored_programs import READY
from axistwin.controllers.smartmotor.card import ASLEEP, CLOSED, NOT_ADDRESSED
from axistwin.controllers.smartmotor.kernel import state
from axistwin.controllers.smartmotor.kernel.servo import COOLER
from axistwin.core.units import MS
from axistwin.scenes.reasons.reasons import Cause, Reason, Reasons
from axistwin.scenes.reasons.remedies import MARGIN, at_limit

LIMITS = (("Bp", "C", "plus", "UCI"), ("Bm", "D", "minus", "UDI"))
LIMIT_AGAIN = {"UCI": "UCP", "UDI": "UDM"}
REVERSED = 2  # The bit of F that reverses the direction of the shaft.
GIVEN = (("RA", "acceleration", "A=100"), ("V", "velocity", "V=100000"))
"""The parameters without which nothing moves: register, name and an example."""
STARTED = 200 * MS
TARGET, GO = ("P=4000", "go to position 4000"), ("G", "start the move")
RESTING = (state.M_OFF, state.M_BRAKE, state.M_ERROR, state.M_HOLD, state.M_STOP)


class SmartMotorReasons(Reasons):
    """Says why a SmartMotor does not move."""

    suggestions = (
        ("MP P=4000 G", "go to position 4000"), ("P=0 G", "go back to position 0"),
        ("RP", "report the position"), ("RW", "report the status word"), ("OFF", "servo off"),
    )  # fmt: skip

    @property
    def ready(self) -> bool:
        """True while the motor has power and obeys the host, if the host sends the motor's address."""
        return self.controller.powered and self.controller.ignoring in ("", NOT_ADDRESSED)

    def reasons(self) -> Iterator[Reason]:
        if not self.controller.powered:
            yield self.off()
            return
        if ignoring := self.controller.ignoring:
            yield self._ignoring(ignoring)
            return
        if rate := list(self.line()):
            yield from rate
            return
        flags = {lamp.label for lamp in self.lamps("RW") if int(self.value("RW")) >> (lamp.bit or 0) & 1}
        active = [limit for limit in LIMITS if limit[0] in flags]
        if len(active) > 1 and not self.value("SLE") and all(self._open(pin) for _, pin, _, _ in active):
            yield self._both()
        else:
            yield from dict.fromkeys(self._limited(*limit) for limit in active)
        if not active and flags & {"Br", "Bl"}:
            yield Reason("a limit fault has not been cleared (Br, Bl)", "type  ZS")
        if "Be" in flags:
            yield Reason("the position error has exceeded E (Be)", "free the shaft, or raise E, and then type  ZS")
        if "Bh" in flags:
            yield Reason("the motor has been too hot (Bh)", self._cooled())
        if not int(self.value("RAMPS")):
            yield Reason("the PWM limit AMPS is 0", "type  AMPS=1023", Cause.COMMAND)
        again = " G" if "Bt" in flags else ""
        for name, meaning, given in GIVEN:
            if not int(self.value(name)):
                yield Reason(f"no {meaning} has been given", f"type  {given}{again}", Cause.COMMAND)
        if "Bk" in flags:
            yield Reason("the stored program is corrupt, and does not run (Bk)", "store it again, or type  :store END")

    def _ignoring(self, ignoring: str) -> Reason:
        if ignoring == ASLEEP:
            return Reason(ignoring, "type  WAKE", Cause.COMMAND)
        if ignoring == NOT_ADDRESSED:
            return Reason(ignoring, self.remedies.address(int(self.value("RADDR"))), Cause.COMMAND)
        if ignoring == CLOSED:
            return Reason(ignoring, self.remedies.power("off", "on"), Cause.COMMAND, cycle=True)
        return Reason(ignoring, self.remedies.mend("the supply"))

    def _cooled(self) -> str:
        cool = int(self.value("RTH")) - COOLER
        warm = int(self.value("RTEMP")) > cool
        return f"let it cool from {self.value('RTEMP')} to {cool} °C, and then type  ZS" if warm else "type  ZS"

    def _limited(self, flag: str, name: str, side: str, command: str) -> Reason:
        other = {"plus": "minus", "minus": "plus"}[side]
        low, high, position = (int(self.value(each)) for each in ("RSLN", "RSLP", "RP"))
        if self.value("SLE") and (position >= high if side == "plus" else position <= low):
            margin = min(MARGIN, (high - low) // 2)
            if margin < 1:
                return Reason("the software limits SLN and SLP leave no room", "type  SLD ZS")
            move = self._move(high - margin if side == "plus" else low + margin)
            reached = f"the software limit {'SLP' if side == 'plus' else 'SLN'} is reached ({flag})"
            return Reason(f"{reached}: move away in {other}", f"type  {move}")
        if self._open(name):
            wire = f"wire pin {name} to ground, or make it an input, and clear the fault"
            return Reason(
                f"the {side} limit is active ({flag}): {wire}", f"type  {command} ZS", self._at_start,
                pin=name, level="low", short=self.at(side),
            )  # fmt: skip
        found, away = at_limit(self.controller, side == "plus"), ""
        if found is not None and int(self.value("RF")) & REVERSED:
            move = f"{command} {self._move(position - found[2])}  and then  {LIMIT_AGAIN[command]}"
            away = f"F=2 reverses the shaft, but not the switches: move away in {side}: type  {move}"
        elif found is not None:
            away = f"the load is on the switch: move away in {other}: type  {self._move(position + found[2])}"
        remedy = self.restored(name, "low", then="  and then  ZS", away=away)
        text = f"the {side} limit is active ({flag})"
        return Reason(text, remedy, pin=name, level="low", short=self.at(side))

    def _open(self, name: str) -> bool:
        pin = self.controller.pins[name]
        return not (pin.held or pin.driven or pin.wired)

    @property
    def _at_start(self) -> Cause:
        return Cause.FAULT if self.controller.hint else Cause.START  # A bare motor starts with its limits active.

    def _both(self) -> Reason:
        wire = "wire pins C and D to ground, or make them inputs, and clear the fault"
        return Reason(
            f"both limit inputs are active (Bp, Bm): {wire}", "type  UCI UDI ZS", self._at_start,
            short="both limit inputs active",
        )  # fmt: skip

    def step(self) -> tuple[str, str] | None:
        """Return what is missing for a move: its mode, its target or its start; None after a move."""
        mode, target, position = (int(self.value(each)) for each in ("RMODE", "P", "RP"))
        if int(self.value("RBo")):
            return GO if target != position else TARGET if not position else None
        if mode == state.M_POSITION:
            return GO if target != position + int(self.value("RPE")) else None
        return None if position or mode in (*RESTING, state.M_RELATIVE) else ("MP", "mode position")

    def _move(self, target: int) -> str:
        """Return the commands of a move to `target`, also for a motor that has not moved before."""
        missing = "".join(f"{given} " for name, _, given in GIVEN if not int(self.value(name)))
        return f"ZS {missing}MP P={target} G"

    def initialisation(self) -> Iterator[Act]:
        """Yield the commands that clear the limit fault, which open limit inputs cause at power-up."""
        if self.controller.powered:
            yield Wait(STARTED)
            if self.controller.ignoring == ASLEEP:
                yield Say(b"WAKE ")
            yield Say(READY)
            yield Wait(STARTED)
