"""Faults, requests and power cuts at every moment of a sequence with all kinds of steps: the interface recovers."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS, S

from .talking import command, moves, play, ready, status, write

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
    assert 44 <= run <= 46 and x == [70, -10, run] * 2
    play(bench, if2, "Y moves -60 -60; Z moves 10 -9 10 -9; outputs 00000")
    assert len(MOMENTS) > 30


def recovered(bench: Bench, if2: Controller) -> None:
    """Assert that the interface is at rest and clear, that no output pulse remains, and that moves work."""
    play(bench, if2, "K?; K?; F?; still; E: C; K: 0; output2 is low; mark; XY-25@400$; 0.5 s; moved 25 -25 0; :$; 4 s; "
         "E: C")  # fmt: skip
    assert moves(if2.axes["Y"])[-2:] == [-60] * 2 and moves(if2.axes["Z"])[-4:] == [10, -9] * 2


def at_every_moment(script: str, end: Act = recovered) -> None:
    """Play the sequence once for each moment; at the moment play `script`, and call `end` at the end."""
    for moment_ns in MOMENTS:
        bench, if2 = begin()
        bench.run(moment_ns / S)
        play(bench, if2, script)
        end(bench, if2)


def test_cancelling_at_every_moment():
    """Cancel: "This will stop any axis in motion"; it also ends a wait, a pulse or a pause before a reversal."""
    at_every_moment("#; 0.2 s; mark; E: C; K: 0; 1 s; moved 0 0 0")


@pytest.mark.parametrize(("pins", "flags"), [(["estop"], 32), (["x_fault"], 16), (["y_fault"], 16),
                                             (["estop", "y_fault"], 48)])  # fmt: skip
def test_a_fault_at_every_moment(pins, flags):
    """Clearing: "any axis in motion will stop", "further movement is inhibited" until the status request (R22)."""
    low, released = ("; ".join(f"{pin} {level}" for pin in pins) for level in ("low", "released"))
    at_every_moment(f"{low}; 0.2 s; mark; 1 s; moved 0 0 0; {released}; 0.1 s; K: {flags}")


@pytest.mark.parametrize(("name", "back"), [("limit_plus", "-5"), ("limit_minus", "+5")])
def test_a_limit_at_every_moment(name, back):
    """Clearing, limits: a motion towards the limit stops; afterwards the axis moves in the other direction only."""
    away = f"mark; X{back}Y{back}Z{back}@400$; 0.2 s; moved {back} {back} {back}"
    at_every_moment(f"{name} low; 4 s; still; K: 64; {away}; {name} released; 0.1 s")


def test_locking_at_every_moment_changes_nothing():
    """Lockout: a lock affects only communication, so the sequence continues to its end."""
    at_every_moment("[; #; 4 s; E: [; Z moves 10 -9 10 -9; ]; 0.1 s")


def test_asking_at_every_moment_changes_no_pulse():
    """Report-back: "at any time"; only a pause before a reversal "may be extended if ... being interrogated"."""

    def request(bench: Bench, if2: Controller) -> None:
        write(if2, *"KFIOQEN")
        bench.run(5.0)
        assert if2.serial.read().count(b"\r") == 6
        play(bench, if2, "Y moves -60 -60; Z moves 10 -9 10 -9")  # the run may be longer by what the answers took
        recovered(bench, if2)

    at_every_moment("0 s", request)


def test_a_power_cut_at_every_moment():
    """Battery backup: without a lock all data and outputs are lost; the axes keep their positions."""
    at_every_moment(
        "power off; mark; outputs 00000; led is low; 1 s; moved 0 0 0; still; power on; 3 s; sends (; 0.1 s; "
        "receives U<CR>; U61; 1.2 s; moved 0 0 0; E: C; :$; Z25$; 0.5 s; moved 0 0 25; N: 25",
        lambda bench, if2: None,
    )


def test_a_line_that_dies_at_every_moment():
    """Control lines: without DSR and CTS "The interface will not transmit any data"; it moves, and answers later."""

    def answered(bench: Bench, if2: Controller) -> None:
        bench.run(0.2)
        assert if2.serial.read().count(b"\r") == 3
        recovered(bench, if2)

    line = "host DTR {0}; host RTS {0}"
    at_every_moment(f"{line.format('off')}; K; E; N; 5 s; Z moves 10 -9 10 -9; {line.format('on')}", answered)
