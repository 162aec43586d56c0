"""The stored sequence as lines, the step in progress, and the time at which each step begins."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import parse
from axistwin.controllers.digiplan.listing import listed, typed
from axistwin.core.units import MS

from .talking import ask, command, number, play, ready, write


def stored(controller: Controller) -> tuple[str, ...]:
    return controller.programs["sequence"].lines


def running(controller: Controller) -> int | None:
    """Return the number of the step in progress; the first step is 1."""
    index = controller.programs["sequence"].running
    return None if index is None else index + 1


def begun(bench: Bench, controller: Controller) -> list[tuple[int, int]]:
    """Return a list that receives, for each step that begins, (time in ns from the first step, step number)."""
    found: list[tuple[int, int]] = []
    first: list[int] = []

    def watch(program: str, index: int) -> None:
        assert program == "sequence" and running(controller) == index + 1
        first.append(bench.now)
        found.append((bench.now - first[0], index + 1))

    controller.subscribe_lines(watch)
    return found


# Lines


@pytest.mark.parametrize(("sequence", "lines"), [
    (":X1000@200:Y:X-:Y-:$", ("X1000@200", "Y", "X-", "Y-")),
    (": S2 : H13 L2 Z100 @ 40 S4 R1 : P2,50 : Y100@200 : $", ("S2", "H13L2Z100@40S4R1", "P2,50", "Y100@200")),
    (":S1:X400@100:Y:=5,2:R1:Z50:=24,1:$", ("S1", "X400@100", "Y", "=5,2", "R1", "Z50", "=24,1")),
    (":X@1000G:H1A:$", ("X@1000G", "H1A")),
    (":XG:H3A=2,1:$", ("XG", "H3A=2,1")),
    (":Y400:%:Y-:$", ("Y400", "%", "Y-")),
    (":B-20:X1000B:B+50:Y-400B:$", ("B-20", "X1000B", "B+50", "Y-400B")),
    (":X2000/Y500@1000:YZ/X-:$", ("X2000/Y500@1000", "YZ/X-")),
    (":X1000Y-2000:$", ("XY-2000",)),
    (":H2=10,1:$", ("H2=10,1",)),
    (":P0:P4,20:$", ("P0", "P4,20")),
    ("", ())])  # fmt: skip
def test_each_step_is_a_line_as_it_is_typed(sequence, lines):
    """Programming a sequence and later chapters: the manual's examples; of two distances the last one is listed."""
    assert listed(sequence) == lines


def optional(pieces):
    return st.one_of(st.just(""), pieces)


numbers = st.integers(0, 999_999_999).map(str)
axis_names = st.permutations(["X", "Y", "Z"]).flatmap(lambda axes: st.integers(1, 3).map(lambda n: axes[:n]))


@st.composite
def axes(draw, names):
    """Generate axes, each with or without a sign, and an optional distance."""
    return "".join(name + draw(st.sampled_from(["", "+", "-"])) + draw(optional(numbers)) for name in names)


@st.composite
def moves(draw):
    """Generate moves with their parameters, in any valid order."""
    names = draw(axis_names)
    minor = len(names) > 1 and draw(st.booleans())
    named = draw(axes(names[:1] if minor else names)) + (f"/{draw(axes(names[1:]))}" if minor else "")
    ending = draw(optional(st.just("G"))) if minor else draw(st.sampled_from(["", "G", "B"]))
    speed = draw(optional(st.integers(1, 99_999).map(lambda speed: f"@{speed}")))
    before, behind = draw(st.permutations([speed, ""]))
    return before + named + ending + behind


lines_of = st.lists(st.integers(1, 3), min_size=1, max_size=3).map(lambda found: "".join(map(str, found)))
outputs = st.lists(st.integers(1, 5), min_size=1, max_size=5).map(lambda found: "".join(map(str, found)))
backlashes = st.integers(-255, 255).map(lambda distance: f"B{distance:+}")


@st.composite
def steps(draw):
    """Generate steps of a sequence, with all commands that are allowed, in the manual's order."""
    waits = draw(optional(lines_of.map("H{}".format))) + draw(optional(lines_of.map("L{}".format)))
    if draw(st.booleans()):
        repeat = f"={draw(st.integers(0, 255))},1"
        return waits + draw(st.sampled_from(["A", "A" + repeat, repeat]))
    ends = draw(
        st.one_of(
            st.tuples(optional(outputs.map("S{}".format)), optional(outputs.map("R{}".format))).map("".join),
            st.tuples(st.integers(0, 5), optional(st.integers(1, 99).map(",{}".format))).map(
                lambda p: f"P{p[0]}{p[1]}"
            ),
        )
    )
    return waits + draw(optional(backlashes)) + draw(optional(moves())) + ends or "%"


@given(steps())
def test_a_line_read_again_is_the_same_step(text):
    """A listed line, sent again, gives the same step; the first axis, which decides on backlash, stays first."""
    message = parse(f":{text}:$", COMMANDS)
    assert message.problems == []
    (step,) = message.steps
    (again,) = parse(f":{typed(step)}:$", COMMANDS).steps
    assert again == step and [*again.major.items(), *again.minor.items()] == [*step.major.items(), *step.minor.items()]
    assert typed(again) == typed(step)


@pytest.mark.parametrize("text", [">3<10^100X500@9000S1", "D5>4", "B-7XB"])
def test_a_direct_message_can_be_written_as_well(text):
    """Speed to Acceleration rate: a direct message is listed with its parameters, which sequences do not allow."""
    (step,) = parse(text, COMMANDS).steps
    assert parse(typed(step), COMMANDS).steps == [step]


# Running


def test_nothing_is_stored_in_an_interface_that_was_just_switched_on(bench, if1):
    assert (stored(if1), running(if1)) == ((), None) and if1.programs["sequence"].silent == frozenset()


@pytest.mark.parametrize(
    ("sequence", "begins"),
    [
        # S and R take a cycle of 1 ms, 3 steps at the start/stop speed of 400 take 7.5 ms, and `P0,5` takes 50 ms
        (":S1:X3@400:P0,5:R1:Y2@100:$", [(0, 1), (1, 2), (8.5, 3), (58.5, 4), (59.5, 5)]),
        # `=2,2` is two more passes from step 2; 4 steps at 400 steps/s take 10 ms, the repeat 1 ms
        (":S1:X4@400:=2,2:R1:$", [(0, 1), (1, 2), (11, 3), (12, 2), (22, 3), (23, 2), (33, 3), (34, 4)]),
        # each pass of the outer repeat begins the inner one again; every step takes 1 ms here
        (":S1:=1,1:R1:=1,1:$", list(enumerate([1, 2, 1, 2, 3, 4, 1, 2, 1, 2, 3, 4]))),
    ],
)
def test_every_step_begins_when_the_one_before_has_ended(bench, if1, sequence, begins):
    """Programming a sequence, Repeating: the time in ms at which each step begins, and its number."""
    found = begun(bench, if1)
    command(bench, if1, sequence)
    assert found == [(ms * MS, step) for ms, step in begins]
    assert (running(if1), if1.registers["step"].read()) == (None, 0)
    assert number(bench, if1, "O") == begins[-1][1], "O stays at the last step"


def test_the_running_step_is_that_of_now(bench, if1):
    """A step of 2 pulses at 100 steps/s is the running step for 20 ms."""
    found = begun(bench, if1)
    write(if1, ":Y2@100:S1:$")
    bench.run_until(lambda: found, 1)
    for seconds, step in ((0.0199, 1), (0.0001, 2), (0.0009, 2), (0.0001, None)):
        bench.run(seconds)
        assert (running(if1), if1.registers["step"].read()) == (step, step or 0)


def test_a_step_that_waits_runs_until_its_input_comes(bench, if1):
    """Combining inputs and outputs: H1 is the running step until its input is high."""
    found = begun(bench, if1)
    command(bench, if1, ":H1:S1:$", seconds=5.0)
    assert (running(if1), len(found)) == (1, 1)
    if1.pins["input1"].drive(True)
    assert bench.run_until(lambda: len(found) > 1, 0)


def test_cancel_ends_the_step_at_once(bench, if1):
    """Index mode: `#` ends the sequence at once, although the motor still decelerates."""
    command(bench, if1, ":X9999@2000:Y:$", seconds=1.0)
    assert running(if1) == 1
    write(if1, "#")
    assert bench.run_until(lambda: running(if1) is None, 0.1) and if1.axes["X"].velocity > 0
    assert stored(if1) == ("X9999@2000", "Y")


def test_the_host_in_control_leaves_the_step_running(bench, if1):
    """Controller intervention: the step `%` lasts until the host sends %."""
    found = begun(bench, if1)
    play(bench, if1, ":%:S1:$; 0.2 s; receives %<CR>; X10$; 1 s")
    assert ([step for _, step in found], running(if1)) == ([1], 1)
    command(bench, if1, "%")
    assert [step for _, step in found] == [1, 2]


@pytest.mark.parametrize(("text", "steps", "speed"), [("X99@100$", 0, 100), (":X@500G:S1:$", 2, 500)])
def test_a_move_that_runs_without_a_step(bench, if1, text, steps, speed):
    """A direct message is no step; Run mode: the step ends when the run has begun, and so does the last step."""
    found = begun(bench, if1)
    command(bench, if1, text, seconds=0.5)
    assert (running(if1), len(found), if1.axes["X"].velocity) == (None, steps, speed)


@pytest.mark.parametrize("pin", ["estop", "limit_plus", "x_fault"])
def test_a_fault_ends_it(bench, if1, pin):
    """Repeating: "Once a sequence has been terminated, it can only be restarted from the beginning"."""
    found = begun(bench, if1)
    command(bench, if1, ":X99999@1000:Y:$", seconds=0.5)
    if1.pins[pin].drive(False)
    bench.run(0)
    assert running(if1) is None
    bench.run(1.0)
    assert ([step for _, step in found], stored(if1)) == ([1], ("X99999@1000", "Y"))


def test_another_sequence_takes_the_place_when_this_one_is_over(bench, if1):
    """A message with `$` is held while the interface is busy; Motion status: one with a data fault is ignored."""
    found = begun(bench, if1)
    command(bench, if1, ":X20@100:Y20:$", seconds=0.1)
    command(bench, if1, ":S1:$", seconds=0.25)
    assert (stored(if1), running(if1)) == (("X20@100", "Y20"), 2)
    bench.run(0.5)
    assert (stored(if1), running(if1)) == (("S1",), None)
    assert [step for _, step in found] == [1, 2, 1]
    command(bench, if1, ":S1:Q:$")
    assert stored(if1) == ("S1",)


@pytest.mark.parametrize(("model", "lock", "kept"), [("if1", "[", ()), ("if2", "#", ()), ("if2", "[", ("H1", "X100"))])
def test_an_if2_that_is_locked_keeps_its_sequence(bench, model, lock, kept):
    """Using the battery backup: with DSR low the stored sequence starts when the self-test is over."""
    card = ready(bench, model=model)
    command(bench, card, ":H1:X100:$", lock)
    assert stored(card) == ("H1", "X100")
    card.power(False)
    assert (stored(card), running(card), card.registers["step"].read()) == (kept, None, 0)
    found = begun(bench, card)
    card.serial.host.dtr = False
    card.power(True)
    bench.run(0.9)
    assert (stored(card), running(card)) == (kept, None), "the LED is on: it tests itself"
    bench.run(0.2)
    assert (running(card), found) == ((1, [(0, 1)]) if kept else (None, []))
    card.power(False)
    assert running(card) is None


def test_whoever_has_seen_enough_is_told_no_more(bench, if1):
    found = []
    look_away = if1.subscribe_lines(lambda program, index: found.append(index))
    command(bench, if1, ":S1:R1:$")
    look_away()
    command(bench, if1, ":$")
    assert found == [0, 1]


# Orders


@pytest.mark.parametrize(("message", "end"), [("U61", "\r"), ("V61", "\r\n"), ("U62", "\r")])
def test_orders_are_messages_in_either_data_format(bench, message, end):
    """Initialisation: V messages "must be terminated by <LF>", CR being optional; U messages by CR only."""
    if1 = ready(bench, message)
    write(if1, ":X400@100:Y:$", "#", end=end)
    bench.run(1)
    start, cancel = if1.product.orders("sequence")
    for order, step in ((start, 1), (cancel, None)):
        if1.serial.write(order.says)
        bench.run(0.5)
        assert running(if1) == step
    if1.serial.read()
    assert ask(bench, if1, "F", end=end).endswith(f"0{end}".encode())
