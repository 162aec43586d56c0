"""The tutor of one controller: comments on the data sent and received, and answers to questions."""

import re
from collections.abc import Iterator, Sequence
from difflib import get_close_matches

from axistwin.bench import Controller
from axistwin.bench.acts import Act
from axistwin.bench.controller import on_a_bus
from axistwin.controllers.diagnostics import Diagnostic, Rule, Severity, check_last
from axistwin.controllers.product import Refusal
from axistwin.core.errors import PlacedError
from axistwin.scenes.diagnostics.codes import tables
from axistwin.scenes.reasons.remedies import Remedies
from axistwin.sim.manual_actions import ManualAct
from axistwin.ui.teaching.guide import Guide, PlainGuide, Term

LONGEST = 400  # Number of earlier lines that are checked together with a new line of the host.
_COMMAND = re.compile(r":([a-z]+)(?:\s+(.*))?")
_CODE = re.compile(r"[A-Z]{2}\d{3}")
_NUMBER = re.compile(r"-?\d+")


def own_command(line: str) -> tuple[str, str] | None:
    """Split a command of a terminal itself, e.g. `:why`, into name and argument; None for a line of any controller."""
    found = _COMMAND.fullmatch(line)
    return None if found is None else (found[1], (found[2] or "").strip())


class Tutor:
    """Explains the lines that a host sends to one controller, and the answers of the controller."""

    def __init__(self, controller: Controller, remedies: Remedies | None = None) -> None:
        self.controller = controller
        self.on = True  # True if the tutor is switched on.
        self.guide = _guide(controller)
        self.guide.remedies = remedies or Remedies()
        self._lines: list[bytes] = []
        self._request = b""
        self._reply = bytearray()
        self._told: set[str] = set()
        self._ignored = ""  # Why the controller has ignored the last line in its present state, with the remedy.
        controller.manual_actions.subscribe(self._handled)
        controller.subscribe_refusals(self._note_refusal)

    # Comments

    def sending(self, line: bytes) -> list[str]:
        if not line:
            return []
        self._request, self._ignored = line, ""
        self._reply.clear()
        text = line.strip()
        if not self.guide.ready:
            in_the_way = [str(reason) for reason in self.guide.reasons()][:1]
            return in_the_way if text and not text.startswith(self.guide.accepted) else []
        notes = list(self.guide.notes(line))
        found = self._refused(line)
        self._lines = [*self._lines, line][-LONGEST:]
        refused = any(each.severity is Severity.ERROR for each in found)
        comments = [words for each in found for words in self._comment(each)]
        return comments if refused else [*comments, *notes]

    def received(self, data: bytes) -> list[str]:
        if on_a_bus(self.controller):
            return self._answered(data)
        comments = []
        for byte in data:
            self._reply.append(byte)
            if byte in b"\r\n" or self._request.strip() == b"Q":
                comments += self._answered(bytes(self._reply))
                self._reply.clear()
        return comments

    def unreadable(self, error: PlacedError) -> list[str]:
        return [self._rule(error.code).explanation] if error.code and self._once(error.code) else []

    # Questions

    def why(self) -> list[str]:
        moving = {name: axis for name, axis in self.controller.axes.items() if axis.moving}
        reasons = self._reasons()
        # A SmartMotor without acceleration or velocity has a trajectory in progress, but never turns.
        if moving and not (reasons and all(axis.velocity == 0 for axis in moving.values())):
            return [f"{' and '.join(moving)} {'is' if len(moving) == 1 else 'are'} moving"]
        return reasons or ["a move is possible: try", *self._suggested(1)]

    def next(self) -> list[str]:
        return self._reasons()[:1] or self._suggested(3)

    def explain(self, words: str) -> list[str]:
        words = words.strip() or self._request.strip().decode("latin-1")
        found = list(self._explanations(words))
        if found:
            return found
        known = [word.text for word in self.guide.words()]
        close = get_close_matches(words, [*known, *self.controller.pins], 3)
        return [f"no meaning known for {words!r}" + (f": did you mean {' or '.join(close)}?" if close else "")]

    def initialisation(self) -> Iterator[Act]:
        return self.guide.initialisation()

    def words(self) -> list[Term]:
        return self.guide.words()

    # Parts

    def _reasons(self) -> list[str]:
        reasons = [str(reason) for reason in self.guide.reasons()]
        return reasons or [f"the last line was ignored: {self._ignored}"] * bool(self._ignored)

    def _suggested(self, count: int) -> list[str]:
        listed = (self.guide.suggestions or [(word.syntax, word.meaning) for word in self.guide.words()])[:count]
        width = max((len(line) for line, _ in listed), default=0)
        return [f"type  {line.ljust(width)}   {meaning}" for line, meaning in listed]

    def _explanations(self, words: str) -> Iterator[str]:
        if _CODE.fullmatch(words.upper()) and (rule := self._find(words.upper())) is not None:
            yield f"{rule.code}  {rule.title} ({rule.severity}; manual: {rule.chapter})"
            yield rule.explanation
        elif words in self.controller.pins:
            pin = self.controller.pins[words]
            docs = [lamp for group in self.controller.product.front for lamp in group.items if lamp.source == words]
            yield f"{words}: {docs[0].name if docs else 'a terminal'}, now {'high' if pin.level else 'low'}"
            yield from (lamp.doc for lamp in docs if lamp.doc)
        elif _NUMBER.fullmatch(words) and not on_a_bus(self.controller):
            yield from self.guide.number(int(words))
        elif words:
            yield from self.guide.command(words)

    def _comment(self, found: Diagnostic) -> Iterator[str]:
        mark = "refused" if found.severity is Severity.ERROR else "note"
        yield f"{mark}: {found.words}"
        if self._once(found.code):
            yield self._rule(found.code).explanation

    def _once(self, code: str) -> bool:
        first = code not in self._told
        self._told.add(code)
        return first

    def _rule(self, code: str) -> Rule:
        found = self._find(code)
        assert found is not None, "every diagnostic has a rule"
        return found

    def _find(self, code: str) -> Rule | None:
        return next(
            (
                rule
                for table in (*tables().values(), self.controller.product.rules)
                for rule in table
                if rule.code == code
            ),
            None,
        )

    def _answered(self, reply: bytes) -> list[str]:
        meaning = self.guide.answer(self._request, reply)
        return [meaning] if meaning else []

    def _refused(self, line: bytes) -> Sequence[Diagnostic]:
        check = self.controller.product.check
        return check_last(check, [*self._lines, line]) if check is not None else ()

    def _note_refusal(self, refusal: Refusal) -> None:
        self._ignored = "" if refusal.rule is not None else refusal.why

    def _handled(self, act: str, *_values: object) -> None:
        if act == ManualAct.POWER:  # Power-off cancels the effect of earlier commands.
            self._lines.clear()
            self._ignored = ""


def _guide(controller: Controller) -> Guide:
    match controller.product.family:
        case "digiplan":
            from axistwin.ui.teaching.digiplan import DigiplanGuide

            return DigiplanGuide(controller)
        case "compumotor":
            from axistwin.ui.teaching.compumotor import CompumotorGuide

            return CompumotorGuide(controller)
        case "smartmotor":
            from axistwin.ui.teaching.smartmotor import SmartMotorGuide

            return SmartMotorGuide(controller)
    return PlainGuide(controller)
