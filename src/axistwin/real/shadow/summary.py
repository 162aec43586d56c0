"""What a shadow has found, as text and as JSON."""

from collections.abc import Iterator
from typing import Any

from axistwin.core.units import MS
from axistwin.real.shadow.findings import stamp
from axistwin.real.shadow.shadow import Shadow


def as_dict(shadow: Shadow, since_ns: int, now_ns: int) -> dict[str, Any]:
    moves = {
        kind: {
            "count": usual.count, "usual_later_ms": usual.median / MS, "drift_ms": usual.drift / MS,
            "trend_ms_per_day": usual.trend / MS,
        }
        for kind, usual in shadow.learned.moves().items()
    }  # fmt: skip
    return {
        "since": stamp(since_ns),
        "until": stamp(now_ns),
        "answers": shadow.pairs,
        "state": state(shadow),
        "findings": [found.as_dict() for found in shadow.findings.differences],
        "notes": [found.as_dict() for found in shadow.findings.notes],
        "further": shadow.findings.further,
        "moves": moves,
    }


def state(shadow: Shadow) -> str:
    if shadow.silent_since_ns is not None:
        return f"silent since {stamp(shadow.silent_since_ns)}"
    if not shadow.following:
        return "waits for the first answer"
    return "differs" if shadow.findings.differences else "agrees"


def lines(shadow: Shadow, since_ns: int, now_ns: int) -> Iterator[str]:
    different = shadow.findings.differences
    count = len(different)
    yield f"{stamp(since_ns)} to {stamp(now_ns)}: {shadow.pairs} answers, {count or 'no'} finding{'s' * (count != 1)}"
    for found in different:
        times = "once" if found.count == 1 else f"{found.count} times, last at {stamp(found.last_ns)}"
        yield f"  {found.line()}: {times}"
    for kind, usual in shadow.learned.moves().items():
        if usual.learnt:
            trend = f", {usual.trend / MS:+.1f} ms a day" if usual.trend else ""
            yield f"  move {kind}: {usual.count} times, {usual.drift / MS:+.1f} ms from the usual time{trend}"
