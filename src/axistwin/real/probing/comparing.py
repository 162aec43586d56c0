"""Compare a controller with a twin, case by case."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from enum import StrEnum
from typing import Any, Literal, get_args, get_origin, get_type_hints

from axistwin.bench import Bench, product
from axistwin.controllers.product import Product
from axistwin.core.errors import AxistwinError, LinkError
from axistwin.real.hosts.end import LATE_S, QUIET_S, TRIES, Answer, End
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.cases import Case, Condition, Dialect, dialect
from axistwin.sim.frames import UartFormat

POWER_UP_S = 2.0
EXCHANGES = 3
ATTEMPTS, EXACT_ATTEMPTS = 20, 4
"""Number of tries of a case without motion; an answer that is late in each try counts as a difference.

A busy computer delays many answers, but not the same one twenty times.
"""
CONFIRMED = 2  # Number of tries in which the bytes of a case without motion must differ.
CONTROLS, MOST_LATE = 20, 5  # Requests after a case that was always late; so many late ones do not blame the port.
REAL_TIME = 0.05  # Largest deviation, in seconds, of the first answers on a port that keeps real time.
BUSY = "the computer or the port was too slow: repeat the probe while the computer does nothing else"


class Motion(StrEnum):
    """Motion that is permitted while a real controller is tested: none, or small moves."""

    NONE = "none"
    SMALL = "small"


class Verdict(StrEnum):
    """Result of the comparison of two answers."""

    SAME = "same"
    DIFFERS = "differs"
    INCONCLUSIVE = "inconclusive"


@dataclass(frozen=True)
class Result:
    """Result of one case."""

    case: Case
    verdict: Verdict
    reason: str = ""
    expected: tuple[Answer, ...] = ()
    received: tuple[Answer, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        return {
            "name": self.case.name, "section": self.case.section, "moves": self.case.moves, "writes": self.case.writes,
            "verdict": str(self.verdict), "reason": self.reason, "sent": [said.hex(" ") for said in self.case.says],
            "expected": [answer.data.hex(" ") for answer in self.expected],
            "received": [answer.data.hex(" ") for answer in self.received],
            "expected_s": [round(answer.seconds, 6) for answer in self.expected],
            "received_s": [round(answer.seconds, 6) for answer in self.received],
        }  # fmt: skip


@dataclass
class Probe:
    """Results of a probe, which compares a controller with its twin."""

    model: str
    condition: Condition
    results: list[Result] = field(default_factory=list)
    times_judged: bool = False
    fits: list[str] = field(default_factory=list)  # Options that remove differences, such as `busy="ignore"`.
    not_restored: str = ""  # What could not be restored in nonvolatile memory, and the remedy; "" if all is as before.

    def of(self, verdict: Verdict) -> list[Result]:
        return [result for result in self.results if result.verdict is verdict]

    def as_dict(self) -> dict[str, Any]:
        sections = {
            section: sum(result.verdict is Verdict.SAME for result in self.results if result.case.section == section)
            for section in dict.fromkeys(result.case.section for result in self.results)
        }
        return {
            "model": self.model, "facts": asdict(self.condition)["facts"], "times_judged": self.times_judged,
            "counts": {str(verdict): len(self.of(verdict)) for verdict in Verdict}, "fits": self.fits,
            "not_restored": self.not_restored, "seen_on_real_hardware": sections,
            "results": [result.as_dict() for result in self.results],
        }  # fmt: skip


@dataclass(frozen=True)
class Settings:
    """Settings of a probe."""

    motion: Motion = Motion.NONE
    as_new: bool = False  # True if just switched on, without a machine: all values are then compared.
    line: UartFormat | None = None
    find_options: bool = True  # True if the probe shall also find options of the twin that remove differences.
    report: Callable[[int, int], None] = lambda done, total: None  # Finished cases, of all.
    memory: bool = False  # True if the probe may write programs and the data EEPROM; it restores both.
    plug: bool = False  # True if a test plug connects outputs of the controller to its inputs.
    first_difference: bool = False  # True if the probe shall end at the first difference.


def probe(model: str, end: End, settings: Settings | None = None, twin: "Twin | None" = None) -> Probe:
    """Compare a real controller with its virtual twin.

    `end`: connection to the real controller.  `twin`: a twin that has already answered all cases.  Raises LinkError if
    the controller does not answer or is moving.
    """
    settings = settings or Settings()
    made = product(model)
    family = dialect(made)
    found = Probe(made.model, family.examine(end, made))
    facts = {**found.condition.facts, "line": str(settings.line or made.line or ""), "plug": str(settings.plug)}
    every = [case for case in family.cases(made, facts) if _permitted(case, settings)]
    wanted = [case for case in every if _reason(case, found.condition, settings) is None]
    twin = twin or Twin(made, family, wanted, settings.line, {}, facts)
    port = _Port(end, twin, family)
    found.times_judged = port.tolerance is not None
    saving = any(case.stores for case in wanted)
    if saving:
        family.save(end, found.condition)
    try:
        for number, case in enumerate(every):
            reason = _reason(case, found.condition, settings)
            if reason is None:
                found.results.append(_compare(case, port, twin.answers[case], settings))
            else:
                found.results.append(Result(case, Verdict.INCONCLUSIVE, reason))
            settings.report(number + 1, len(every))
            if settings.first_difference and found.results[-1].verdict is Verdict.DIFFERS:
                break
    finally:
        if saving:
            found.not_restored = family.restore(end, found.condition)
    if settings.find_options and found.of(Verdict.DIFFERS):
        found.fits = _fits(made, family, wanted, found, settings, port.tolerance, facts)
    return found


def _permitted(case: Case, settings: Settings) -> bool:
    moves = settings.motion is not Motion.NONE
    permitted = (moves or not case.moves) and (settings.memory or not case.stores)
    return permitted and (settings.as_new or not case.bare) and (settings.plug or not case.plug)


def _reason(case: Case, condition: Condition, settings: Settings) -> str | None:
    reasons = [condition.no_writes if case.writes else "", condition.no_motion if case.moves else "",
               condition.no_memory if case.stores else ""]  # fmt: skip
    if not settings.as_new and (case.moves or case.stores):
        reasons.append(condition.machine)
    return next(filter(None, reasons), None)


class Twin:
    """A virtual controller that answers the test cases of a comparison with a real controller."""

    def __init__(
        self, made: Product, family: Dialect, cases: Sequence[Case], line: UartFormat | None,
        options: Mapping[str, Any], facts: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        bench = Bench()
        keywords: dict[str, Any] = {} if line is None else {"line": line}
        controller = bench.add(made.model, **keywords, **options)
        family.equip(controller, facts or {})
        self.end = VirtualEnd(bench, controller)
        bench.run(POWER_UP_S)
        family.initialise(self.end, facts or {})
        family.examine(self.end, made)
        self.request = family.first(facts or {})  # Request that is answered in every state.
        self.first = [self.end.ask(self.request) for _ in range(EXCHANGES)][-1]
        self._patience_s = family.patience_s
        self.answers = {case: self.answer(case) for case in cases}

    def answer(self, case: Case) -> tuple[Answer, ...]:
        return tuple(
            self.end.ask(said, 0, case.wait(number, case.wait_s if case.moves else self._patience_s))
            for number, said in enumerate(case.says)
        )


class _Port:
    """The connection to the controller, whose answers can arrive late."""

    def __init__(self, end: End, twin: Twin, family: Dialect) -> None:
        self.end, self.twin, self.family = end, twin, family
        first = twin.first
        late = [abs(end.ask(twin.request, len(first.data)).seconds - first.seconds) for _ in range(EXCHANGES)]
        self._usual_s = min(late)
        self.tolerance: float | None = max(3 * max(late), end.grain_s)  # Of answer times; None if the port is too slow.
        self.is_out_of_step = False  # After a disturbed motion the twin may be in another state.
        if end.exact:
            self.tolerance = end.grain_s
            return
        if max(late) > REAL_TIME:
            self.tolerance = None
        end.settle()

    def ask(self, case: Case, expected: Sequence[Answer]) -> tuple[Answer, ...]:
        self.end.begin()
        return tuple(
            self.end.ask(said, len(answer.data), case.wait(number, case.wait_s), self.family.patience_s)
            for number, (said, answer) in enumerate(zip(case.says, expected, strict=True))
        )

    def late(self, case: Case, expected: Sequence[Answer], received: Sequence[Answer]) -> tuple[bool, bool]:
        """Wait for all answers; return if any has come after the next request, and if they are as expected else."""
        wanted, got = (
            b"".join(answer.data for said, answer in zip(case.says, answers, strict=True) if said)
            for answers in (expected, received)
        )
        everything = self._settled(case, wanted)
        short = any(len(now.data) < len(before.data) for before, now in zip(expected, received, strict=True))
        moved = len(everything) > len(got) or (short and len(everything) >= len(wanted))
        bits = all(now == before for said, before, now in zip(case.says, expected, received, strict=True) if not said)
        return moved, moved and bits and everything == wanted

    def _settled(self, case: Case, wanted: bytes) -> bytes:
        """Return what has been received since the beginning of a case, up to the answer to one more request.

        `wanted`: what the case should have received.  Raises LinkError if the controller no longer answers.
        """
        end, first = self.end, self.twin.first.data
        form = self.family.answer_form(self.twin.request, first)
        for _ in range(TRIES):
            end.send(self.twin.request)
            last = end.now
            while end.now - last < LATE_S:
                if more := end.receive():
                    end.received += more
                    last = end.now
                elif end.received == wanted + first and end.now - last > QUIET_S:
                    break
            everything, answer = bytes(end.received[: -len(first)]), bytes(end.received[-len(first) :])
            if self.family.answer_form(self.twin.request, answer) == form:
                return everything
        raise LinkError(
            f"the controller no longer answers after the case {case.name!r}: "
            "check its power and the cable, switch it off and on, then run axistwin probe again"
        )

    def slow(self) -> bool:
        """True if the port now delays answers whose times are known."""
        first, late = self.twin.first, 0
        for _ in range(CONTROLS):
            answer = self.end.ask(self.twin.request, len(first.data))
            off = abs(answer.seconds - first.seconds) > (self.tolerance or REAL_TIME)
            late += off or len(answer.data) != len(first.data)
        return late > MOST_LATE

    def disturbed(self, expected: Sequence[Answer], received: Sequence[Answer]) -> bool:
        """True if this program has sent requests too late, or waited too long for answers with the right bytes."""
        late_s = self.end.late_s + sum(
            max(0.0, now.seconds - before.seconds - self._usual_s)
            for before, now in zip(expected, received, strict=True)
            if before.data == now.data
        )
        return late_s > self.end.grain_s


def _compare(case: Case, port: _Port, expected: tuple[Answer, ...], settings: Settings) -> Result:
    """Perform a case, again if its answers differ or are late, and return the verdict.

    A case that moves the motor or stores data is performed only once.
    """
    exact, tolerance, tries = port.end.exact, port.tolerance, ATTEMPTS
    if once := case.moves or case.stores:
        # A single measurement of an answer time is too inaccurate for a comparison.
        tries, tolerance = 1, tolerance if exact else None
    best: tuple[Answer, ...] = ()
    others, late = 0, False
    verdict, reason, received = Verdict.SAME, "", expected
    for _ in range(min(tries, EXACT_ATTEMPTS) if exact else tries):
        received = port.ask(case, expected)
        if same := _same_bytes(expected, received):
            received = best = _nearest(expected, best or received, received)
        verdict, reason = _judge(case, expected, received, port.family, settings, tolerance)
        if verdict is not Verdict.DIFFERS or (exact and not same):
            return Result(case, verdict, reason, expected, received)
        if same:
            continue
        late, as_expected = port.late(case, expected, received)
        if once and as_expected:
            return Result(case, Verdict.SAME, "", expected, received)
        others += not late
        if others == CONFIRMED:
            break
    if exact:
        return Result(case, verdict, reason, expected, received)
    if once:
        port.is_out_of_step |= late or port.disturbed(expected, received)
    if port.is_out_of_step if once else others < CONFIRMED and port.slow():
        return Result(case, Verdict.INCONCLUSIVE, BUSY, expected, received)
    return Result(case, verdict, reason, expected, received)


def _nearest(expected: Sequence[Answer], one: Sequence[Answer], other: Sequence[Answer]) -> tuple[Answer, ...]:
    """Return of each two answers the one whose time is nearer to the expected time."""
    return tuple(
        min(pair, key=lambda answer: abs(answer.seconds - before.seconds))
        for before, *pair in zip(expected, one, other, strict=True)
    )


def _same_bytes(expected: Sequence[Answer], received: Sequence[Answer]) -> bool:
    """True if all answers have the expected bytes; only the answer times may differ."""
    return [answer.data for answer in expected] == [answer.data for answer in received]


def _judge(
    case: Case, expected: Sequence[Answer], received: Sequence[Answer], family: Dialect, settings: Settings,
    tolerance: float | None,
) -> tuple[Verdict, str]:  # fmt: skip
    depends = case.depends and not settings.as_new
    said, got = ([answer.data for answer in answers] for answers in (expected, received))
    forms = [list(map(family.answer_form, case.says, answers)) for answers in (said, got)]
    if case.form:
        said, got = forms
    if said != got:
        if depends and forms[0] == forms[1] and _steady(case, said, got):
            return Verdict.INCONCLUSIVE, "the value depends on the machine"
        if depends and _sometimes_silent(family, said, got):
            return Verdict.INCONCLUSIVE, "the answer depends on earlier settings"
        return Verdict.DIFFERS, "another answer"
    if tolerance is not None and case.timed and not case.form:
        for before, now in zip(expected, received, strict=True):
            if abs(now.seconds - before.seconds) > tolerance:
                return Verdict.DIFFERS, f"the answer takes {now.seconds:.4f} s instead of {before.seconds:.4f} s"
    return Verdict.SAME, ""


def _steady(case: Case, said: Sequence[bytes], got: Sequence[bytes]) -> bool:
    """True if the controller repeats its answer to a request wherever the twin does."""
    seen: dict[tuple[bytes, bytes], bytes] = {}
    return all(
        seen.setdefault((request, before), now) == now
        for request, before, now in zip(case.says, said, got, strict=True)
    )


def _sometimes_silent(family: Dialect, said: list[bytes], got: list[bytes]) -> bool:
    """True if only one of controller and twin has answered; False unless it reports moves or sequences."""
    if not family.definitions:
        return False
    one_sided = any(bool(one) is not bool(other) for one, other in zip(said, got, strict=True))
    return one_sided and all(not answer or answer[0] in family.definitions for answer in (*said, *got))


def _fits(
    made: Product, family: Dialect, cases: Sequence[Case], found: Probe, settings: Settings, tolerance: float | None,
    facts: Mapping[str, str],
) -> list[str]:  # fmt: skip
    """Return the option values with which the twin answers most alike.

    A twin with more differences than the best one so far is not asked further.
    """
    received = {result.case: result.received for result in found.results if result.received}
    suggested = family.candidates(
        {case.name: b"".join(answer.data for answer in answers) for case, answers in received.items()}
    )
    fitting: list[str] = []
    best = len(found.of(Verdict.DIFFERS)) - 1
    for name, value in other_values(made, suggested):
        left = 0
        try:
            twin = Twin(made, family, (), settings.line, {name: value}, facts)
            for case in cases:
                verdict, _ = _judge(case, twin.answer(case), received[case], family, settings, tolerance)
                left += verdict is Verdict.DIFFERS
                if left > best:
                    break
        except AxistwinError:
            # This option value causes an error in the virtual controller, so try the next value.
            continue
        if left > best:
            continue
        if left < best:
            best, fitting = left, []
        text = f'"{value}"' if isinstance(value, str) else str(value).lower()
        fitting.append(f"{name}={text}")
        if not left and name in suggested:
            break
    return [f"{text} ({best} differences left)" if best else text for text in sorted(fitting)]


def other_values(made: Product, suggested: Mapping[str, list[object]]) -> list[tuple[str, Any]]:
    """Return values to try for each option of the model: all choices, half and double times, suggested values."""
    hints = get_type_hints(made.options)
    default = made.options()
    found: list[tuple[str, Any]] = [(name, value) for name, values in suggested.items() for value in values]
    for option in fields(made.options):
        now, kind = getattr(default, option.name), hints[option.name]
        if get_origin(kind) is Literal:
            found += [(option.name, choice) for choice in get_args(kind) if choice != now]
        elif kind is bool:
            found.append((option.name, not now))
        elif kind is float and now:
            found += [(option.name, now * factor) for factor in (0.5, 2.0)]
    return found
