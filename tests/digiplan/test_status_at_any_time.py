"""Chapter Report-back functions: "The interface can be interrogated to establish its status at any time"."""

import pytest

from .talking import ask, ready, write

WAITING = ("X40$", "Y20$", "@200", "Z8$")
"""A move, a move that is held, and two messages that wait in the buffer.  40 steps at 400 steps/s take 100 ms."""


def positions(controller):
    return tuple(controller.axes[axis].position for axis in "XYZ")


def three_moves(controller):
    for message in WAITING:
        write(controller, message)


@pytest.mark.parametrize(
    ("letter", "reply"), [("K", b"3\r"), ("I", b"200\r"), ("O", b"0\r"), ("E", b"E\r"), ("F", b"0\r"), ("Q", b"\3")]
)
def test_a_request_is_answered_whatever_waits_before_it(bench, if1, letter, reply):
    """Report-back: a request is answered "at any time", whatever messages wait before it."""
    three_moves(if1)
    bench.run(0.05)
    assert ask(bench, if1, letter, 0.02) == reply
    assert if1.axes["X"].moving
    bench.run(1)
    assert (positions(if1), ask(bench, if1, "F")) == ((40, 20, 8), b"0\r")


def test_the_position_too(bench, if1):
    """Position report-back: "whilst an axis is in motion"; at or below the start/stop speed the answer is exact."""
    three_moves(if1)
    bench.run(0.05)
    before = if1.axes["X"].position
    steps = int(ask(bench, if1, "N", 0.02))
    assert 0 < before <= steps <= if1.axes["X"].position < 40


def test_requests_between_waiting_messages_do_not_change_their_order(bench, if1):
    """Report-back: a request does not change the order of held messages: Y runs at 400; `@200` is for Z."""
    for message in WAITING:
        write(if1, message, "E")
    bench.run(0.06)
    assert if1.serial.read() == b"E\rE\rE\rE\r"
    bench.run(1)
    y, z = (list(if1.axes[axis].pulse_times()) for axis in "YZ")
    assert y[1] - y[0] == 2_500_000 and z[1] - z[0] == 5_000_000
    assert positions(if1) == (40, 20, 8)


def test_with_echo_a_request_is_echoed_and_answered(bench):
    """Echo back: each character is echoed when it has been processed; the reply follows the echo."""
    if1 = ready(bench, "U62")
    three_moves(if1)
    bench.run(0.05)
    assert if1.serial.read() == b"X40$\rY20$\r@200\r"  # Z8$ has not been processed yet
    assert ask(bench, if1, "E", 0.02) == b"E\rE\r"
    bench.run(1)
    assert (if1.serial.read(), positions(if1)) == (b"Z8$\r", (40, 20, 8))


def test_in_v_format_a_request_ends_in_a_line_feed(bench):
    """Initialisation: "all following instructions must be terminated by <LF>"; the carriage return is optional."""
    if1 = ready(bench, "V61")
    for message in WAITING:
        write(if1, message, end="\n")
    bench.run(0.04)
    assert (ask(bench, if1, "K", 0.02, "\r\n"), ask(bench, if1, "E", 0.02, "\n")) == (b"3\r\n", b"E\r\n")
    assert ask(bench, if1, "E", 0.02, "") == b""


def test_what_is_typed_at_once_is_answered_too(bench, if1):
    """Report-back: a request is answered even if it was in the buffer before the waiting message was read."""
    write(if1, ">1")  # a second of calculation, during which all of it is received
    bench.run(0.05)
    three_moves(if1)
    write(if1, "E")
    assert bench.run_until(lambda: if1.axes["X"].moving, 2)
    bench.run(0.02)
    assert if1.serial.read() == b"E\r" and if1.axes["X"].moving


def test_unlocking_is_no_request_and_keeps_its_place(bench, if1):
    """Lockout: `[` waits behind a held move, and the `]` that was sent after it is executed after it."""
    for message in ("X40$", "Y20$", "[", "]", "Z8$"):
        write(if1, message)
    bench.run(1)
    assert (ask(bench, if1, "E"), positions(if1)) == (b"C\r", (40, 20, 8))


def test_cancel_throws_away_what_waits_and_not_what_was_answered(bench, if1):
    """Run mode: "send the cancel code": it discards all waiting messages, but not the answer being sent."""
    three_moves(if1)
    write(if1, "E", "#", "Z3$")
    bench.run(1)
    x, y, z = positions(if1)
    assert 0 < x < 40 and (y, z) == (0, 3)
    assert if1.serial.read() == b"E\r"


def test_a_request_makes_room_in_the_buffer(bench, if1):
    """Control of data transfer: an answered request leaves the buffer, so DTR is set again below 20 %."""
    for message in ("XG$", "Y20$", "@200"):
        write(if1, message)
    for _ in range(30):
        write(if1, "K")
    bench.run(0.5)
    assert if1.serial.dtr
    assert if1.serial.read().endswith(b"3\r") and ask(bench, if1, "F") == b"0\r"
