"""Explains the commands, the replies and the state of a SmartMotor to the user."""

from collections.abc import Iterator

from axistwin.bench.acts import Act, Say, Wait
from axistwin.bench.programs.stored_programs import READY
from axistwin.controllers.smartmotor.card import ASLEEP, CLOSED, NOT_ADDRESSED
from axistwin.controllers.smartmotor.kernel.servo import COOLER
from axistwin.controllers.smartmotor.language.forms import Accept, Instruction
from axistwin.controllers.smartmotor.language.language import read
from axistwin.core.units import MS
from axistwin.ui.teaching.guide import Guide, Reason, Term, described
from axistwin.ui.teaching.remedies import MARGIN, at_limit

LIMITS = (("Bp", "C", "plus", "UCI"), ("Bm", "D", "minus", "UDI"))
LIMIT_AGAIN = {"UCI": "UCP", "UDI": "UDM"}
REVERSED = 2  # The bit of F that reverses the direction of the shaft.
GIVEN = (("RA", "acceleration", "A=100"), ("V", "velocity", "V=100000"))
"""The parameters without which nothing moves: register, name and an example."""
STARTED = 200 * MS


class SmartMotorGuide(Guide):
    """Explains a SmartMotor."""

    accepted = (b"WAKE",)
    suggestions = (
        ("A=100 V=100000 MP", "acceleration, velocity, mode position"), ("P=4000 G", "go to position 4000"),
        ("RP", "report the position"), ("RW", "report the status word"), ("OFF", "servo off"),
    )  # fmt: skip

    @property
    def ready(self) -> bool:
        """True while the motor has power and obeys the host, if the host sends the motor's address."""
        return self.controller.powered and self.controller.ignoring in ("", NOT_ADDRESSED)

    def reasons(self) -> Iterator[Reason]:
        if not self.controller.powered:
            yield Reason("the power is off", self.remedies.power("on"))
            return
        if ignoring := self.controller.ignoring:
            yield Reason(ignoring, self._obeying(ignoring))
            return
        if rate := list(self.line()):
            yield from rate
            return
        flags = {lamp.label for lamp in self.lamps("RW") if int(self.value("RW")) >> (lamp.bit or 0) & 1}
        active = [limit for limit in LIMITS if limit[0] in flags]
        yield from dict.fromkeys(self._limited(*limit) for limit in active)
        if not active and flags & {"Br", "Bl"}:
            yield Reason("a limit fault has not been cleared (Br, Bl)", "type  ZS")
        if "Be" in flags:
            yield Reason("the position error has exceeded E (Be)", "free the shaft, or raise E, and then type  ZS")
        if "Bh" in flags:
            yield Reason("the motor has been too hot (Bh)", self._cooled())
        if not int(self.value("RAMPS")):
            yield Reason("the PWM limit AMPS is 0", "type  AMPS=1023")
        again = " G" if "Bt" in flags else ""
        for name, meaning, given in GIVEN:
            if not int(self.value(name)):
                yield Reason(f"no {meaning} has been given", f"type  {given}{again}")
        if "Bk" in flags:
            yield Reason("the stored program is corrupt, and does not run (Bk)", "store it again, or type  :store END")

    def _obeying(self, ignoring: str) -> str:
        if ignoring == ASLEEP:
            return "type  WAKE"
        if ignoring == NOT_ADDRESSED:
            return self.remedies.address(int(self.value("RADDR")))
        if ignoring == CLOSED:
            return self.remedies.power("off", "on")
        return self.remedies.mend("the supply")

    def _cooled(self) -> str:
        cool = int(self.value("RTH")) - COOLER
        warm = int(self.value("RTEMP")) > cool
        return f"let it cool from {self.value('RTEMP')} to {cool} °C, and then type  ZS" if warm else "type  ZS"

    def _limited(self, flag: str, name: str, side: str, command: str) -> Reason:
        pin, other = self.controller.pins[name], {"plus": "minus", "minus": "plus"}[side]
        low, high, position = (int(self.value(each)) for each in ("RSLN", "RSLP", "RP"))
        if self.value("SLE") and (position >= high if side == "plus" else position <= low):
            margin = min(MARGIN, (high - low) // 2)
            if margin < 1:
                return Reason("the software limits SLN and SLP leave no room", "type  SLD ZS")
            move = self._move(high - margin if side == "plus" else low + margin)
            reached = f"the software limit {'SLP' if side == 'plus' else 'SLN'} is reached ({flag})"
            return Reason(f"{reached}: move away in {other}", f"type  {move}")
        if not (pin.held or pin.driven or pin.wired):
            wire = f"wire pin {name} to ground, or make it an input, and clear the fault"
            return Reason(f"the {side} limit is active ({flag}): {wire}", f"type  {command} ZS")
        found, away = at_limit(self.controller, side == "plus"), ""
        if found is not None and int(self.value("RF")) & REVERSED:
            move = f"{command} {self._move(position - found[2])}  and then  {LIMIT_AGAIN[command]}"
            away = f"F=2 reverses the shaft, but not the switches: move away in {side}: type  {move}"
        elif found is not None:
            away = f"the load is on the switch: move away in {other}: type  {self._move(position + found[2])}"
        remedy = self.restored(name, "low", then="  and then  ZS", away=away)
        return Reason(f"the {side} limit is active ({flag})", remedy)

    def _move(self, target: int) -> str:
        """Return the commands of a move to `target`, also for a motor that has not moved before."""
        missing = "".join(f"{given} " for name, _, given in GIVEN if not int(self.value(name)))
        return f"ZS {missing}MP P={target} G"

    def answer(self, request: bytes, reply: bytes) -> str:
        words, text = request.decode("latin-1").split(), reply.strip().decode("latin-1")
        asked = words[-1] if words else ""
        if asked in ("RW", "RS") and text.isdecimal():
            return self.bits("RW", int(text))
        if asked.startswith("RB") and text in ("0", "1"):
            name = next((lamp.name for lamp in self.lamps("RW") if f"R{lamp.label}" == asked), "")
            return name and f"{name}: {'yes' if text == '1' else 'no'}"
        if shown := self.shown(asked, text):
            return shown
        found = self.controller.product.commands.get(asked)
        return found.name.removeprefix("report ") if found is not None else ""

    def number(self, value: int) -> Iterator[str]:
        if 0 <= value <= 0xFFFF:
            yield "as status word W, bit by bit:"
            for lamp in self.lamps("RW"):
                if lamp.bit is not None and value >> lamp.bit & 1:
                    yield f"  {1 << lamp.bit:5}  {lamp.label}  {lamp.name}{'.  ' + lamp.doc if lamp.doc else ''}"

    def command(self, text: str) -> Iterator[str]:
        whole = read(text)
        found = [whole.command] if whole.problem is None else [read(word).command for word in text.split()]
        yield from dict.fromkeys(described(command) for command in found if command is not None)

    def initialisation(self) -> Iterator[Act]:
        """Yield the commands that clear the limit fault, which open limit inputs cause at power-up."""
        if self.controller.powered:
            yield Wait(STARTED)
            if self.controller.ignoring == ASLEEP:
                yield Say(b"WAKE ")
            yield Say(READY)
            yield Wait(STARTED)

    def words(self) -> list[Term]:
        return [
            Term(str(each.code).rstrip("np"), each.name, each.syntax)
            for each in self.controller.product.commands
            if isinstance(each, Instruction) and Accept.HOST in each.accepted and "…" not in str(each.code)
        ]
