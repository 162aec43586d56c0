"""Decisions of docs/fidelity.md on numbers that a motor is given at an unusual moment or with an unusual sign."""

from .scenarios import clock, points, position
from .scripts import play, scripts
from .talking import UNIT, ask, ready, send, value

CAM = "MF4 F=16 D=0 BASE=8 SIZE=8 aw[0] 0 10 20 30 40 50 60 70 80. MV V=0 G"


@scripts({
    '9.3: positions are "relative to where it is when it starts into the cam table": 3 counts are 30 further':
    f"S {CAM}; master 3 in 1 samples; 4 samples; CTR is 3; at 0; MC G; 2 samples; at 30; "
    "turn 4 8 9 by 1: 40 80 90",
    "2.0, item 6: a fault prevents the download; one that has begun is completed, with the fault afterwards":
    "wired; LOAD => <06>; a=1 b=2 => <06>; C high; 0.01 s; c=3 END => <06>; sends <FF><FF><SP>; "
    "RCKS => *P<CR>; RBr RBk -> 1 0; LOAD; 0.01 s",
    "Base 4: in MP the target gives the direction, V the speed":
    [f"MP A=65536 V={-10 * UNIT} P={target} G RBs -> 0; 50 samples; 1 steps of {target // 100}; 200 samples; "
     f"at {target}"
     for target in (1000, -1000)],
    "Q: 32 places after MD, one fewer for each position whose clock is known; what is too much is lost (20h)":
    f"MD Q => <F9><01><20><00><00>; {points(*((n, n) for n in range(32)))}Q => <F9><01><00><00><00>; "
    f"{points((32, 32))}Q => <F9><21><00><00><00>; RBc -> 1",
    "Only a clock that goes backwards is an invalid delta (04h); a distance has no bound that is known (08h)":
    [f"MD {records}; Q => <F9>{flags}*; RBs -> {scan}"
     for records, flags, scan in (
         (points((0, 100), (10, 99)), "<05>", 1), (points((0, 0)) + position(2**31 - 1) + clock(1), "<01>", 0),
     )],
})  # fmt: skip
def test_decisions_numbers(script):
    play(script)


def test_o_names_the_shaft_and_keeps_the_following_error(bench):
    """O= gives the present *shaft* position its value; what the load has displaced is made up for as before."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "MP A=100 V=100 P=0 G", 0.2)
    motor.axes["shaft"].load(0.2)
    bench.run(0.01)
    error = value(bench, motor, "0-@P")
    assert error < -5
    send(bench, motor, "O=5000", 0)
    assert ask(bench, motor, "RP", 0) == "5000" and ask(bench, motor, "RPE", 0) == str(error)
    bench.run(1)
    assert ask(bench, motor, "RP", 0) == str(5000 + error) and motor.axes["shaft"].position == 0
