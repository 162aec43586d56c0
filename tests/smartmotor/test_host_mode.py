"""Chapter 10: host mode."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scenarios import clock, points, position, start_host_mode
from .scripts import play, scripts
from .talking import advance, positions, ready, send

# the example of 10.1, byte by byte
STROBED = bytes.fromhex(
    "FA 00 00 00 00 0D  FB 00 00 00 00 0D"
    "FA 00 00 10 00 0D  FB 00 00 01 00 0D"
    "FA 00 00 20 00 0D"
    "FA 00 00 30 00 0D"
    "FA 00 00 34 00 0D  FB 00 00 03 40 0D"
    "FA 00 00 38 00 0D"
    "FA 00 00 3C 00 0D"
    "FA 00 00 40 00 0D"
).decode("latin-1")
ONE_SEGMENT = points((0, 0), (64, 256))  # a quarter of a count per sample


ANY_BYTE = (0, 0), (0x0D0D, 0x0D0D), (0x2020, 0x2020), (0xFAFB, 0xFAFB), (0x80FF, 0x180FF)
"""Positions and clocks with CR, blank, FAh, FBh and addresses."""


@scripts({
    # What a record is
    "Reports are answered between two records on the same line":
    f"O=0 MD; {points((0, 0), (100, 100))}; G; 50 samples; "
    f"{position(200)}RP {clock(200)}RMODE {clock(200)}RP -> 50 H 50; 150 samples; at 200; RMODE RBs -> P 0",
    "10.2: \"MD 'buffer host mode\"; \"G 'begin host mode\"":
    f"A=65536 V=65536 MV G MD {ONE_SEGMENT}; positions 1 2 3; RMODE -> V; G; RMODE -> H",
    # Underflow
    '10.2: "stop sending data points to host mode, resulting in host mode data underflow ... losing control"; '
    "on 4.76 the mode torque brake follows (5.2), so that RMODE says B":
    f"O=0 MD; {ONE_SEGMENT}; G; 256 samples; at 64; 2 samples; RMODE RBo RBt RV -> B 1 0 0; 100 steps of 0; "
    "at 64",
    "10.2: G without a segment is an underflow at once; the motor still executes commands":
    [f"O=0 MD; {records}; G; 2 samples; RMODE RBo -> B 1" for records in ("", position(0), points((0, 0)))],
    # 10.2 Orderly exit
    '10.2: "If host mode position-time data ended with the motor at zero velocity ... motor will servo at the '
    'final host mode position"; the position of the duplicated clock value is ignored':
    f"O=0 MP A=2 V=10000 D=0 MD; {points((0, 0), (64, 256), (64, 512), (9999, 512))}; G; 512 samples; "
    "100 steps of 0; at 64; RMODE RBt RBo RV -> R 0 0 0",
    "10.2: MFR, MF_n, MSR and MS follow the external counter from the latched position":
    [f"O=0 {mode}MD; {ONE_SEGMENT}{clock(256)}; G; 256 samples; RMODE -> {letter}; 5 samples; at 64; "
     f"turn 100 by 1: {64 + followed}"
     for mode, letter, followed in (
         ("MF1 ", "F", 25), ("MF2 ", "F", 50), ("MF4 ", "F", 100), ("MF4 MFMUL=3 MFDIV=2 MFR ", "X", 150),
         ("MS ", "S", 100), ("MS0 MFMUL=3 MFDIV=2 MSR ", "X", 150),
     )],
    '10.2, another exit from host mode: "send a G command ... to execute the next buffered mode"':
    f"O=0 MP A=65536 V=65536 MD; {points((0, 0), (1000, 1000))}; G; 100 samples; P=110 G RMODE -> P; "
    "positions 101 102 103 104 105 106 107 108 109 110 110 110 110 110 110",
    "A late record has no effect on velocity mode, and none of its bytes becomes a command":
    f"O=0 MV V=65536 A=1 MD; {points((0, 0), (10, 10))}{clock(10)}; G; 20 samples; "
    f"{points((0, 0), (1394627360, 20))}RMODE -> V; positions 21 22 23 24 25",
    "A program sends MD and G; the host sends the records while the program runs":
    "load O=0 / MV / V=65536 / A=100 / MD / WAIT=100 / G / END; RUN; 20 samples; "
    f"{points((0, 0), (100, 100))}{clock(100)}; 400 samples; RMODE RV -> V 65536",
    # Beyond
    "a power cut forgets the records":
    f"O=0 MD; {points((0, 0), (1000, 1000))}; G; 100 samples; power cycle; 0.5 s; RMODE UCI UDI ZS MD G -> B; "
    "10 samples; at 100; RMODE -> B",
    # 10.1 Automatic strobing
    "10.1: the speed is constant, 4096 counts in 256 samples, also in the strobed segments up to clock 400h":
    f"O=0 MD; {STROBED}; G; positions 16; 1023 steps of 16",
    '10.1: "the SmartMotor will calculate the time value automatically, by using the previous time delta"':
    f"O=0 MD; {points(*((16 * at, at) for at in [0, 256, 512, 768, 832, 896, 960, 1024]))}; G; positions 16; "
    "1023 steps of 16",
    '10.1: "Having sent the first two times, time values may be sent or omitted at will"':
    "O=0 MV V=65536 A=1 MD; "
    f"{points((0, 0), (10, 10))}{position(20)}{points((60, 60))}{position(100)}{points((111, 111))}{position(112)}"
    f"{clock(112)}{clock(112)}; "
    "G; positions 1; 129 steps of 1",
    # What a record is
    "10.1: CR, blank, FAh, FBh and addresses inside a record are data":
    f"O=0 MD; {points(*ANY_BYTE)}{clock(0x180FF)}; G; "
    + "; ".join(f"{at - before} samples; at {place}" for (_, before), (place, at) in pairwise(ANY_BYTE))
    + "; RMODE RBs -> P 0",
    "positions are signed":
    f"O=0 MD; {points((0, 0), (-257, 257))}{clock(257)}; G; positions -1; 256 steps of -1",
    # Underflow
    "after underflow a move and another host mode are possible":
    f"O=0 MD; {ONE_SEGMENT}; G; 300 samples; ZS MP A=65536 V=65536 P=70 G; 20 samples; at 70; O=0 P=10 MD; "
    f"{points((0, 0), (10, 10))}{clock(10)}; G; 9 samples; positions 80 80; RMODE RP -> P 10",
    # 10.2 Orderly exit
    '10.2: "host mode transitioned to velocity mode, maintaining constant velocity each Sample"':
    f"O=0 MV V=4*65536 A=100 MD; {points((0, 0), (1024, 256))}{clock(256)}; G; positions 4; 599 steps of 4; "
    "RMODE RV -> V 262144",
    '10.2: "MP P=expression (absolute)": from 1 count per sample on to 300, at V=2':
    f"O=0 MP A=65536 V=2*65536 P=300 MD; {points((0, 0), (100, 100))}{clock(100)}; G; 100 samples; RMODE -> P; "
    "positions 102 104 106; 98 samples; at 300",
    '10.2: "MP D=expression (relative)": 50 counts beyond the latched position':
    f"O=0 MP A=65536 V=65536 D=50 MD; {points((0, 0), (100, 100))}{clock(100)}; G; positions 1; 149 steps of 1; "
    "10 steps of 0; RMODE RBt -> R 0",
    "10.2: velocity mode ramps from the latched trajectory velocity to the buffered V with the buffered A":
    f"O=0 MV A=65536 V=5*65536 MD; {points((0, 0), (200, 100))}{clock(100)}; G; 99 samples; "
    "positions 200 203 207 212 217 222",
    # 10.1 Automatic strobing
    "The delta is 100 samples throughout: 1, 3, 0 and -2 counts per sample":
    f"O=0 MD; {points((0, 0), (100, 100))}{position(400)}{position(400)}{position(200)}{clock(400)}{clock(400)}; "
    "G; "
    "100 steps of 1; 100 steps of 3; 100 steps of 0; 100 steps of -2",
    # 10.2 Orderly exit
    "4: S, OFF and MTB stop host mode at once; X stops it at A, here in one sample":
    [f"O=0 A=65536 MD; {points((0, 0), (1000, 1000))}; G; 100 samples; {word}; 3 steps of 0; at 100; "
     f"RMODE -> {mode}"
     for word, mode in (("S", "P"), ("X", "P"), ("OFF", "B"), ("MTB", "B"))],
    "11: the option host_buffer sets how many points are kept; further points are lost and set Bc":
    f"with host_buffer=4; O=0 MD; {points(*((10 * at, 10 * at) for at in range(8)))}; G; RBc -> 1; 30 steps of 1; "
    "70 steps of 0",
})  # fmt: skip
def test_host_mode(script):
    play(script)


# 10.1 Automatic strobing


@pytest.mark.parametrize("baudrate", [9600, 38400])
def test_the_example_at_the_speed_of_a_line(bench, baudrate):
    """10.1 at 9600 baud, during the motion: 42 characters take 44 ms, and the first segment lasts 63 ms."""
    motor = ready(bench, line="9600 8N1")
    motor.serial.write(b"O=0 MD BAUD%d " % baudrate)
    bench.run(0.2)
    motor.serial.host.baudrate = baudrate
    motor.serial.write(STROBED[:24].encode("latin-1") + b"G " + STROBED[24:].encode("latin-1"))
    assert bench.run_until(lambda: motor.axes["shaft"].position == 0x4000, 1.0) and motor.serial.read() == b""


# What a record is


def test_a_segment_that_is_not_a_whole_number_of_counts_per_sample(bench, motor):
    """Between its ends a segment is linear in time: 3 counts in 16 samples, to within a count."""
    start_host_mode(bench, motor, "O=0 ", points((0, 0), (3, 16), (3, 64)))
    for at, where in enumerate(positions(bench, motor, 20), 1):
        assert 0 <= min(3 * at, 48) - 16 * where < 16


# 10.2 Orderly exit


def test_the_example_of_servo_in_place_with_a_velocity(bench, motor):
    """10.2: "decelerate to a stop at acceleration A=2; then return to the final host mode position in a trapezoidal
    trajectory governed by A=2, V=10000; and finally servo in place at the final host mode position"."""
    start_host_mode(bench, motor, "O=0 MP A=2 V=10000 D=0 ", ONE_SEGMENT + points((9999, 256)))
    positions(bench, motor, 256)
    found = positions(bench, motor, 8192)
    assert found == decelerating(start=64 << 16, velocity=16_384, a=2) and found[-1] == 1087
    back = positions(bench, motor, 15_000)
    assert back == sorted(back, reverse=True)
    steps = {before - after for before, after in pairwise(back)}
    assert steps == {0, 1}  # V is less than a count per sample
    assert back[-1] == 64 and send(bench, motor, "RMODE RBt RBo", 0) == b"R\r0\r0\r"


def decelerating(start, velocity, a):
    """Return the position in counts at each sample until the velocity is 0."""
    found = []
    while velocity:
        velocity -= a
        start += velocity
        found.append(start >> 16)
    return found


# Beyond


RECORDS = st.one_of(
    st.tuples(st.integers(-2000, 2000), st.integers(0, 300)).map(lambda pair: points(pair)),
    st.integers(-(2**31), 2**31 - 1).map(position),
    st.integers(0, 2**32 - 1).map(clock),
    st.sampled_from(["G ", "MD ", "RMODE ", "MP ", "X ", "MV V=1 A=1 ", "MF4 ", "O=7 ", "ZS "]),
    st.binary(max_size=8).map(lambda data: data.decode("latin-1")),
)


@settings(deadline=None, max_examples=20)
@given(said=st.lists(RECORDS, max_size=12))
def test_any_records_and_commands_leave_the_motor_operable(said):
    """Records, commands and invalid text in any order: the motor answers, and a repeated run gives the same result."""
    first = after_rubbish("".join(said))
    assert first == after_rubbish("".join(said)) and first[-1:] == b"\r"


def after_rubbish(words):
    bench = Bench()
    motor = ready(bench)
    send(bench, motor, "MD " + ONE_SEGMENT + "G " + words, 0)
    advance(bench, 400)
    motor.serial.write(b"\r\r\r\r\r\r\x80\rTALK WAKE ")
    bench.run(6)
    motor.serial.read()
    return send(bench, motor, "RMODE RP RCTR", 0)
