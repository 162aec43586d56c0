"""Properties that every controller must keep, as parameters of a test.

from axistwin.testing import device_checks

@pytest.mark.parametrize("check", device_checks("stage"))
def test_stage(check):
    check()
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

from axistwin.bench import Bench, Controller
from axistwin.bench.hosts import host_of
from axistwin.bench.models import Model, product
from axistwin.bench.talk.conversation import load_text, parse
from axistwin.bench.talk.player import play
from axistwin.bench.talk.recorder import recording_to
from axistwin.controllers.commandset import Command
from axistwin.controllers.product import Product
from axistwin.core.units import MS, S, to_ns
from axistwin.testing.traffic import DIALECTS, Burst, Traffic, dialect_of, lowest
from axistwin.testing.watching import calls, code_of, no_errors, no_hang, size_of

SEED = 1
AWAKE_NS = 3 * S  # Time after power-on until any controller listens.
REST_NS = 2 * S
BUS_NS = 2 * MS  # Time for a command on a bus.
BURSTS = 120
ROUNDS = 7
MOST_GROWTH = 8  # Bytes per burst: less is no list that grows by each command.
CUTS = 6
TIMES = {"fuzz": 3, "repeated": 3}  # Number of different seeds in one check.
REMEDY = (
    "let the device depend on its input and self.now alone, without time.time(), random and attributes of its class "
    "that change"
)
WORDS = {
    "fuzz": "nothing that a host sends ends in an error, never ends, or makes the device grow",
    "repeated": "the same bytes and pulses whole, in pieces, paced and replayed",
    "power": "the power can fail and return at any moment",
    "distance": "the pulses made are the distance commanded, and the position reported is that of the machine",
    "apart": "two devices share no state",
    "reachable": "each command of the table can be reached",
}  # fmt: skip


def device_checks(model: Model, *, seed: int = SEED) -> list[Any]:
    """Return pytest parameters: functions without arguments, which raise AssertionError with what to do.

    `model`: a name, a class of `axistwin.devices` or a Product.  `seed`: that of all random input; the same seed sends
    the same.  Raises UsageError for an unknown model.
    """
    import pytest  # only tests need it

    made = product(model)
    return [pytest.param(Check(name, made, seed), id=name) for name in WORDS]


@dataclass(frozen=True)
class Check:
    """One property of a model, to be called by a test."""

    name: str
    product: Product
    seed: int

    def __call__(self) -> None:
        """Raises AssertionError if the model does not keep the property."""
        try:
            with no_errors():
                for seed in range(self.seed, self.seed + TIMES.get(self.name, 1)):
                    _CHECKS[self.name](Subject(self.product, seed))
        except Exception as error:
            error.add_note(
                f"{self.name}: {WORDS[self.name]}; to repeat: device_checks({self.product.model!r}, seed={self.seed})"
            )
            raise

    def __repr__(self) -> str:
        return f"<{self.name} of {self.product.model}>"


def demand(good: bool, words: str) -> None:
    """Raise AssertionError unless `good`; pytest would rewrite the words of an `assert`."""
    if not good:
        raise AssertionError(words)


class Subject:
    """A model that is examined: new benches with it, and traffic for it."""

    def __init__(self, made: Product, seed: int) -> None:
        self.product, self.seed = made, seed
        self.model, self.dialect = made.model, dialect_of(made)

    def random(self, more: int = 0) -> Random:
        return Random(self.seed + more)  # noqa: S311  # traffic from a seed, no secrets

    def traffic(self, count: int = BURSTS, *, wild: bool = False, more: int = 0) -> list[Burst]:
        return Traffic(self.product, self.random(more)).bursts(count, wild=wild)

    def script(self, bursts: Sequence[Burst], begin_ns: int, *, opening: bool = True) -> list[tuple[int, bytes]]:
        """Return when the host sends each burst: after the one before, and its pause.  The last is the end."""
        line, at_ns, listed = self.product.line, begin_ns, []
        for burst in [*(self.dialect.opening if opening else ()), *bursts]:
            listed.append((at_ns, burst.data))
            at_ns += to_ns(burst.then) + (BUS_NS if line is None else len(burst.data) * line.frame_ns)
        return [*listed, (at_ns + REST_NS, b"")]

    @contextmanager
    def switched_on(self, bench: Bench | None = None, **options: Any) -> Iterator["Talk"]:
        bench = bench or Bench()
        bench.clock.patient = False
        controller = bench.add(self.product, **options)
        with no_hang(bench):
            yield Talk(controller, bench)


Script = Sequence[tuple[int, bytes]]


class Talk:
    """A host at a controller, and what it has received."""

    def __init__(self, controller: Controller, bench: Bench) -> None:
        self.controller, self.bench = controller, bench
        self.heard: list[tuple[int, bytes]] = []
        if controller.product.attend:
            controller.bus.subscribe_received(lambda data: self.heard.append((bench.now, data)))
        else:
            controller.serial.subscribe_received(lambda byte, _: self.heard.append((bench.now, bytes([byte]))))

    def say(self, script: Script, run_to: Callable[[int], object] | None = None, *, in_pieces: bool = False) -> None:
        with host_of(self.controller) as host, ExitStack() as stack:
            # On a bus a message is fetched only by a host that reads.
            stack.callback(host.subscribe_received(lambda data: None))
            for at_ns, data in script:
                (run_to or self.bench.clock.run_to)(at_ns)
                for piece in [bytes([byte]) for byte in data] if in_pieces else [data] if data else []:
                    # Each byte is sent just before the line is free for it, so that there is no gap.
                    self.bench.run_until(lambda: not in_pieces or host.pending <= 1, 1.0)
                    host.write(piece)

    def paced(self, rng: Random, end_ns: int) -> None:
        """Advance in the uneven steps of a wall clock."""
        while self.bench.now < end_ns:
            self.bench.clock.run_to(min(end_ns, self.bench.now + rng.randint(1, 20 * MS)))

    def outcome(self) -> dict[str, Any]:
        """Return all bytes with their times in ns, and the pulses and the position of each axis."""
        found: dict[str, Any] = {"bytes": self.heard}
        for name, axis in self.controller.axes.items():
            found |= {f"pulses of {name}": axis.pulse_times().tolist(), f"position of {name}": axis.position}
        return found


def _fuzz(subject: Subject) -> None:
    with subject.switched_on(history=2) as talk:
        bursts, sizes = subject.traffic(wild=True), []
        for number in range(ROUNDS):
            begin_ns = talk.bench.now if number else AWAKE_NS
            talk.say(subject.script(bursts, begin_ns, opening=not number))
            talk.heard.clear()
            if not subject.product.attend:
                talk.controller.serial.read()  # A host reads what it is answered.
            sizes.append(size_of(talk.controller, talk.bench))
        last = sizes[-4:]
        grown = last[-1] - last[0]
        demand(
            sorted(set(last)) != last or grown <= 3 * BURSTS * MOST_GROWTH,
            f"{subject.model} grows by {grown // 3:,} bytes each time the same {BURSTS} requests are sent: "
            "limit what it collects, e.g. del self.errors[:-10]",
        )


def _repeated(subject: Subject) -> None:
    script = subject.script(subject.traffic(), AWAKE_NS)
    with TemporaryDirectory() as directory:
        file = Path(directory) / "whole.talk"
        with subject.switched_on() as talk, recording_to(talk.bench, file, {}):
            talk.say(script)
            whole = talk.outcome()
        with subject.switched_on() as talk:
            difference = play(parse(load_text(file), file.name, model=subject.model), talk.bench)
            talk.bench.clock.run_to(script[-1][0])
            again = talk.outcome()
    demand(difference is None, f"{subject.model} replayed: {REMEDY}\n{difference}")
    _same(subject, "replayed", whole, again)
    with subject.switched_on() as talk:
        on_a_bus = subject.product.attend is not None
        talk.say(script, in_pieces=not on_a_bus)
        _same(subject, "in pieces", whole, talk.outcome())
    with subject.switched_on() as talk:
        talk.say(script, partial(talk.paced, subject.random()))
        _same(subject, "paced", whole, talk.outcome())


def _same(subject: Subject, how: str, first: dict[str, Any], second: dict[str, Any]) -> None:
    for what, expected in first.items():
        got = second[what]
        if expected == got:
            continue
        if isinstance(expected, list):
            pairs = enumerate(zip(expected, got, strict=False))
            place = next((i for i, (one, two) in pairs if one != two), min(len(expected), len(got)))
            expected, got = expected[place : place + 3], got[place : place + 3]
        raise AssertionError(f"{subject.model} {how}: the {what} differ, {expected} at first and now {got}: {REMEDY}")


def _power(subject: Subject) -> None:
    rng, bursts = subject.random(), subject.traffic()
    script = subject.script(bursts, AWAKE_NS)
    with subject.switched_on() as talk:
        talk.say(script)
        answers = bool(talk.heard)
    for _ in range(CUTS):
        cut_ns = rng.randint(0, script[-1][0])
        when = f"after the power has failed at {cut_ns / S:.9f} s"
        with subject.switched_on() as talk:
            talk.say([entry for entry in script if entry[0] <= cut_ns])
            talk.bench.clock.run_to(cut_ns)
            talk.controller.power(False)
            _is_dead(subject, talk, when)
            talk.heard.clear()
            talk.controller.power(True)
            talk.say(subject.script(bursts, talk.bench.now + AWAKE_NS))
            demand(
                bool(talk.heard) or not answers,
                f"{subject.model} answers no request {when} and has returned: set all its state in start(), which runs "
                "at each power-on",
            )


def _is_dead(subject: Subject, talk: Talk, when: str) -> None:
    talk.bench.run(0.05)  # What was on the wire has arrived.
    heard, begin_ns = len(talk.heard), talk.bench.now
    talk.bench.run(20.0)
    sent = talk.heard[heard:]
    demand(not sent, f"{subject.model} sends {sent[:1]} {when}: wait by `yield self.after()`, not on the clock itself")
    for name, axis in talk.controller.axes.items():
        coasts = not hasattr(axis, "train")  # A servo motor.
        still = coasts or not len(axis.pulse_times(begin_ns))
        demand(still, f"{subject.model} moves axis {name} {when}: move it by its Positioner only")


def _apart(subject: Subject) -> None:
    kind = getattr(Bench().add(subject.product)._device, "kind", None)
    kept, script = _class_state(kind), subject.script(subject.traffic(), AWAKE_NS)
    with subject.switched_on() as talk:
        talk.say(script)
        alone = talk.outcome()
    if changed := [name for name, value in _class_state(kind).items() if kept.get(name, kept) != value]:
        raise AssertionError(
            f"{subject.model} has changed the attribute {changed[0]!r} of its class, which all its devices share: "
            f"assign it in start(), e.g. self.{changed[0]} = ..."
        )
    bench = Bench()
    with subject.switched_on(bench, name="one") as ours, subject.switched_on(bench, name="two") as other:
        more = subject.script(subject.traffic(more=1), AWAKE_NS)
        with host_of(other.controller) as host:
            host.subscribe_received(lambda data: None)
            for at_ns, data in more:
                bench.clock.call_last(at_ns, partial(host.write, data))
            ours.say(script)
        _same(subject, "beside another of its kind", alone, ours.outcome())


def _class_state(kind: type | None) -> dict[str, str]:
    plain = (int, float, str, bytes, list, dict, set, bytearray, type(None))
    bases = reversed(kind.__mro__[:-1]) if kind else ()
    return {
        name: repr(value)
        for base in bases
        for name, value in vars(base).items()
        if isinstance(value, plain) and not name.startswith("__")
    }


def _reachable(subject: Subject) -> None:
    if not (subject.product.phrase or subject.product.family in DIALECTS):
        raise AssertionError(f"{subject.model} does not say how its commands are written: give its Product a `phrase`")
    missed = [command for command in subject.product.commands if command.implemented and not _reached(subject, command)]
    where = [f"{getattr(one, 'place', subject.model)}: {one.syntax!r}" for one in missed]
    demand(not missed, f"{'; '.join(where)}: never reached: change the pattern, or one before it that takes its lines")


def _reached(subject: Subject, command: Command) -> bool:
    code = code_of(command.handler)
    phrases = [Burst(data, 1.0) for data in subject.dialect.phrases(command, partial(lowest, subject.product))]
    if code is None or not phrases:
        return True
    subject.dialect.forget()
    with subject.switched_on() as talk:
        *before, end = subject.script([], AWAKE_NS)
        talk.say(before)
        with calls({code}) as called:
            talk.say(subject.script(phrases, end[0], opening=False))
        return code in called


def _distance(subject: Subject) -> None:
    kind = subject.product.driver
    if subject.product.axes and kind is not None and kind.driver is None:
        import pytest  # only tests need it

        pytest.skip(f"{subject.model} does not say how a host moves it: give its class a driver, e.g. TextDriver(...)")
    from axistwin.testing.distances import check_distances  # The drivers' modules load slowly.

    if subject.product.axes:
        check_distances(subject.product, subject.random())


_CHECKS: dict[str, Callable[[Subject], None]] = {
    "fuzz": _fuzz, "repeated": _repeated, "power": _power, "distance": _distance, "apart": _apart,
    "reachable": _reachable,
}  # fmt: skip
