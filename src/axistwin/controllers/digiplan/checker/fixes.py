"""Fixes for problems of messages.  A fix is sure if the fixed message has fewer problems, or has the same effect."""

import re
from collections.abc import Sequence

from axistwin.controllers.diagnostics import Fix, Sent, fixing, put_before, put_behind, replaced
from axistwin.controllers.digiplan import rules
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import Message, parse
from axistwin.controllers.digiplan.step import Problem

_DISTANCE = re.compile(r"[XYZ] *[+-]? *(\d[\d ]*\d|\d)")


def of(text: Sequence[Sent], message: Message, problem: Problem) -> Fix | None:
    """Return a correction of an invalid message from the host, or None if no correction is known."""
    if problem.rule is rules.UNKNOWN:
        return _upper_case(text, message, problem)
    if problem.rule is rules.SEQUENCE_END:
        return _sequence_end(text, message)
    return None


def start(text: Sequence[Sent]) -> Fix | None:
    """Return a fix that adds `$`; it is not sure, because a message that only sets parameters is valid too."""
    return fixing("end the message with $", put_behind(text[-1], "$"), sure=False)


def without_distance(text: Sequence[Sent], message: Message, at: int) -> Fix | None:
    """Return a fix that removes the distance from a run, which has none: `X100G` becomes `XG`."""
    found = _DISTANCE.match(message.text, at)
    return None if found is None else fixing("remove the distance", replaced(text[found.start(1) : found.end(1)], ""))


def _upper_case(text: Sequence[Sent], message: Message, problem: Problem) -> Fix | None:
    begin, end = problem.position, problem.end
    wrong = message.text[begin:end]
    better = wrong.upper()
    if better == wrong or not _mends(message, message.text[:begin] + better + message.text[end:]):
        return None
    return fixing(f"write {better}", replaced(text[begin:end], better))


def _sequence_end(text: Sequence[Sent], message: Message) -> Fix | None:
    """Return a fix that adds `:`, `$` or both, so that a sequence ends in `:$`."""
    bare = message.text.rstrip(" ")
    last = text[len(bare) - 1]
    missing = ":" if bare.endswith("$") else "$" if bare.endswith(":") else ":$"
    better = f"{bare[:-1]}:$" if missing == ":" else bare + missing
    edits = put_before(last, ":") if missing == ":" else put_behind(last, missing)
    return fixing("end the sequence with :$", edits) if _mends(message, better) else None


def _mends(message: Message, better: str) -> bool:
    return len(parse(better, COMMANDS).problems) < len(message.problems)
