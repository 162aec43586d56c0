"""The driver of the IF1."""

import pytest

from axistwin.drivers import BusyError, RefusedError, SilentError, Trapezoid, WrongAnswerError, connect

from ..told import raises


@pytest.fixture
def twin(ports):
    return ports.add("if1")


@pytest.fixture
def if1(twin):
    with connect("if1", "if1", home_input=1) as controller:
        yield controller


def true_position(twin, axis="X"):
    return twin.axes[axis].position


def drive(twin, pin, level):
    twin.pins[pin].drive(level)


def test_moves_of_each_axis_end_at_the_exact_position(twin, if1):
    if1.axes["Y"].move_to(-300)
    assert if1.axes["Y"].wait(60).position == -300
    if1.axes["X"].move_by(120)
    if1.axes["X"].wait(60)
    if1.axes["X"].move_to(120)  # the distance is 0, so nothing is sent
    assert (true_position(twin), true_position(twin, "Y")) == (120, -300)
    if1.move_together({"X": 220, "Y": -400})
    assert (if1.axes["X"].wait(60).position, if1.axes["Y"].position()) == (220, -400)
    assert (true_position(twin), true_position(twin, "Y")) == (220, -400)
    raises(RefusedError, "equal distances", if1.move_together, {"X": 0, "Y": 0})


def test_the_estimate_never_runs_back_nor_beyond_the_target(twin, if1):
    x = if1.axes["X"]
    x.set_profile(velocity=20_000, acceleration=20_000)
    x.move_to(200_000)
    seen = [x.status()]
    while seen[-1].moving:
        seen.append(x.status())
    positions = [status.position for status in seen]
    assert positions == sorted(positions)
    assert all(status.estimated for status in seen[:-1]) and not seen[-1].estimated
    assert positions[-1] == true_position(twin) == 200_000


def test_one_axis_moves_at_a_time(twin, if1):
    if1.axes["X"].move_at(900)
    for command in (
        lambda: if1.axes["Y"].move_to(5),
        lambda: if1.axes["Y"].move_by(5),
        lambda: if1.axes["Y"].move_at(5),
        lambda: if1.axes["X"].set_position(0),
        lambda: if1.sequence(["X5"]),
        lambda: if1.move_together({"X": 5, "Y": 5}),
    ):
        raises(BusyError, "is moving", command)
    if1.stop()
    assert if1.axes["X"].wait(60).position == true_position(twin)


def test_a_port_that_is_opened_again_finds_the_controller_as_it_was(twin, if1):
    if1.axes["X"].move_to(70)
    if1.axes["X"].wait(60)
    if1.close()
    assert {name: status.position for name, status in if1.statuses().items()} == {"X": 70, "Y": 0, "Z": 0}


def test_home_is_the_place_of_the_input_and_becomes_zero(twin, if1):
    x = if1.axes["X"]
    x.home(1)
    assert x.status().moving
    drive(twin, "input1", True)
    status = x.wait(60)
    assert (status.position, status.at_home) == (0, True)
    raises(RefusedError, "already high", x.home, 1)


def test_another_host_that_moves_an_axis_is_noticed(ports, if1):
    x = if1.axes["X"]
    x.move_to(500)
    x.wait(60)
    if1.message("X77$")
    ports.run(5)
    assert x.status().lost == "another host has moved the IF1"


@pytest.mark.parametrize(("own", "other", "says"), [(False, "X+@900G$", "is moving"), (True, "X77$", "has moved")])
def test_another_host_in_motion_is_noticed(if1, own, other, says):
    if own:
        if1.axes["X"].move_to(10)
    if1.message(other)
    while not (status := if1.axes["X"].status()).lost:
        pass
    assert says in status.lost


def sent_before(ports, twin, *messages):
    """Let another host send messages after power-up."""
    ports.run(2)
    for message in messages:
        twin.serial.write(message)
        ports.run(2)


def test_a_controller_that_moves_at_the_connection_has_no_position(ports, twin):
    sent_before(ports, twin, b"(", b"U62\r", b"X@900G$\r")
    with connect("if1", "if1") as if1:
        assert "was moving" in if1.axes["X"].status().lost
        raises(RefusedError, "home_input=1", if1.axes["X"].home, 1)


def test_a_sequence_with_inputs_and_outputs(twin, if1):
    if1.outputs(on=[1, 3], off=[2])
    assert not if1.busy()
    assert [twin.pins[f"output{n}"].level for n in (1, 2, 3)] == [True, False, True]
    if1.sequence(["H2", "X40@100", "Y"])
    assert if1.busy() and if1.inputs() == {1: False, 2: False, 3: False}
    drive(twin, "input2", True)
    while if1.busy():
        pass
    assert true_position(twin) == true_position(twin, "Y") == 40
    assert "sequence" in if1.axes["X"].status().lost and not if1.axes["Z"].status().lost


def test_a_wait_for_a_sequence_lasts_until_it_has_ended(ports, twin, if1):
    """It waits for an input, moves, pauses, and moves; an axis that is not in it keeps its position."""
    if1.sequence(["H2", "X40@100", "P0,50", "Y70"])
    x, y = if1.axes["X"], if1.axes["Y"]
    for _ in range(10):
        assert x.status().moving and not if1.axes["Z"].status().moving
    drive(twin, "input2", True)
    assert y.wait(60).lost == x.wait(1).lost == "a sequence has moved the IF1"
    assert (true_position(twin), true_position(twin, "Y")) == (40, 70)
    assert if1.axes["Z"].position() == 0
    if1.sequence(["H3", "X40"])
    x.stop()
    assert not x.wait(60).moving


def test_a_message_that_is_refused_moves_nothing(if1):
    raises(RefusedError, "invalid message", if1.begin, {"X": 1}, 10, 100, "X10Q$")
    assert if1.axes["X"].position() == 0
    if1.outputs()
    if1.move_together({"X": 0, "Y": 0})
    raises(RefusedError, "at most 999999999", if1.axes["X"].move_to, 10**9)
    raises(RefusedError, "expected 1 to 25000", if1.axes["X"].move_at, 30_000)


@pytest.mark.parametrize("formats", [b"U61\r", b"U62\r", b"V61\r\n", b"V62\r\n"])
def test_an_initialised_controller_is_adopted_whatever_its_format(ports, twin, formats):
    sent_before(ports, twin, b"(", formats, b"X10")  # the last one is half a message of another host
    with connect("if1", "if1") as if1:
        if1.axes["X"].move_to(30)
        assert if1.axes["X"].wait(60).position == true_position(twin) == 30 and not if1.busy()


def test_the_other_families_are_not_an_if1(ports):
    ports.add("smartmotor")
    with pytest.raises((SilentError, WrongAnswerError), match="IF1"):
        connect("smartmotor", "if1")


@pytest.mark.parametrize(("answers", "says"), [
    ([b"E\rC\r\n" * 2 + b"I\r5\r\n", b"Q\r", b"K"], "check the line for noise"),
    ([b"C\r" * 2 + b"5\r", b"x\r"], "expected a whole number"), ([b"", b"", b"hello"], "expected the letter U"),
    ([b"C\r" * 2 + b"5\r", b"9" * 5000], "check that the controller is connected to this port"),
    ([b"E\rC\r\n" * 2 + b"I\r5\r\n", b"F", b"x"], "after the message F")])  # fmt: skip
def test_garbage_raises_a_clear_error(ports, answers, says):
    left = iter(answers)
    with pytest.raises(WrongAnswerError, match=says):
        connect(ports.answering(lambda _: next(left, b"")), "if1", timeout=0.1)


def test_the_estimate_of_a_triangle_and_a_trapezoid():
    """At 10 steps/s², 100 steps reach 31.6 steps/s, and 1000 steps reach 50; the times are calculated by hand."""
    triangle = Trapezoid(50, 10, 100)
    assert triangle.position(2) == 20 and triangle.position(10) == 100
    assert triangle.position(40**0.5 - 2) == pytest.approx(80)
    trapezoid = Trapezoid(50, 10, 1000)
    assert (trapezoid.position(5), trapezoid.position(10), trapezoid.position(25)) == (125, 375, 1000)
    assert Trapezoid(50, 10).position(100) == 125 + 95 * 50


RUNS = {
    "a move": lambda if1, x: x.move_to(5000),
    "a run": lambda if1, x: x.move_at(900),
    "two axes": lambda if1, x: if1.move_together({"X": 5000, "Y": 5000}),
}


@pytest.mark.parametrize("way", RUNS)
def test_two_runs_into_the_same_switch_with_as_many_steps(ports, way):
    """N is the count of the last move; a second run of as many steps is not one that the IF1 has refused."""
    twin = ports.add("if1", X={"limits": [-1000, 500]})
    with connect("if1", "if1") as if1:
        x, y = if1.axes["X"], if1.axes["Y"]
        x.set_profile(velocity=900)
        for _ in range(3):
            RUNS[way](if1, x)
            ports.run(20)  # a busy computer asks only after the end
            status = x.status()
            assert (status.position, status.lost, status.faults[0].name) == (true_position(twin), "", "limit")
            assert 500 <= status.position < 550
            x.clear_faults()
            if1.move_together({"X": 0, "Y": 0}) if y.position() else x.move_to(0)
            assert x.wait(60).position == true_position(twin) == true_position(twin, "Y") == 0


def test_a_move_that_a_switch_prevents_makes_no_step(ports, twin, if1, monkeypatch):
    """The switch opens between the check and the move: the old count is not that of this move."""
    x, message = if1.axes["X"], if1.core.message
    for target, way in ((300, "none"), (600, "opens")):

        def with_switch(text, way=way):
            if way == "opens" and "+300" in text:
                drive(twin, "limit_plus", False)
            yield from message(text)

        monkeypatch.setattr(if1.core, "message", with_switch)
        x.move_to(target)
        while (status := x.status()).moving:
            pass
    assert (status.position, status.lost, true_position(twin)) == (300, "", 300) and "limit" in status.missed
