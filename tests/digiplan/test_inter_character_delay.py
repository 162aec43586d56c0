"""Configuring the interface: Inter-character delay."""

import itertools

import pytest

from axistwin.core.units import MS, S

from ..scripts import scripts
from .talking import arrivals, command, constant, play, ready, send, since_start, write

CHARACTER = 11 * S / 9600


def gaps(times: list[int]) -> list[float]:
    """Return the times from the end of each character to the beginning of the next."""
    return [after - before - CHARACTER for before, after in itertools.pairwise(times)]


@pytest.mark.parametrize("n", [1, 5, 25])
def test_at_least_this_delay_before_each_transmitted_character(bench, if1, n):
    """Delay: "sending "D5 <CR>" will set a minimum delay of 50mS"; "The maximum programmable delay is 250mS"."""
    command(bench, if1, f"D{n}", seconds=0.1)
    received, begin = arrivals(bench, if1), bench.now
    write(if1, "I")
    bench.run(2)
    assert bytes(byte for _, byte, _ in received) == b"200\r"
    times = [time for time, _, _ in received]
    assert all(n * 10 * MS - 1 <= gap <= n * 10 * MS + 2 * MS for gap in gaps(times)), gaps(times)
    question, answer = 2 * CHARACTER, 10 * S / 9600
    assert times[0] - begin >= question - S / 9600 + n * 10 * MS + answer  # "before each transmitted character"


def test_no_delay_unless_it_is_asked_for(bench, if1):
    """Default values: "Inter-char. delay - 0 mS"."""
    received = arrivals(bench, if1)
    write(if1, "I")
    bench.run(0.1)
    assert all(abs(gap) <= 1 for gap in gaps([time for time, _, _ in received]))


@scripts({
    'Delay: "a number giving the required delay in multiples of 10mS"':
    "U61; D25; E; 0.2 s; 1 s; receives C<CR>; D0; E: C",
    "Delay: it is not move data, and takes effect at once":
    "U61; XG$; D10; 0.1 s; K; 0.09 s; 0.3 s; receives 3<CR>; #",
    "Delay: it precedes each transmitted character; a reply of one letter has three characters in the V format":
    "V61; sends D10<LF>; 0.1 s; sends E<LF>; 0.15 s; receives C; 0.1 s; receives <CR>; 0.15 s; receives <LF>",
    "Default values: after power-up the delay is 0 mS":
    "U61; D25; 0.1 s; power off; power on; 1.5 s; sends (; 0.05 s; receives U<CR>",
})  # fmt: skip
def test_delay_set_and_removed(bench, script):
    message, _, acts = script.partition("; ")
    play(bench, ready(bench, message), acts)


@pytest.mark.parametrize(("message", "fault"), [
    *((f"D{n}", 16) for n in ("26", "99", "255", "999999999999")),
    *((message, 8) for message in ("D", "D-1", "D+5", "D,5", "DD5", "5D", "D5D"))])  # fmt: skip
def test_more_than_250_ms_is_out_of_range(bench, if1, message, fault):
    """Delay: "The maximum programmable delay is 250mS".  R25: out of range; the delay stays as it was.

    R7: `D` without a number, or with something else in its place, is a data fault.
    """
    play(bench, if1, f"{message}; E; 0.05 s; receives F<CR>; K: 128; F: {fault}")


def test_echoes_are_delayed_too(bench):
    """Delay: "inserted before each transmitted character", echoes included."""
    if1 = ready(bench, "U62")
    send(bench, if1, "D5", seconds=0.5)
    received = arrivals(bench, if1)
    write(if1, "E")
    bench.run(1)
    assert bytes(byte for _, byte, _ in received) == b"E\rC\r"
    assert all(gap >= 50 * MS - 1 for gap in gaps([time for time, _, _ in received]))


def test_a_running_motor_does_not_wait_for_slow_characters(bench, if1):
    """Introduction: the controller "is then free to perform other tasks while the motor is running"."""
    write(if1, "D25", "X400$")
    for message in "KNIFEO":
        write(if1, message)
    bench.run(10)
    assert since_start(if1.axes["X"]) == constant(400, 400)
