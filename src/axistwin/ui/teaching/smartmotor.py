"""Explains the commands and the replies of a SmartMotor to the user."""

from collections.abc import Iterator

from axistwin.controllers.smartmotor.language.forms import Accept, Instruction
from axistwin.controllers.smartmotor.language.language import read
from axistwin.scenes.reasons.smartmotor import SmartMotorReasons
from axistwin.ui.teaching.guide import Guide, Term, described


class SmartMotorGuide(SmartMotorReasons, Guide):
    """Explains a SmartMotor."""

    accepted = (b"WAKE",)

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

    def words(self) -> list[Term]:
        return [
            Term(str(each.code).rstrip("np"), each.name, each.syntax)
            for each in self.controller.product.commands
            if isinstance(each, Instruction) and Accept.HOST in each.accepted and "…" not in str(each.code)
        ]
