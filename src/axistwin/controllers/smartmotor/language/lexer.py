"""Lexical rules (section 3 of the base language): where a command ends, in a host's data and in the text of a program.

A space, CR, LF or NUL ends a command; between quotes a space does not.  A list of array values ends with its
period.  In a program, a tab is a space, `'` begins a comment, and the word after IF, ELSEIF, WHILE, SWITCH or CASE
belongs to the same statement.
"""

import re
from collections.abc import Iterator

BEFORE_EXPRESSION = frozenset({"IF", "ELSEIF", "WHILE", "SWITCH", "CASE"})

_blank = re.compile(r"(?:[ \t\r\n\0]+|'[^\r\n\0]*)*")
_word = re.compile(r"""(?:"[^"\r\n\0]*"?|[^ \t\r\n\0'"])+""")
_next_word = re.compile(rf"[ \t]+({_word.pattern})")
_line_end = re.compile(r"\r\n|[\r\n]")


def begins_list(text: str) -> bool:
    """True if the text begins a list of array values, `aw[0] 0 100 500 700.` (manual, section 1.1)."""
    if not text.startswith(("ab[", "aw[", "al[")):
        return False
    deep = 0
    for at, character in enumerate(text):
        deep += (character == "[") - (character == "]")
        if deep == 0 and at > 2:
            return text[at + 1 : at + 2] in ("", " ", "\t")
    return False


def statements(text: str) -> Iterator[tuple[int, int]]:
    """Yield the begin and end index of each statement in the text of a program."""
    at = _skip(text, 0)
    while at < len(text):
        match = _word.match(text, at)
        assert match is not None
        end = _extended(text, at, match.end())
        yield at, end
        at = _skip(text, end)


def _skip(text: str, at: int) -> int:
    match = _blank.match(text, at)
    assert match is not None
    return match.end()


def _extended(text: str, begin: int, end: int) -> int:
    if text[begin:end] in BEFORE_EXPRESSION:
        match = _next_word.match(text, end)
        return match.end() if match else end
    if not begins_list(text[begin:end]):
        return end
    while not text.endswith(".", begin, end):
        match = _next_word.match(text, end)
        if match is None:
            break
        end = match.end()
    return end


def line_begins(text: str) -> list[int]:
    return [0, *(match.end() for match in _line_end.finditer(text))]
