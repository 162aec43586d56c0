"""Chapter 10: long streams of host mode records, at line speed, with a real motor, and in pieces."""

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scenarios import clock, points, position, start_host_mode
from .scripts import play, scripts
from .talking import SAMPLE_NS, advance, positions, ready, send

SEGMENTS = st.lists(st.tuples(st.sampled_from([1, 7, 16, 64, 100]), st.integers(-500, 500)), min_size=1, max_size=12)


def records_of(segments, omit):
    """Return the records and the position at each clock; `omit` allows to leave out clocks that repeat the delta."""
    words, at, where, last, stations = points((0, 0)), 0, 0, 0, {}
    for (samples, way), left_out in zip(segments, omit, strict=False):
        at, where = at + samples, where + way
        stations[at] = where
        words += position(where) + ("" if left_out and last == samples else clock(at))
        last = samples
    return words + clock(at) + clock(at), stations


@scripts({
    "10.2, relative distance: G makes the exit's own move, and another G repeats it":
    f"O=0 MP A=65536000 V=65536000 D=50 MD; {points((0, 0), (100, 100))}{clock(100)}; G; 102 samples; at 150; "
    "G; 3 samples; at 200",
    '7.1, F=2: "the motor shaft will physically spin in the opposite direction for any given mode"':
    f"F=2 O=0 MV V=65536 A=100 MD; {points((0, 0), (100, 100))}{clock(100)}; G; positions -1; 149 steps of -1; "
    "RP RV -> 150 65536",
    "Each host mode has its own clock and begins at its first pair":
    f"O=0 MV V=65536 A=100 MD; {points((0, 0), (10, 10))}{clock(10)}; G; 20 samples; at 20; MD; "
    f"{points((20, 5000), (40, 5010), (60, 5020), (70, 5030))}{clock(5030)}; G; positions 22; 19 steps of 2; "
    "20 steps of 1",
    "10.2: the position is ignored also when the clock before has been omitted, and when more records follow":
    [f"O=0 MV V=0 A=65536000 MD; {records}; G; positions 1; 127 steps of 1; 72 steps of 0; RMODE RBs -> V 0"
     for records in (
         points((0, 0), (64, 64)) + position(128) + points((9, 128)),
         points((0, 0), (64, 64), (128, 128), (9, 128), (500, 600)),
         points((0, 0), (64, 64), (128, 128)) + clock(128) + points((500, 600)),
     )],
})  # fmt: skip
def test_host_streams(script):
    play(script)


@settings(deadline=None, max_examples=30)
@given(segments=SEGMENTS, omit=st.lists(st.booleans(), min_size=12, max_size=12))
def test_any_stream_is_followed_to_the_count(segments, omit):
    """10.1: positions are exact at each clock, and within a count of a straight line between clocks."""
    bench = Bench()
    motor = ready(bench)
    advance(bench)
    words, stations = records_of(segments, omit)
    start_host_mode(bench, motor, "O=0 MP A=65536000 V=0 ", words)
    found = [0, *positions(bench, motor, max(stations))]
    at, where = 0, 0
    for end, goal in stations.items():
        assert found[end] == goal
        for sample in range(at, end):
            assert abs((found[sample] - where) * (end - at) - (goal - where) * (sample - at)) <= end - at
        at, where = end, goal
    assert send(bench, motor, "RMODE RBs RBo", 0) == b"P\r0\r0\r"


@settings(deadline=None, max_examples=10)
@given(segments=SEGMENTS, cut=st.lists(st.integers(1, 40), min_size=1, max_size=8))
def test_a_stream_in_pieces_is_the_same_stream(segments, cut):
    """Any grouping of bytes and division of time gives the same path."""
    words, _ = records_of(segments, [True] * 12)
    assert streamed(words, [len(words)], 1) == streamed(words, cut, 3)


def streamed(words, cut, pieces):
    bench = Bench()
    motor = ready(bench)
    advance(bench)
    assert send(bench, motor, "O=0 MV V=65536 A=65536 MD", 0) == b""
    rest, turn = words, 0
    while rest:
        size = cut[turn % len(cut)]
        motor.serial.write(rest[:size].encode("latin-1"))
        rest, turn = rest[size:], turn + 1
    send(bench, motor, "G", 0)
    found = []
    for _ in range(300):
        for piece in range(pieces):
            bench.clock.run_to(bench.now + (SAMPLE_NS - bench.now % SAMPLE_NS) // (pieces - piece))
        found.append(motor.axes["shaft"].position)
    return found


def test_a_stream_at_9600_baud_is_fed_while_it_runs(bench):
    """10.1: without clocks a segment needs 6 characters, 6.25 ms; its 256 samples last 62.9 ms."""
    motor = ready(bench, line="9600 8N1")
    words = "O=0 MV V=65536 A=100 MD " + points((0, 0), (256, 256)) + "G "
    words += "".join(position(256 * index) for index in range(2, 30)) + clock(256 * 29) + clock(256 * 29)
    motor.serial.write(words.encode("latin-1"))
    assert bench.run_until(lambda: motor.axes["shaft"].position == 10, 1.0)
    began = bench.now
    for _ in range(20):
        bench.clock.run_to(bench.now + 350 * SAMPLE_NS)
        assert motor.axes["shaft"].position - 10 == (bench.now - began) // SAMPLE_NS
    assert motor.serial.read() == b""
    bench.run(0.5)
    motor.serial.write(b"RMODE RV RBo ")
    bench.run(0.1)
    assert motor.serial.read() == b"V\r65536\r0\r"


def test_a_line_that_is_too_slow_underflows(bench):
    """10.1: a record takes 6.25 ms, but its 16 samples last only 3.9 ms: an underflow."""
    motor = ready(bench, line="9600 8N1")
    words = "O=0 MD " + points((0, 0), (16, 16)) + "G " + "".join(position(16 * index) for index in range(2, 60))
    motor.serial.write(words.encode("latin-1"))
    bench.run(2)
    motor.serial.write(b"RMODE RBo ")
    bench.run(0.1)
    assert motor.serial.read() == b"B\r1\r" and motor.axes["shaft"].position < 16 * 59


def test_a_real_motor_keeps_its_velocity_through_the_exit(bench):
    """10.2: "allow exit from host mode at a non-zero velocity while maintaining position and velocity control"."""
    motor = ready(bench, shaft={"motor": "frame23"})
    advance(bench)
    start_host_mode(bench, motor, "O=0 MV V=4*65536 A=100 ", points((0, 0), (0x1000, 0x400)) + clock(0x400))
    shaft = motor.axes["shaft"]
    advance(bench, 0x300)
    assert shaft.commanded == 4 * 0x300
    lag = shaft.commanded - shaft.position
    for sample in range(0x301, 0x600):
        advance(bench)
        assert shaft.commanded == 4 * sample and abs(shaft.commanded - shaft.position - lag) <= 4
    assert send(bench, motor, "RMODE RV RBe", 0) == b"V\r262144\r0\r"


def test_a_limit_in_the_middle_stops_it(bench, motor):
    """3.2: a limit ends the motion; later records have no effect; after ZS host mode can begin again."""
    motor.pins["C"].drive(False)
    send(bench, motor, "UCP ZS", 0)
    start_host_mode(bench, motor, "O=0 ", points((0, 0), (1000, 1000)))
    positions(bench, motor, 100)
    motor.pins["C"].drive(True)
    advance(bench, 50)
    here = motor.axes["shaft"].position
    assert 100 <= here < 110
    send(bench, motor, points((2000, 2000)), 0)
    assert send(bench, motor, "RMODE RBr RBo", 0) == b"B\r1\r1\r"
    motor.pins["C"].drive(False)
    advance(bench, 50)
    send(bench, motor, "ZS", 0)
    start_host_mode(bench, motor, "O=0 MV V=0 A=65536000 ", points((0, 0), (10, 10), (10, 20)) + clock(20))
    assert positions(bench, motor, 30)[-1] == here + 10
