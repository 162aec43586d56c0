"""Begin and end of faults that are added from Python, from a conversation and from a recording."""

import pytest

from axistwin import Bench, play, recording
from axistwin.bench.faults import sentences
from axistwin.bench.talk.conversation import parse, write
from axistwin.core.errors import ProgramError, UsageError

from ..told import raises

START = "+1.5\n> (\n< U\\r\n> U61\\r\n+1.2\n"


@pytest.fixture
def bench():
    """Return a bench with an IF1 that has been initialised, at 9600 8N2."""
    bench = Bench()
    bench.add("if1", X={"limits": (-500, 5000)})
    assert play(parse(START), bench) is None
    return bench


@pytest.mark.parametrize(("when", "nth", "at_position"), [
    ("if1.X passes 100", 1, 100), ("if1.X passes 100", 2, 100), ("X passes 150 down", 1, 150),
    ("input2 rises", 1, 400), ("input2 falls", 1, 0), ("input2 changes", 2, 0), (r"if1 hears N\r", 1, 400),
    ("if1 says 00", 1, 400)])  # fmt: skip
def test_a_fault_begins_at_the_exact_time(bench, when, nth, at_position):
    axis = bench["if1"].axes["X"]
    fault = bench.faults.add("stuck", "input3", level="high", when=when, nth=nth, here="if1")
    found = []
    bench.faults.subscribe(lambda fault, what: found.append((what, axis.position)))
    where = f"; {when}\n> X400$\\r\n+3\n! input2 high\n> N\\r\n< 400\\r\n> X-$\\r\n+3\n! input2 low\n+1"
    assert play(parse(where), bench) is None and fault.on
    assert found[0][0] == "begins" and found[0][1] == at_position


def test_a_servo_passes_a_position_in_the_exact_sample():
    bench = Bench()
    motor = bench.add("smartmotor", shaft={"motor": "frame17"})
    fault = bench.faults.add("stuck", "smartmotor.E", level=False, when="smartmotor.shaft passes 777 up")
    positions = []
    motor.axes["shaft"].subscribe(
        lambda samples: positions.extend(zip(range(len(samples)), samples.positions, strict=True))
    )
    motor.serial.write(b"UCI UDI ZS MP A=100 V=100000 P=2000 G ")
    seen = []
    bench.faults.subscribe(lambda fault, what: seen.append(motor.axes["shaft"].position))
    bench.run(2.0)
    assert fault.on and max(at for _, at in positions if at < 777) < 777 <= seen[0]
    assert seen[0] == min(at for _, at in positions if at >= 777), "the first sample beyond it"


def test_at_a_time_and_for_a_time(bench):
    fault = bench.faults.add("stuck", "if1.input1", level=True, at=bench.seconds + 0.25, duration=0.5)
    levels = []
    bench["if1"].pins["input1"].subscribe(lambda pin: levels.append((bench.now - began, pin.level)))
    began = bench.now
    assert bench.clock.quiet, "nobody waits for a fault to come"
    bench.run(2)
    assert levels == [(250_000_000, True), (750_000_000, False)] and not fault.on


def test_a_time_and_an_event(bench):
    fault = bench.faults.add("jam", "if1.X", when="if1.input2 rises", at=bench.seconds + 1)
    assert play(parse("! input2 high\n+0.1\n! input2 low\n+1\n"), bench) is None
    assert not fault.on, "it did not count yet"
    assert play(parse("! input2 high\n+0.1\n"), bench) is None and fault.on


def test_a_fault_may_wait_for_another(bench):
    bench.faults.add("stuck", "if1.input1", name="switch", level=True, at=bench.seconds + 1, duration=1)
    then = bench.faults.add("jam", "if1.X", when="switch ends")
    bench.run(1.5)
    assert not then.on
    bench.run(1)
    assert then.on


def test_a_flag_of_the_device(bench):
    fault = bench.faults.add("jam", "if1.X", when="if1 raises limit")
    play(parse("> X-1000$\\r\n+5\n"), bench)
    assert fault.on and bench["if1"].pins["limit_minus"].level is False


def test_flags_of_a_board():
    bench = Bench()
    bench.add("1811", motor={"limits": (-100, 500), "encoder": {}})
    fault = bench.faults.add("jam", "1811", when="1811 raises plus_limit")
    heard = bench.faults.add("push", "1811.motor", counts=1, when="1811 hears 33 00")
    talk = "; model: 1811\n+1.1\n> default_velocity_and_acceleration 00 25000 250000\n> go_relative 25000\n+2"
    assert play(parse(talk), bench) is None and fault.on
    assert heard.began_ns is not None


def test_a_waiting_fault_can_be_cancelled(bench):
    fault = bench.faults.add("jam", "if1.X", when="if1.X passes 10")
    timed = bench.faults.add("stuck", "if1.input1", level=True, at=bench.seconds + 1)
    bench.faults.mend("all")
    play(parse("> X100$\\r\n+3\n"), bench)
    assert fault.began_ns is timed.began_ns is None
    assert bench["if1"].axes["X"].position == 100


@pytest.mark.parametrize(("words_", "message"), [
    ("los 3", "unknown kind of fault 'los': did you mean 'lose'?"),
    ("lose 3 4 5 6", "unexpected value '6' of the fault lose: leave out '6'"),
    ("lose serial count=x", "count='x': expected a whole number of characters, 1 or more"),
    ("lose speed=3", "fault lose has no parameter 'speed': expected count or probability or way"),
    ("stuck input1", "fault stuck needs the parameter level: expected high or low"),
    ("stuck low", "the fault stuck needs the name of a pin: expected e.g. if1.input1"),
    ("jam on=Q", "unknown axis 'Q': expected one of if1.X, if1.Y, if1.Z, X, Y, Z"),
    ("jam X when='X goes'",
     "invalid event when='X goes': expected e.g. 'if1.X passes 1000'; possible verbs are passes"),
    ("jam X when='X passes far'", "when='X passes far': expected e.g. 'X passes 1000'"),
    ("jam X when='switch ends'", "unknown fault 'switch': known faults are none"),
    ("jam X when='if1 raises Be'", "if1 has no fault flag 'Be': expected one of drive, emergency_stop, limit"),
    ("jam X at=soon", "invalid value at='soon': expected a number, e.g. at=1"),
    ("jam X duration=-1", "invalid duration=-1.0: expected a number of seconds, 0 or more"),
    ("break duration=1", "the fault break occurs only once and cannot have a duration: leave out `duration`"),
    ("jam X nth=0", "invalid nth=0: expected a whole number of 1 or more, e.g. nth=3"),
    ("overheat", "if1 is not a SmartMotor: expected the name"), ("jam 'X", "a quotation mark is missing"),
    ("lose count=1 count=2", "count is given twice")])  # fmt: skip
def test_invalid_faults_are_refused_before_they_are_added(bench, words_, message):
    with pytest.raises(UsageError) as told:
        sentences.read(words_, bench.faults, "if1")
    assert message in str(told.value)
    raises(ProgramError, "t.talk:2", play, parse(f"+1\n! fault {words_}\n", "t.talk"), bench)
    assert not list(bench.faults)


def test_a_time_that_has_passed_is_refused(bench):
    raises(UsageError, "the start time at=1 is in the past: expected 2.7", bench.faults.add, "jam", "if1.X", at=1)
    with pytest.raises(UsageError, match="there is a fault 'a' already"):
        _ = [bench.faults.add("jam", "if1.X", name="a", at=60) for _ in range(2)]


CONVERSATION = r"""
! fault lose 1
> NN\r
< 0\r
! fault flip mask=2 way=from
> N\r
< 2\r
! fault stuck input1 high name=switch
= input1 high
! mend switch
= input1 low
! fault jam X when="X passes 100" duration=0.5
> X1000$\r
+5
= X.pulses 1000
! fault power_cut duration=0.1
+2
> (
< U\r
"""


def test_faults_in_a_conversation():
    bench = Bench()
    bench.add("if1")
    assert play(parse(START + CONVERSATION, "c.talk"), bench) is None and bench["if1"].axes["X"].position < 1000


def test_a_recording_with_faults_can_be_replayed():
    def record(talk):
        bench = Bench()
        bench.add("if1")
        with recording(bench) as recorder:
            assert play(talk, bench) is None
        return write(recorder.conversation())

    first = record(parse(START + CONVERSATION))
    assert "! fault jam if1.X name=jam" in first and "! mend jam" in first
    assert record(parse(first)) == first


def test_faults_of_a_line_that_motors_share():
    bench = Bench()
    bench.chain(bench.add("smartmotor", "left"))
    talk = "+0.3\nchain: ! fault flip way=from\nleft: ! fault stuck A low\n"
    talk += "chain: > RP\\r\nchain: < \\x31\\r\n! fault jam left.shaft\n"
    assert play(parse(talk), bench) is None and [fault.name for fault in bench.faults] == ["flip", "stuck", "jam"]


def test_python_and_text_describe_the_same_faults(bench):
    added = bench.faults.add("flip", "if1.serial", count=2, mask=8, way="from", probability=0.5, seed=9)
    again = sentences.read(sentences.write(added).replace("name=flip", "name=other"), bench.faults)()
    assert (again.kind, again.spot.name, again.values, again.seed) == (
        added.kind, added.spot.name, added.values, added.seed,
    )  # fmt: skip
