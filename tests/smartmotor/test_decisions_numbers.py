"""Decisions of docs/fidelity.md on numbers that a motor is given at an unusual moment or with an unusual sign."""

import pytest

from .playing import play, scripts
from .scenarios import clock, points, position
from .talking import SAMPLE_S, UNIT, advance, ask, ready, send, value

CAM = "MF4 F=16 D=0 BASE=8 SIZE=8 aw[0] 0 10 20 30 40 50 60 70 80. MV V=0 G"


@scripts(
    {
        '9.3: positions are "relative to where it is when it starts into the cam table": 3 counts are 30 further':
        f"S {CAM}; master 3 in 1 samples; 4 samples; CTR is 3; at 0; MC G; 2 samples; at 30; "
        "turn 4 8 9 by 1: 40 80 90",
        "2.0, item 6: a fault prevents the download; one that has begun is completed, with the fault afterwards":
        "wired; LOAD => <06>; a=1 b=2 => <06>; C high; 0.01 s; c=3 END => <06>; sends <FF><FF><SP>; "
        "RCKS => *P<CR>; RBr RBk -> 1 0; LOAD; 0.01 s",
    }
)  # fmt: skip
def test_decisions_numbers(script):
    play(script)


@pytest.mark.parametrize("target", [1000, -1000])
def test_the_sign_of_v_means_nothing_in_mode_position(bench, motor, target):
    """Base 4: in MP the target gives the direction, V the speed."""
    assert send(bench, motor, f"MP A=65536 V={-10 * UNIT} P={target} G RBs", 0) == b"0\r"
    advance(bench, 50)
    assert motor.axes["shaft"].velocity * SAMPLE_S == pytest.approx(10 if target > 0 else -10)
    advance(bench, 200)
    assert motor.axes["shaft"].position == target


def test_o_names_the_shaft_and_keeps_the_following_error(bench):
    """O= gives the present *shaft* position its value; what the load has displaced is made up for as before."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "MP A=100 V=100 P=0 G", 0.2)
    motor.axes["shaft"].load(0.2)
    bench.run(0.01)
    error = value(bench, motor, "0-@P")
    assert error < -5
    send(bench, motor, "O=5000", 0)
    assert ask(bench, motor, "RP", 0) == "5000"
    assert ask(bench, motor, "RPE", 0) == str(error)
    bench.run(1)
    assert ask(bench, motor, "RP", 0) == str(5000 + error)
    assert motor.axes["shaft"].position == 0


def test_the_buffer_of_host_mode_counts_what_waits(bench, motor):
    """Q: 32 places after MD, one fewer for each position whose clock is known; what is too much is lost (20h)."""
    assert send(bench, motor, "MD Q", 0.01) == bytes((0xF9, 0x01, 32, 0, 0))
    assert send(bench, motor, points(*((n, n) for n in range(32))) + "Q", 0.01) == bytes((0xF9, 0x01, 0, 0, 0))
    assert send(bench, motor, points((32, 32)) + "Q", 0.01) == bytes((0xF9, 0x21, 0, 0, 0))
    assert motor.registers["RBc"].read() == 1


@pytest.mark.parametrize(
    ("records", "flags"),
    [
        (points((0, 100), (10, 99)), 0x05),  # the clock goes backwards
        (points((0, 0)) + position(2**31 - 1) + clock(1), 0x01),  # any position, however far
    ],
)
def test_delta_errors_of_host_mode(bench, motor, records, flags):
    """Only a clock that goes backwards is an invalid delta (04h); a distance has no bound that is known (08h)."""
    send(bench, motor, "MD " + records, 0.01)
    assert send(bench, motor, "Q", 0.01)[1] == flags
    assert motor.registers["RBs"].read() == (flags >> 2 & 1)
