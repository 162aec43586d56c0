"""Command lines of an IF1 or IF2: what a character means, which may follow, the steps of sequences."""

from collections.abc import Iterator

from axistwin.controllers.digiplan import rules
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import Accept, Instruction, Message, parse
from axistwin.editor.answers import Hover, Item, Symbol, explained, item

OF_A_NUMBER = frozenset("0123456789+-, ")
MISPLACED = (rules.UNKNOWN, rules.LOST_NUMBER, rules.ALONE, rules.SETUP, rules.CANNOT_STAND, rules.NOT_IN_THIS_KIND,
             rules.ORDER, rules.TWICE)  # fmt: skip
"""What the reader says of a character that may not stand where it stands."""
BEHIND = ("", "1", "+1", "1,1")
"""What a character may need behind it, before one can tell."""


class CommandLines:
    """`.if1`: each line is a message; `;` begins a comment, `+` and `!` what is no message."""

    def hover(self, lines: list[str], line: int, at: int) -> Hover | None:
        """The command that the character at a place is, or belongs to."""
        return hover(_message(lines[line - 1]), at)

    def complete(self, lines: list[str], line: int, at: int) -> list[Item]:
        """The commands that may follow."""
        text = lines[line - 1][:at]
        return [] if ";" in text or _message(text) != text else following(text)

    def symbols(self, lines: list[str]) -> list[Symbol]:
        """The sequences, and their steps."""
        return [s for number, line in enumerate(lines, 1) for s in sequences(_message(line), number)]


def _message(line: str) -> str:
    """What is typed."""
    words = line.partition(";")[0]
    return "" if words.lstrip().startswith(("+", "!")) else words


def hover(text: str, at: int, offset: int = 0) -> Hover | None:
    """The command at an index into a message that begins at column `offset`."""
    if not 0 <= at < len(text):
        return None
    begin = at
    while begin > 0 and text[begin] in OF_A_NUMBER:
        begin -= 1
    found = COMMANDS.get(text[begin])
    if found is None or (text[begin] == " "):
        return None
    return Hover(explained(found), offset + begin, offset + max(at, begin) + 1)


def following(text: str) -> list[Item]:
    """The commands that may follow this beginning of a message."""
    return [item(command, str(command.code)) for command in COMMANDS if _may_follow(text, command)]


def _may_follow(text: str, command: object) -> bool:
    if not isinstance(command, Instruction) or Accept.SETUP in command.accepted or str(command.code).isspace():
        return False
    return any(_stands(text, f"{command.code}{behind}") for behind in BEHIND)


def _stands(text: str, added: str) -> bool:
    found = parse(text + added, COMMANDS).problems
    return not any(
        problem.rule is rules.CONTROL_ALONE or (problem.rule in MISPLACED and problem.position >= len(text))
        for problem in found
    )


def sequences(text: str, line: int, offset: int = 0) -> Iterator[Symbol]:
    """The sequence that a message is, if it is one, with its steps."""
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
