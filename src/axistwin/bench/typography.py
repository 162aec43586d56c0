"""Characters of word processors that look like ASCII: quotation marks, a minus sign, a no-break space."""

import re

from axistwin.bench import rules
from axistwin.core.errors import ProgramError

KINDS = {
    "typographic quotation mark": {**dict.fromkeys("“”„‟«»″", '"'), **dict.fromkeys("‘’‚‛′", "'")},
    "typographic minus": dict.fromkeys("‐‑‒–—―−", "-"),
    "no-break space": dict.fromkeys("\xa0\u202f\u205f\u3000" + "".join(map(chr, range(0x2000, 0x200B))), " "),
}
"""ASCII character that is meant, by kind and character."""
MEANT = {character: meant for found in KINDS.values() for character, meant in found.items()}
_ASCII = str.maketrans(MEANT)
_odd = re.compile(f"[{''.join(MEANT)}]")


def as_ascii(text: str) -> str:
    """Return a text of the same length with the ASCII characters that are meant."""
    return text.translate(_ASCII)


def kinds(text: str) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    for match in _odd.finditer(text):
        found.setdefault(_kind(match[0]), []).append(match.start())
    return found


def _kind(character: str) -> str:
    return next(name for name, characters in KINDS.items() if character in characters)


def named(character: str) -> str:
    """Return the error message about a typographic character, or "" for any other character."""
    if character not in MEANT:
        return ""
    shown = character if character.isprintable() else f"U+{ord(character):04X}"
    return f"{shown} is a {_kind(character)}: write {MEANT[character].replace(' ', 'a blank')}"


def refuse(text: str, file: str = "", line: int = 0) -> None:
    """Raise ProgramError at the first typographic character of a text."""
    if found := _odd.search(text):
        raise ProgramError(
            named(found[0]), file=file, line=line, column=found.start() + 1, code=rules.TYPOGRAPHIC.code,
            instead=MEANT[found[0]], sure=True,
        )  # fmt: skip
