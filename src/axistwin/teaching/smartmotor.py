"""Explains the commands, the replies and the state of a SmartMotor to the user."""

from collections.abc import Iterator

from axistwin.bench.acts import Act, Say, Wait
from axistwin.controllers.smartmotor.language.forms import Accept, Instruction
from axistwin.controllers.smartmotor.language.language import read
from axistwin.programs.stored_programs import READY
from axistwin.teaching.guide import Guide, Reason, Term, described
from axistwin.teaching.remedies import at_limit
from axistwin.units import MS

LIMITS = (("Bp", "Br", "C", "plus", "UCI"), ("Bm", "Bl", "D", "minus", "UDI"))
CLEARED = {
    "Be": "the position error has exceeded E",
    "Bh": "the motor has been too hot",
    "Bk": "the program is corrupt",
}
STARTED = 200 * MS


class SmartMotorGuide(Guide):
    """Explains the commands, the replies and the state of a SmartMotor to the user."""

    suggestions = (
        ("A=100 V=100000 MP", "acceleration, velocity, mode position"),
        ("P=4000 G", "go to position 4000"),
        ("RP", "report the position"),
        ("RW", "report the status word"),
        ("OFF", "servo off"),
    )

    @property
    def ready(self) -> bool:
        """True while the motor has power."""
        return self.controller.powered

    def reasons(self) -> Iterator[Reason]:
        """Yield each reason why the motor cannot start a move, e.g. an active limit."""
        if not self.controller.powered:
            yield Reason("the power is off", self.remedies.power("on"))
            return
        flags = {lamp.label for lamp in self.lamps("RW") if int(self.value("RW")) >> (lamp.bit or 0) & 1}
        active = False
        for now, _, pin, side, command in LIMITS:
            if now in flags:
                active = True
                yield self._limited(now, pin, side, command)
        if not active and flags & {"Br", "Bl"}:
            yield Reason("a limit fault has not been cleared (Br, Bl)", "type  ZS")
        for flag, meaning in CLEARED.items():
            if flag in flags:
                yield Reason(f"{meaning} ({flag})", "type  ZS")
        if not int(self.value("RAMPS")):
            yield Reason("the PWM limit AMPS is 0", "type  AMPS=1023")
        if not int(self.value("RA")):
            yield Reason("no acceleration has been given", "type  A=100")
        if not int(self.value("V")):
            yield Reason("no velocity has been given", "type  V=100000")

    def _limited(self, flag: str, name: str, side: str, command: str) -> Reason:
        """Describe an active limit, and tell the user how to make the limit inactive."""
        pin, found = self.controller.pins[name], at_limit(self.controller, side == "plus")
        if not (pin.held or pin.driven or pin.wired):
            wire = f"wire pin {name} to ground, or make it an input, and clear the fault"
            return Reason(f"the {side} limit is active ({flag}): {wire}", f"type  {command} ZS")
        away = ""
        if found is not None:
            _, axis, distance = found
            other = {"plus": "minus", "minus": "plus"}[side]
            away = f"the load is on the switch: move away in {other}: type  ZS MP P={axis.position + distance} G"
        remedy = self.restored(name, "low", then="  and then  ZS", away=away)
        return Reason(f"the {side} limit is active ({flag})", remedy)

    def answer(self, request: bytes, reply: bytes) -> str:
        """Return the meaning of the answer to the last report command."""
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
        """Yield the meaning of each bit that is 1 in a status word."""
        if 0 <= value <= 0xFFFF:
            yield "as status word W, bit by bit:"
            for lamp in self.lamps("RW"):
                if lamp.bit is not None and value >> lamp.bit & 1:
                    yield f"  {1 << lamp.bit:5}  {lamp.label}  {lamp.name}{'.  ' + lamp.doc if lamp.doc else ''}"

    def command(self, text: str) -> Iterator[str]:
        """Yield a description of each command in a line of SmartMotor code."""
        whole = read(text)
        found = [whole.command] if whole.problem is None else [read(word).command for word in text.split()]
        yield from dict.fromkeys(described(command) for command in found if command is not None)

    def initialisation(self) -> Iterator[Act]:
        """Yield the commands that clear the limit fault after power-up.

        Without limit switches, the motor reports its open limit inputs as a fault.
        """
        if self.controller.powered:
            yield Wait(STARTED)
            yield Say(READY)
            yield Wait(STARTED)

    def words(self) -> list[Term]:
        """Return the commands that a host may send to a SmartMotor."""
        return [
            Term(str(each.code).rstrip("np"), each.name, each.syntax)
            for each in self.controller.product.commands
            if isinstance(each, Instruction) and Accept.HOST in each.accepted and "…" not in str(each.code)
        ]
