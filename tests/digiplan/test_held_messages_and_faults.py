"""Chapters Emergency stop and limit inputs, Clearing fault conditions: messages that wait for the end of a motion."""

import pytest

from .talking import ask, command, moving, ready


def at_speed_with_two_waiting(bench, if1):
    """Run X at 20,000 steps/s, where a stop takes 1.96 s; a Y move is held, and a Z move waits after it."""
    command(bench, if1, "X@20000G$", seconds=5)
    command(bench, if1, "Y20$", "Z7$", seconds=0.05)


@pytest.mark.parametrize(("pin", "status"), [("estop", b"41\r"), ("limit_plus", b"73\r"), ("y_fault", b"25\r")])
def test_reading_the_status_does_not_start_what_was_held(bench, if1, pin, status):
    """Emergency stop: "a Motion Status request must be made before the system can be restarted", by a new command."""
    at_speed_with_two_waiting(bench, if1)
    if1.pins[pin].drive(False)
    bench.run(0.01)
    if1.pins[pin].release()
    assert ask(bench, if1, "K", 0.05) == status
    assert ask(bench, if1, "K", 0.05) == b"9\r"  # X is still decelerating
    bench.run(5)
    assert if1.axes["Y"].position == if1.axes["Z"].position == 0 and not moving(if1)
    assert ask(bench, if1, "E") == b"C\r"
    command(bench, if1, "Y-3@400$", seconds=0.5)
    assert if1.axes["Y"].position == -3


def test_what_is_asked_for_after_the_fault_is_held_as_always(bench, if1):
    """Clearing: a move that is requested after the status request is held until X is at rest."""
    at_speed_with_two_waiting(bench, if1)
    if1.pins["estop"].drive(False)
    bench.run(0.01)
    if1.pins["estop"].release()
    ask(bench, if1, "K", 0.05)
    command(bench, if1, "Z9@400$", seconds=5)
    assert (if1.axes["Y"].position, if1.axes["Z"].position) == (0, 9)


def test_a_limit_behind_the_motion_that_stops_nothing_leaves_what_is_held(bench):
    """Emergency stop and limit inputs: option limits="motion ahead": the other limit neither stops nor cancels."""
    if1 = ready(bench, limits="motion ahead")
    command(bench, if1, "X400@400$", "Y20$", seconds=0.1)
    if1.pins["limit_minus"].drive(False)
    ask(bench, if1, "K")
    bench.run(2)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (400, 20)
