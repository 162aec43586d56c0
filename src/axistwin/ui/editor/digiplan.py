"""Language support for `.if1`: command lines of an IF1 or IF2."""

from collections.abc import Iterator

from axistwin.controllers.digiplan import rules
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import Accept, Instruction, Message, parse
from axistwin.ui.editor.answers import Hover, Item, Symbol, explain, item

NUMBER_CHARACTERS = frozenset("0123456789+-, ")
MISPLACED = (rules.UNKNOWN, rules.LOST_NUMBER, rules.ALONE, rules.SETUP, rules.MISPLACED, rules.NOT_IN_THIS_KIND,
             rules.ORDER, rules.TWICE)  # fmt: skip
"""Codes of errors for a character at a wrong place."""
OPERANDS = ("", "1", "+1", "1,1")  # Operands that are tried after a command to find out if it can be valid.


class CommandLines:
    """Language support for `.if1` files.  Each line is a message, a pause (`+`), an action (`!`) or a comment."""

    def hover(self, lines: list[str], line: int, at: int) -> Hover | None:
        return hover(_message(lines[line - 1]), at)

    def complete(self, lines: list[str], line: int, at: int) -> list[Item]:
        text = lines[line - 1][:at]
        return [] if ";" in text or _message(text) != text else following(text)

    def symbols(self, lines: list[str]) -> list[Symbol]:
        return [s for number, line in enumerate(lines, 1) for s in sequences(_message(line), number)]


def _message(line: str) -> str:
    words = line.partition(";")[0]
    return "" if words.lstrip().startswith(("+", "!")) else words


def hover(text: str, at: int, offset: int = 0) -> Hover | None:
    """Return the meaning of the command at the index `at`; `offset`: the message's column."""
    if not 0 <= at < len(text):
        return None
    begin = at
    while begin > 0 and text[begin] in NUMBER_CHARACTERS:
        begin -= 1
    found = COMMANDS.get(text[begin])
    if found is None or (text[begin] == " "):
        return None
    return Hover(explain(found), offset + begin, offset + max(at, begin) + 1)


def following(text: str) -> list[Item]:
    """Return the commands that may follow an incomplete message of an IF1."""
    return [item(command, str(command.code)) for command in COMMANDS if _may_follow(text, command)]


def _may_follow(text: str, command: object) -> bool:
    if not isinstance(command, Instruction) or Accept.SETUP in command.accepted or str(command.code).isspace():
        return False
    return any(_is_valid_after(text, f"{command.code}{operand}") for operand in OPERANDS)


def _is_valid_after(text: str, added: str) -> bool:
    found = parse(text + added, COMMANDS).problems
    return not any(
        problem.rule is rules.CONTROL_ALONE or (problem.rule in MISPLACED and problem.position >= len(text))
        for problem in found
    )


def sequences(text: str, line: int, offset: int = 0) -> Iterator[Symbol]:
    """Yield the sequence of a message with its steps; nothing if the message is not a sequence."""
    if not text.lstrip().startswith(":"):
        return
    message = parse(text.rstrip(), COMMANDS)
    if not message.places:
        return
    ends = [*message.places[1:], len(text.rstrip())]
    steps = [
        _step(message, number, line, offset, place, end)
        for number, (place, end) in enumerate(zip(message.places, ends, strict=True), start=1)
    ]
    whole = (line, offset + 1), (line, offset + len(text.rstrip()) + 1)
    yield Symbol("sequence", "sequence", *whole, f"{len(steps)} steps", steps)


def _step(message: Message, number: int, line: int, offset: int, begin: int, end: int) -> Symbol:
    text = message.text[begin:end].rstrip("$ ").removesuffix(":").strip()
    return Symbol(f"step {number}", "step", (line, offset + begin + 1), (line, offset + end + 1), text)
