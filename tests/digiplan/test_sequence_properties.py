"""Random sequences against a plain Python expansion by the manual's text."""

from dataclasses import dataclass, field

from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .talking import moves, number, positions, ready, send, status, until_idle, write

MOST_STEPS_DONE = 150


# Random legal sequences


@dataclass(frozen=True)
class Move:
    """An index, optionally with output switching or a pulse at its end."""

    directions: dict[str, int]
    distance: int | None
    speed: int | None
    backlash: bool
    set_outputs: frozenset[int]
    reset_outputs: frozenset[int]
    pulse: int | None

    def __str__(self) -> str:
        text = "".join(axis + ("-" if sign < 0 else "") for axis, sign in self.directions.items())
        text += "" if self.distance is None else str(self.distance)
        text += "" if self.speed is None else f"@{self.speed}"
        text += "B" if self.backlash else ""
        if self.pulse is not None:
            return f"{text}P{self.pulse},1"
        for letter, outputs in (("S", self.set_outputs), ("R", self.reset_outputs)):
            if outputs:
                text += letter + "".join(map(str, sorted(outputs)))
        return text


@dataclass(frozen=True)
class StoreBacklash:
    signed: int

    def __str__(self) -> str:
        return f"B{self.signed:+d}"


@dataclass(frozen=True)
class Repeat:
    times: int
    step: int

    def __str__(self) -> str:
        return f"={self.times},{self.step}"


@dataclass
class Expansion:
    """An expansion of a sequence, step by step, by the text of the manual, without a clock or a ramp."""

    distance: int = 0
    backlash: int = 0
    outputs: set[int] = field(default_factory=set)
    moves: dict[str, list[int]] = field(default_factory=lambda: {"X": [], "Y": [], "Z": []})
    done: int = 0

    def run(self, steps: list) -> bool:
        """Expand a sequence; return False if it takes too many steps to be tried."""
        left: dict[int, int] = {}
        at = 1
        while at <= len(steps):
            self.done += 1
            if self.done > MOST_STEPS_DONE:
                return False
            step = steps[at - 1]
            if isinstance(step, Repeat):
                left.setdefault(at, step.times)
                if left[at]:
                    left[at] -= 1
                    at = step.step
                    continue
                del left[at]  # it begins again when it is reached again
            elif isinstance(step, StoreBacklash):
                self.backlash = step.signed
            else:
                self.move(step)
            at += 1
        return True

    def move(self, step: Move) -> None:
        if step.distance is not None:
            self.distance = step.distance
        for axis, sign in step.directions.items():
            forth = sign * self.distance
            if step.backlash and self.distance and self.backlash * sign < 0:
                self.moves[axis] += [forth - self.backlash, self.backlash]
            elif self.distance:
                self.moves[axis].append(forth)
        self.outputs |= step.set_outputs
        self.outputs -= step.reset_outputs


@st.composite
def random_moves(draw) -> Move:
    axes = draw(st.lists(st.sampled_from("XYZ"), max_size=3, unique=True))
    backlash = bool(axes) and draw(st.booleans())
    sign = st.sampled_from((1, -1))
    one = draw(sign)
    pulse = draw(st.none() | st.integers(0, 5))
    switched = st.frozensets(st.integers(1, 5), max_size=3) if pulse is None else st.just(frozenset())
    move = Move(
        {axis: one if backlash else draw(sign) for axis in sorted(axes)},
        draw(st.none() | st.integers(1, 60)) if axes else None,
        draw(st.none() | st.sampled_from((200, 400, 1000, 5000))) if axes else None,
        backlash,
        draw(switched),
        draw(switched),
        pulse,
    )
    assume(str(move))
    return move


@st.composite
def sequences(draw) -> list:
    steps: list = []
    for n in range(1, draw(st.integers(1, 9)) + 1):
        kinds = [random_moves(), random_moves(), st.builds(StoreBacklash, st.integers(-40, 40))]
        if n > 1:
            kinds.append(st.builds(Repeat, st.integers(1, 3), st.integers(1, n - 1)))
        steps.append(draw(st.one_of(kinds)))
    return steps


@given(steps=sequences())
@settings(max_examples=60, suppress_health_check=list(HealthCheck))
def test_any_legal_sequence_does_what_its_steps_say(steps):
    """Programming a sequence, repeating, backlash: all moves and all outputs agree with the plain expansion."""
    expected = Expansion()
    assume(expected.run(steps))
    bench = Bench()
    if1 = ready(bench)
    send(bench, if1, ":" + ":".join(map(str, steps)) + ":$", seconds=0.3 + expected.done * 0.65)
    for _ in range(2):
        until_idle(bench, if1, 400)
        assert (status(bench, if1, "E"), number(bench, if1, "F")) == ("C", 0)
        assert {name: moves(if1.axes[name]) for name in "XYZ"} == expected.moves
        assert positions(if1) == tuple(sum(expected.moves[name]) for name in "XYZ")
        assert {n for n in range(1, 6) if if1.pins[f"output{n}"].level} == expected.outputs
        expected.done = 0
        expected.run(steps)
        write(if1, ":$")
