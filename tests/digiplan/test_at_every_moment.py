"""Faults, requests and power cuts at every moment of a sequence with all kinds of steps: the interface recovers."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.units import MS, S

from .talking import command, moves, moving, number, positions, ready, send, status, status_word, times, write

EVERYTHING = ":S1:X60@900BP2,3:H1L2Y-60/Z10@600S3:X@700G:P0,5:H1A:R1:P2,2:Z-9@100:=1,2:R3:$"
"""A short index with ramp and backlash correction, pulses, waits, an interpolation, a run and its abort, a repeat."""

Act = Callable[[Bench, Controller], object]


def begin() -> tuple[Bench, Controller]:
    """Return a bench and an IF2 on which the sequence has just begun."""
    bench = Bench()
    if2 = ready(bench, model="if2")
    if2.pins["input1"].drive(True)
    command(bench, if2, "B-10", seconds=0.1)
    write(if2, EVERYTHING)
    bench.run_until(lambda: if2.pins["output1"].level, 1.0)
    return bench, if2


def undisturbed() -> list[int]:
    """Return the times of all changes in the first pass, the times half a ms later, and times between them, in ns."""
    bench, if2 = begin()
    begun_ns = bench.now
    seen = {begun_ns}
    for pin in if2.pins.values():
        pin.subscribe(lambda changed: seen.add(changed.clock.now))
    bench.run(5.0)
    assert status(bench, if2, "E") == "C"
    for axis in if2.axes.values():
        for move in axis.train.moves:
            if move.start_ns >= begun_ns and move.profile.pulses:
                seen |= {move.start_ns, move.end_ns}
    moments = sorted(at_ns - begun_ns for at_ns in seen)
    moments = moments[: len(moments) // 2 + 2]
    between = {(a + b) // 2 for a, b in pairwise(moments)}
    return sorted({*moments, *between, *(at_ns + MS // 2 for at_ns in moments)})


MOMENTS = undisturbed()


def test_the_sequence_itself():
    """The sequence without faults moves X +70 -10 twice, Y and Z together, a run, and Z -9."""
    bench, if2 = begin()
    bench.run(5.0)
    x = moves(if2.axes["X"])
    run = x[2]
    # 50 ms from the start: level 400, 500, 600 of 10 ms: 15 steps, 20 ms at 700: 14; down 15: 44 and what own time adds
    assert 44 <= run <= 46
    assert x == [70, -10, run] * 2
    assert moves(if2.axes["Y"]) == [-60] * 2
    assert moves(if2.axes["Z"]) == [10, -9] * 2
    assert [if2.pins[f"output{n}"].level for n in range(1, 6)] == [False] * 5
    assert len(MOMENTS) > 30


def assert_recovered(bench: Bench, if2: Controller) -> None:
    """Assert that the interface is at rest and clear, that no output pulse remains, and that moves work."""
    for _ in range(2):
        status_word(bench, if2)
    number(bench, if2, "F")
    assert not moving(if2)
    assert (status(bench, if2, "E"), status_word(bench, if2)) == ("C", 0)
    assert not if2.pins["output2"].level
    before = positions(if2)
    command(bench, if2, "XY-25@400$", seconds=0.5)
    assert positions(if2) == (before[0] + 25, before[1] - 25, before[2])
    command(bench, if2, ":$", seconds=4.0)
    assert status(bench, if2, "E") == "C"
    assert moves(if2.axes["Y"])[-2:] == [-60] * 2 and moves(if2.axes["Z"])[-4:] == [10, -9] * 2


def at_every_moment(act: Act, check: Act) -> None:
    """Play the sequence once for each moment; call `act` at the moment and `check` at the end."""
    for moment_ns in MOMENTS:
        bench, if2 = begin()
        bench.run(moment_ns / S)
        act(bench, if2)
        check(bench, if2)


def test_cancelling_at_every_moment():
    """Cancel: "This will stop any axis in motion"; it also ends a wait, a pulse or a pause before a reversal."""

    def cancel(bench: Bench, if2: Controller) -> None:
        command(bench, if2, "#")
        stands = positions(if2)
        assert (status(bench, if2, "E"), status_word(bench, if2)) == ("C", 0)
        bench.run(1.0)
        assert positions(if2) == stands

    at_every_moment(cancel, assert_recovered)


@pytest.mark.parametrize("names", [["estop"], ["x_fault"], ["y_fault"], ["estop", "y_fault"]])
def test_a_fault_at_every_moment(names):
    """Clearing: "any axis in motion will stop", "further movement is inhibited" until the status request (R22)."""

    def fault(bench: Bench, if2: Controller) -> None:
        for name in names:
            if2.pins[name].drive(not if2.pins[name].level)
        bench.run(0.2)
        stands = positions(if2)
        bench.run(1.0)
        assert positions(if2) == stands
        for name in names:
            if2.pins[name].release()
        bench.run(0.1)
        expected = sum({"e": 32, "x": 16, "y": 16}[name[0]] for name in names)
        assert status_word(bench, if2) == expected

    at_every_moment(fault, assert_recovered)


@pytest.mark.parametrize(("name", "back"), [("limit_plus", "XYZ-5"), ("limit_minus", "XYZ5")])
def test_a_limit_at_every_moment(name, back):
    """Clearing, limits: a motion towards the limit stops; afterwards the axis moves in the other direction only."""

    def limit(bench: Bench, if2: Controller) -> None:
        if2.pins[name].drive(False)
        bench.run(4.0)
        assert not moving(if2)
        assert status_word(bench, if2) == 64
        before = positions(if2)
        command(bench, if2, f"{back.replace('XYZ-', 'X-Y-Z-')}@400$")
        step = -5 if "-" in back else 5
        assert positions(if2) == tuple(at + step for at in before)
        if2.pins[name].release()
        bench.run(0.1)

    at_every_moment(limit, assert_recovered)


def test_locking_at_every_moment_changes_nothing():
    """Lockout: a lock affects only communication, so the sequence continues to its end."""

    def lock(bench: Bench, if2: Controller) -> None:
        command(bench, if2, "[", "#", seconds=4.0)
        assert status(bench, if2, "E") == "["
        assert moves(if2.axes["Z"]) == [10, -9] * 2
        command(bench, if2, "]", seconds=0.1)

    at_every_moment(lock, assert_recovered)


def test_asking_at_every_moment_changes_no_pulse():
    """Report-back: "at any time"; only a pause before a reversal "may be extended if ... being interrogated"."""
    bench, if2 = begin()
    bench.run(5.0)
    quiet = {name: moves(if2.axes[name]) for name in "XYZ"}

    def request(bench: Bench, if2: Controller) -> None:
        for letter in "KFIOQEN":
            write(if2, letter)
        bench.run(5.0)
        assert if2.serial.read().count(b"\r") == 6
        # the run between two delays may be longer by what the answers took
        assert moves(if2.axes["Y"]) == quiet["Y"] and moves(if2.axes["Z"]) == quiet["Z"]

    at_every_moment(request, assert_recovered)


def test_a_power_cut_at_every_moment():
    """Battery backup: without a lock all data and outputs are lost; the axes keep their positions."""

    def cut(bench: Bench, if2: Controller) -> None:
        if2.power(False)
        stands = positions(if2)
        assert not any(if2.pins[name].level for name in ("output1", "output2", "output3", "led"))
        bench.run(1.0)
        assert positions(if2) == stands and not moving(if2)
        if2.power(True)
        bench.run(3.0)
        if2.serial.write(b"(")
        bench.run(0.1)
        assert send(bench, if2, "U61", seconds=1.2) == b"U\r"
        assert positions(if2) == stands

    def is_new(bench: Bench, if2: Controller) -> None:
        assert status(bench, if2, "E") == "C"
        command(bench, if2, ":$", "Z25$", seconds=0.5)
        assert moves(if2.axes["Z"])[-1] == 25
        assert set(times(if2.axes["Z"])[-2:]) and number(bench, if2, "N") == 25

    at_every_moment(cut, is_new)


def test_a_line_that_dies_at_every_moment():
    """Control lines: without DSR and CTS "The interface will not transmit any data"; it moves, and answers later."""

    def unplug(bench: Bench, if2: Controller) -> None:
        if2.serial.host.dtr = if2.serial.host.rts = False
        for letter in "KEN":
            write(if2, letter)
        bench.run(5.0)
        assert if2.serial.read() == b""
        assert moves(if2.axes["Z"]) == [10, -9] * 2
        if2.serial.host.dtr = if2.serial.host.rts = True
        bench.run(0.2)
        assert if2.serial.read().count(b"\r") == 3

    at_every_moment(unplug, assert_recovered)
