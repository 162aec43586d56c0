"""Measures and claims as sentences.  The schema and the documentation are generated from the tables of forms.

The robustness of a claim is its margin: positive if the claim holds, negative if the claim fails.  A claim about a
level (high, low) has an infinite robustness.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from axistwin.bench.faults.triggers import VERBS
from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, real, shortened
from axistwin.core.units import S, to_ns
from axistwin.sweeps.conditions import Condition, comparison, condition, series_of
from axistwin.sweeps.recording import Recording
from axistwin.sweeps.series import Series, combined, minimum

Answer = float | list[float] | None
_EVENT = re.compile(rf"\S+ (?:{'|'.join(VERBS)})(?: .*)?")


@dataclass(frozen=True)
class Finding:
    """The result of a measure or claim in one run.  `reason`: why a result is missing; `at_ns`: time of a failure."""

    value: Answer = None
    reason: str = ""
    holds: bool | None = None
    robustness: float | None = None
    at_ns: int | None = None


@dataclass(frozen=True)
class Sentence:
    """A parsed measurement or requirement, e.g. `final table.X.position` or `never table.X.position > 24000`.

    Contains the names of the signals, events and axes that a run must record.
    """

    text: str
    signals: tuple[str, ...]
    events: tuple[str, ...]
    answer: Callable[[Recording], Finding]
    axes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Form:
    """Syntax of one kind of measurement or requirement, e.g. `count EVENT` (number of events)."""

    form: str
    pattern: str
    meaning: str
    example: str
    read: Callable[[str, Mapping[str, str]], Sentence]


def measure(text: str) -> Sentence:
    """Parse the sentence of a measure.  Raises UsageError."""
    return _read(text, MEASURES, "measure")


def claim(text: str) -> Sentence:
    """Parse the sentence of a claim.  Raises UsageError."""
    return _read(text, CLAIMS, "claim")


def _read(text: str, forms: tuple[Form, ...], measure_or_claim: str) -> Sentence:
    words = " ".join(text.split())
    for form in forms:
        if found := re.fullmatch(form.pattern, words):
            return form.read(words, {name: part or "" for name, part in found.groupdict().items()})
    examples = ", ".join(repr(form.example) for form in forms[:3])
    raise UsageError(f"invalid {measure_or_claim} {shortened(text)}: expected e.g. {examples}")


# Parsers of texts that name a result of a run, e.g. "final table.X.position"


def _signal(text: str) -> tuple[str, Callable[[Recording], Series]]:
    name = text.strip("|").strip()
    if not name or " " in name or (text.startswith("|") is not text.endswith("|")):
        raise UsageError(
            f"invalid signal {shortened(text)}: expected e.g. table.X.velocity, or |motor.RPE| for a magnitude"
        )
    return name, series_of(name, magnitude=text.startswith("|"))


def _final(text: str, parts: Mapping[str, str]) -> Sentence:
    name, series = _signal(parts["signal"])
    return Sentence(text, (name,), (), lambda record: Finding(float(series(record).values[-1])))


def _masked(series: Series, where: Series | None) -> tuple[Any, Any]:
    if where is None:
        return series.values, series.seconds
    both = combined(lambda values, holds: np.stack((values, holds), axis=1), series, where)
    kept = both.values[:, 1] > 0
    return both.values[kept, 0], both.seconds[kept]


def _mean(values: Any, seconds: Any) -> float:
    return float(np.sum(values * seconds) / np.sum(seconds)) if np.sum(seconds) else float(values[-1])


STATISTICS: dict[str, Callable[[Any, Any], float]] = {
    "max": lambda values, _: float(np.max(values)), "min": lambda values, _: float(np.min(values)), "mean": _mean,
    "rms": lambda values, seconds: float(np.sqrt(_mean(values**2, seconds))),
    "integral": lambda values, seconds: float(np.sum(values * seconds)),
}  # fmt: skip


def _statistic(text: str, parts: Mapping[str, str]) -> Sentence:
    name, series = _signal(parts["signal"])
    during = condition(parts["during"]) if parts["during"] else None
    signals = (name, *(during.signals if during else ()))

    def answer(record: Recording) -> Finding:
        where = during.truth(record) if during else None
        values, seconds = _masked(series(record), where)
        if not len(values):
            return Finding(reason=f"never {parts['during']}")
        return Finding(STATISTICS[parts["what"]](values, seconds))

    return Sentence(text, signals, (), answer)


def _event(text: str) -> str:
    if not _EVENT.fullmatch(text):
        raise UsageError(
            f"invalid event {shortened(text)}: expected a name and a verb, e.g. 'table.X passes 1000'; "
            f"the verbs are {', '.join(VERBS)}"
        )
    return text


def _from_to(text: str, parts: Mapping[str, str]) -> Sentence:
    which = parts["which"] or "first"
    begin, end = _two_events(parts["events"])

    def answer(record: Recording) -> Finding:
        begins, ends = record.times(begin), record.times(end)
        for times, event in ((begins, begin), (ends, end)):
            if not len(times):
                return Finding(reason=f"no event '{event}'")
        spans = list(_spans(begins, ends))
        if not spans:
            return Finding(reason=f"no event '{end}' after '{begin}'")
        return Finding(spans if which == "each" else spans[0 if which == "first" else -1])

    return Sentence(text, (), (begin, end), answer)


def _two_events(text: str) -> tuple[str, str]:
    words = text.split(" to ")
    for n in range(1, len(words)):
        begin, end = " to ".join(words[:n]), " to ".join(words[n:])
        if _EVENT.fullmatch(begin) and _EVENT.fullmatch(end):
            return begin, end
    raise UsageError(
        f"invalid events {shortened(text)}: "
        "expected two events with 'to' between them, e.g. 'table.output1 rises to table.output1 falls'"
    )


def _spans(begins: Any, ends: Any) -> Iterator[float]:
    """Yield the time in seconds from each begin to the next end; pairs do not overlap."""
    after_ns = -1
    for begin_ns in begins:
        if begin_ns < after_ns:
            continue
        n = int(np.searchsorted(ends, begin_ns, "right"))
        if n == len(ends):
            return
        after_ns = ends[n]
        yield float(after_ns - begin_ns) / S


def _count(text: str, parts: Mapping[str, str]) -> Sentence:
    event = _event(parts["event"])
    return Sentence(text, (), (event,), lambda record: Finding(float(len(record.times(event)))))


def _energy(text: str, parts: Mapping[str, str]) -> Sentence:
    axis = parts["axis"]
    return Sentence(text, (), (), lambda record: Finding(record.energy(axis)), (axis,))


# Functions that parse claims, e.g. "table.X.velocity <= 4000 until table.output1 high"


def _verdict(truth: bool, robustness: float, at_ns: int | None) -> Finding:
    return Finding(holds=bool(truth), robustness=float(robustness), at_ns=None if truth else at_ns)


def _throughout(what: Condition, during: Condition | None) -> Callable[[Recording], Finding]:
    def answer(record: Recording) -> Finding:
        truth, margin = what.truth(record), what.robustness(record)
        where = during.truth(record) if during else truth.map(np.ones_like)
        if not np.any(where.values):
            return Finding(reason=f"never {during.text}" if during else "")
        kept = combined(lambda holds, there: np.where(there > 0, holds, 1), truth, where)
        margins = combined(lambda value, there: np.where(there > 0, value, np.inf), margin, where)
        failing = kept.times[kept.values == 0]
        return _verdict(not len(failing), minimum(margins.values), int(failing[0]) if len(failing) else None)

    return answer


def _always(text: str, parts: Mapping[str, str]) -> Sentence:
    what = condition(parts["what"])
    during = condition(parts["during"]) if parts["during"] else None
    return Sentence(text, (*what.signals, *(during.signals if during else ())), (), _throughout(what, during))


def _never(text: str, parts: Mapping[str, str]) -> Sentence:
    if _EVENT.fullmatch(parts["what"]):
        return _never_event(text, parts)
    return _always(text, {**parts, "what": f"not ({parts['what']})"})


def _never_event(text: str, parts: Mapping[str, str]) -> Sentence:
    event = parts["what"]
    during = condition(parts["during"]) if parts["during"] else None
    axis, verb, *rest = event.split()
    signals = during.signals if during else ()
    if verb == "passes":
        position = _position(rest[0] if rest else "")
        passing = (f"{axis}.position", position, 0 if len(rest) < 2 else {"up": 1, "down": -1}.get(rest[1], 0))
        return Sentence(
            text, (*signals, passing[0]), (event,), lambda record: _not_passing(record, event, passing, during)
        )
    return Sentence(text, signals, (event,), lambda record: _not_happening(record, event, during))


def _position(text: str) -> float:
    try:
        return real(text)
    except NumberError:
        raise UsageError(
            f"invalid axis position {shortened(text)}: expected a number, e.g. 1000 in 'table.X passes 1000'"
        ) from None


def _not_passing(record: Recording, event: str, passing: tuple[str, float, int], during: Condition | None) -> Finding:
    """Return the result of "never AXIS passes POSITION"; its robustness is the distance that remained."""
    name, position, way = passing
    series, times = record.series(name), record.times(event)
    where = during.truth(record) if during else series.map(np.ones_like)
    bad = times[where.at(times) > 0] if len(times) else times
    beyond = combined(lambda at, there: np.where(there > 0, at - position, np.nan), series, where)
    if not len(bad):
        side = beyond.values * way if way else np.abs(beyond.values)
        distances = np.where(side < 0, -side, np.inf) if way else side
        return _verdict(True, minimum(distances[~np.isnan(beyond.values)]), None)
    at_ns = int(bad[0])
    direction = 1 if series.at(np.array([at_ns - 1]))[0] < position else -1
    after = beyond.values[beyond.times >= at_ns] * direction
    return _verdict(False, -max(0.0, float(np.nanmax(after, initial=0.0))), at_ns)


def _not_happening(record: Recording, event: str, during: Condition | None) -> Finding:
    """Return the result of "never EVENT while CONDITION"; its robustness is the time between them in s."""
    times = record.times(event)
    if during is None:
        return _verdict(not len(times), -np.inf if len(times) else np.inf, int(times[0]) if len(times) else None)
    where = during.truth(record)
    bad = times[where.at(times) > 0] if len(times) else times
    edges = where.times[1:][np.diff(where.values) != 0]
    distances = np.abs(np.subtract.outer(bad if len(bad) else times, edges)) / S
    if len(bad):
        depth = float(np.max(distances.min(axis=1), initial=0.0)) if len(edges) else np.inf
        return _verdict(False, -depth, int(bad[0]))
    return _verdict(True, minimum(distances), None)


def _eventually(text: str, parts: Mapping[str, str]) -> Sentence:
    what = condition(parts["what"])
    within_ns = _ns(parts["within"])

    def answer(record: Recording) -> Finding:
        end_ns = record.end_ns if within_ns is None else within_ns
        truth = what.truth(record).within(0, end_ns).any()
        return _verdict(bool(truth), what.robustness(record).within(0, end_ns).max(), min(end_ns, record.end_ns))

    return Sentence(text, what.signals, (), answer)


def _after(text: str, parts: Mapping[str, str]) -> Sentence:
    what, event, span_ns = condition(parts["what"]), _event(parts["event"]), _ns(parts["span"])
    assert span_ns is not None, "the form has a time"
    stays = parts["kind"] == "for"

    def answer(record: Recording) -> Finding:
        times = record.times(event)
        if not len(times):
            return Finding(reason=f"no event '{event}'")
        truth, margin = what.truth(record), what.robustness(record)
        holds, margins, at_ns = True, [], None
        for time_ns in map(int, times):
            end_ns = time_ns + span_ns
            inside, values = truth.within(time_ns, end_ns), margin.within(time_ns, end_ns)
            good = inside.all() if stays else inside.any()
            margins.append(values.min() if stays else values.max())
            if holds and not good:
                holds, at_ns = False, _first_false(truth, time_ns) if stays else min(end_ns, record.end_ns)
        return _verdict(holds, minimum(margins), at_ns)

    return Sentence(text, what.signals, (event,), answer)


def _first_false(truth: Series, since_ns: int) -> int:
    later = truth.times[(truth.values == 0) & (truth.times >= since_ns)]
    return since_ns if not truth.at(np.array([since_ns]))[0] else int(later[0])


def _until(text: str, parts: Mapping[str, str]) -> Sentence:
    first, second, within_ns = condition(parts["what"]), condition(parts["then"]), _ns(parts["within"])

    def answer(record: Recording) -> Finding:
        end_ns = record.end_ns if within_ns is None else min(within_ns, record.end_ns)
        truth = _until_value(first.truth(record), second.truth(record), end_ns)
        margin = _until_value(first.robustness(record), second.robustness(record), end_ns)
        stays = first.truth(record)
        failing = stays.times[(stays.values == 0) & (stays.times <= end_ns)]
        return _verdict(truth > 0, margin, int(failing[0]) if len(failing) else end_ns)

    return Sentence(text, (*first.signals, *second.signals), (), answer)


def _until_value(first: Series, second: Series, end_ns: int) -> float:
    """Evaluate the requirement "FIRST until SECOND" for the signals of a simulation run.

    If the two signals are truth values, the result is 1 or 0.  If the two signals are margins, the result is the margin
    by which the claim holds: the maximum over time of min(`second`, earlier `first`).
    """
    both = combined(lambda a, b: np.stack((a, b), axis=1).astype(float), first, second)
    values = both.values[both.times <= end_ns]
    smallest_earlier = np.concatenate(([np.inf], np.minimum.accumulate(values[:-1, 0])))
    return float(np.max(np.minimum(values[:, 1], smallest_earlier)))


def _ns(seconds: str) -> int | None:
    if not seconds:
        return None
    try:
        value = real(seconds)
    except NumberError:
        raise UsageError(f"invalid time {shortened(seconds)}: expected seconds, e.g. within 2 s") from None
    if value < 0:
        raise UsageError(f"negative time {seconds} s: expected 0 s or more, e.g. 'within 2 s'")
    return to_ns(value)


def _bounded(text: str, parts: Mapping[str, str]) -> Sentence:
    inner = measure(parts["measure"])
    truth, margin = comparison(parts["sign"], parts["number"])

    def answer(record: Recording) -> Finding:
        found = inner.answer(record)
        if found.value is None:
            return Finding(reason=found.reason)
        values = np.array(found.value if isinstance(found.value, list) else [found.value])
        return _verdict(bool(truth(values).all()), minimum(margin(values)), record.end_ns)

    return Sentence(text, inner.signals, inner.events, answer, inner.axes)


_SECONDS = r"(?P<{}>[\d.eE+-]+) s"
_WITHIN = rf"(?: within {_SECONDS.format('within')})?"

MEASURES = (
    Form("final SIGNAL", r"final (?P<signal>.+)", "the value at the end of the run", "final table.X.position", _final),
    Form(
        "max|min|mean|rms|integral SIGNAL [while CONDITION]",
        r"(?P<what>max|min|mean|rms|integral) (?P<signal>.+?)(?: while (?P<during>.+))?",
        "an exact statistic over time; the unit of an integral is that of the signal times seconds",
        "max |knife.shaft.following_error| while knife.D high", _statistic,
    ),
    Form(
        "from EVENT to EVENT [first|last|each]",
        r"from (?P<events>.+?)(?: (?P<which>first|last|each))?",
        "seconds from the first event to the next occurrence of the second event; of the first pair, the last, or each",
        "from table.output1 rises to table.output1 falls", _from_to,
    ),
    Form("count EVENT", r"count (?P<event>.+)", "the number of events", "count knife raises Be", _count),
    Form(
        "energy AXIS", r"energy (?P<axis>[^ ]+)",
        "the energy in J that the windings of a servo motor with a data sheet take from the supply",
        "energy knife.shaft", _energy,
    ),
)  # fmt: skip
"""Forms of measures."""
CLAIMS = (
    Form(
        "never EVENT [while CONDITION]",
        r"never (?P<what>\S+ (?:" + "|".join(VERBS) + r")(?: .*?)??)(?: while (?P<during>.+))?",
        "the event does not occur; robustness of `passes`: the least distance, or minus the distance moved beyond",
        "never table.X passes 12000 while table.output1 high", _never,
    ),
    Form(
        "never CONDITION [while CONDITION]", r"never (?P<what>.+?)(?: while (?P<during>.+))?",
        "the condition is false at all times", "never table.X.position > 24000", _never,
    ),
    Form(
        "always within SECONDS s after EVENT: CONDITION",
        rf"always (?P<kind>within) {_SECONDS.format('span')} after (?P<event>.+?): (?P<what>.+)",
        "the condition becomes true within this time after each event",
        "always within 2 s after knife.D rises: knife.shaft.velocity = 0", _after,
    ),
    Form(
        "always for SECONDS s after EVENT: CONDITION",
        rf"always (?P<kind>for) {_SECONDS.format('span')} after (?P<event>.+?): (?P<what>.+)",
        "the condition stays true for this time after each event",
        "always for 0.5 s after table.output1 rises: table.X.velocity = 0", _after,
    ),
    Form(
        "always CONDITION [while CONDITION]", r"always (?P<what>.+?)(?: while (?P<during>.+))?",
        "the condition is true at all times", "always |knife.shaft.following_error| < 200", _always,
    ),
    Form(
        "eventually CONDITION [within SECONDS s]", rf"eventually (?P<what>.+?){_WITHIN}",
        "the condition is true at some time", "eventually table.output1 high within 3 s", _eventually,
    ),
    Form(
        "CONDITION until CONDITION [within SECONDS s]", rf"(?P<what>.+?) until (?P<then>.+?){_WITHIN}",
        "the first condition is true until the second condition is true",
        "table.X.velocity <= 4000 until table.output1 high", _until,
    ),
    Form(
        "MEASURE < NUMBER (or <= > >= = !=)",
        r"(?P<measure>(?:final|max|min|mean|rms|integral|from|count|energy) .+?)"
        r" ?(?P<sign><=|>=|!=|<|>|=) ?(?P<number>[\d.eE+-]+)",
        "the measure is within a limit", "from table.output1 rises to table.output1 falls < 1.5", _bounded,
    ),
)  # fmt: skip
"""Forms of claims; the parser tries them in this order."""
