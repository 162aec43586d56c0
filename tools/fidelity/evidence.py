"""The four classes of evidence, and the rules for the class of an entry."""

import re
from enum import StrEnum


class Evidence(StrEnum):
    """Class of the evidence for a row."""

    TEXT = "manual text"
    EXAMPLE = "manual example"
    HOST = "real host software"
    INFERRED = "inferred"


_SIGNS = (
    (Evidence.INFERRED, r"^(silent|physics|electrical|arithmetic|unknown|nothing|no word|no command tells)\b"),
    (Evidence.HOST, r"\breal hosts?\b|\bbase \d|\bbase\b|\bEPICS\b|\bdriver\b.*\bsends\b|user of these motors"),
    (Evidence.EXAMPLE, r"\bsamples? \d|\bexamples?\b|\bprinted?\b|\bprints\b|worked|\blisting|sample program"),
    (Evidence.TEXT, r"[\"“]|\d|[A-Z][\w/ -]+:|:"),
    (Evidence.INFERRED, r"."),
)
"""Rules in order: the first match decides; an entry without chapter and quotation is inferred."""


def classify(words: str) -> Evidence:
    """Return the class of an entry's evidence.  An entry may begin with the name of its class and a colon."""
    for named in Evidence:
        if words.lower().startswith(f"{named}:"):
            return named
    return next(kind for kind, sign in _SIGNS if re.search(sign, words))
