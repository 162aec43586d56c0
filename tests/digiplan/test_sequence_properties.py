"""Random sequences against a plain Python expansion by the manual's text; and random input at any time."""

from dataclasses import dataclass, field

from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .talking import moves, number, positions, ready, send, status, write

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
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
def test_any_legal_sequence_does_what_its_steps_say(steps):
    """Programming a sequence, repeating, backlash: all moves and all outputs agree with the plain expansion."""
    expected = Expansion()
    assume(expected.run(steps))
    bench = Bench()
    if1 = ready(bench)
    send(bench, if1, ":" + ":".join(map(str, steps)) + ":$", seconds=0.3 + expected.done * 0.65)
    for _ in range(200):
        if status(bench, if1, "E") != "E":
            break
        bench.run(1.0)
    assert (status(bench, if1, "E"), number(bench, if1, "F")) == ("C", 0)
    assert {name: moves(if1.axes[name]) for name in "XYZ"} == expected.moves
    assert positions(if1) == tuple(sum(expected.moves[name]) for name in "XYZ")
    assert {n for n in range(1, 6) if if1.pins[f"output{n}"].level} == expected.outputs

    again = Expansion(expected.distance, expected.backlash, expected.outputs, expected.moves)
    again.run(steps)
    write(if1, ":$")
    for _ in range(400):
        bench.run(0.5)
        if status(bench, if1, "E") != "E":
            break
    assert {name: moves(if1.axes[name]) for name in "XYZ"} == again.moves
    assert {n for n in range(1, 6) if if1.pins[f"output{n}"].level} == again.outputs


# Rubbish at any time

TALK = (
    b"@1000\r", b":S1:X40@600:P2,5:Y-40:=2,2:R1:$\r", b"E\r", b"X100/Y30$\r", b"B-20\r", b"Z50B$\r", b"#\r", b"K\r",
    b":X@500G:P0,9:A:%:Y9:$\r", b"%\r", b"H1L2X9$\r", b"[\r", b"]\r", b"N\r", b"P4,20$\r", b"X-@700G$\r", b"F\r",
)  # fmt: skip
RUBBISH = st.binary(max_size=6) | st.text("XYZG@:=,%$#[]()*<>^BHLSRPADKFIOQEN/+-0123456789 \r\n", max_size=8).map(
    lambda text: text.encode()
)
PINS = ("input1", "input2", "input3", "estop", "limit_plus", "limit_minus", "x_fault", "y_fault")


@dataclass(frozen=True)
class Act:
    """An action on a controller, and the time until the next action."""

    data: bytes = b""
    pin: str = ""
    level: bool = False
    wait_s: float = 0.0

    def on(self, bench: Bench, controller: Controller) -> None:
        if self.data:
            controller.serial.write(self.data)
        if self.pin:
            controller.pins[self.pin].drive(self.level)
        bench.run(self.wait_s)


acts = st.lists(
    st.one_of(
        st.builds(Act, data=st.sampled_from(TALK), wait_s=st.sampled_from((0.0, 0.01, 0.3))),
        st.builds(Act, data=RUBBISH, wait_s=st.sampled_from((0.0, 0.001))),
        st.builds(Act, pin=st.sampled_from(PINS), level=st.booleans(), wait_s=st.sampled_from((0.0, 0.0005, 0.1))),
    ),
    max_size=14,
)


def story(script: list[Act], model: str, form: str) -> tuple[object, ...]:
    """Perform the actions, and return everything observable from outside."""
    bench = Bench()
    controller = ready(bench, form, model)
    controller.serial.read()
    heard: list[object] = []
    controller.serial.subscribe_received(lambda byte, errors: heard.append((bench.now, byte)))
    for name, pin in controller.pins.items():
        pin.subscribe(lambda changed, name=name: heard.append((bench.now, name, changed.level)))
    for act in script:
        act.on(bench, controller)
    bench.run(3.0)
    pulses = [controller.axes[name].pulse_times().tolist() for name in "XYZ"]
    return bench, controller, heard, pulses, positions(controller)


@given(script=acts, model=st.sampled_from(("if1", "if2")), form=st.sampled_from(("U61", "U62", "V61")))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_bytes_and_levels_at_any_time_neither_raise_nor_hang_and_twice_is_the_same(script, model, form):
    """Wrong input is ignored and sets a flag; afterwards the interface still works."""
    bench, controller, *seen = story(script, model, form)
    assert seen == list(story(script, model, form)[2:])
    for name in PINS:
        controller.pins[name].release()
    end = "\n" if form[0] == "V" else "\r"
    for text in ("", form, "]", "#", "K", "K", "F", "D0"):  # the format is needed if a `(` after `[` has broken in
        write(controller, text, end=end)
        bench.run(1.2)
    bench.run(20.0)
    controller.serial.read()
    write(controller, "E", end=end)
    bench.run(0.2)
    assert b"C" in controller.serial.read()
    before = positions(controller)
    write(controller, "@400", "X7$", end=end)
    bench.run(1.0)
    assert positions(controller) == (before[0] + 7, *before[1:])


@given(
    line=st.builds(
        "{} {}{}{}".format,
        st.sampled_from((300, 1200, 2400, 4800, 9600)),
        st.sampled_from((7, 8)),
        st.sampled_from("NEO"),
        st.sampled_from((1, 2)),
    ),
    data=st.lists(st.sampled_from((b"(", b"U", b"61", b"\r", b"+", b"G", b"\0", b"\xff", b"((")), max_size=6).map(
        b"".join
    ),
)
@example(line="9600 7N1", data=b"(+")
@example(line="9600 7O1", data=b"G\r%\r")
@settings(max_examples=60, deadline=None)
def test_characters_of_any_frame_before_initialisation(line, data):
    """Initialisation: after any characters in another format, a host in the right format gets its `U`."""
    bench = Bench()
    if1 = bench.add("if1", line=line)
    bench.run(1.5)
    if1.serial.write(data)
    bench.run(1.0)
    if1.power_cycle()
    host = if1.serial.host
    host.bytesize, host.parity, host.stopbits = 8, "N", 2
    bench.run(1.5)
    if1.serial.read()
    if1.serial.write(b"(")
    bench.run(0.2)
    assert if1.serial.read() == b"U\r"
