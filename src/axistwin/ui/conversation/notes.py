"""Notes of the tutor for a page: sentences with lines to type, which two blanks mark."""

import re

_LEAD = r"(?:\b(?:type|sends?|and|then|or)  |,  (?!(?:and|so|unless|which)\b)|^  )"
_LINE = re.compile(_LEAD + r"(?P<line>\S.*?)(?=  |, |: |$)", re.IGNORECASE)


def parts(note: str) -> list[tuple[str, str]]:
    """Split a note into texts and lines to type; each part is a text and its kind, "" or "line"."""
    found, at = [], 0
    for line in _LINE.finditer(note):
        found.append((_plain(note[at : line.start("line")]), ""))
        found.append((line["line"].rstrip(), "line"))
        at = line.end("line")
    found.append((_plain(note[at:]), ""))
    return [(text, kind) for text, kind in found if text]


def _plain(text: str) -> str:
    """Return a text with single blanks; three blanks stand between a line and its meaning."""
    return re.sub(r" {2,}", " ", re.sub(r"^ {3,}(?=\S)", ": ", text))
