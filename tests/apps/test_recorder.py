"""What is recorded can be played, and is the same to the nanosecond."""

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.apps.conversations.conversation import Conversation, Do, Expect, Hear, parse, write
from axistwin.apps.conversations.player import play
from axistwin.apps.conversations.recorder import recording


def replayed(conversation: Conversation) -> object:
    """Write it, read it, and play it on a new bench with the same controllers."""
    bench = Bench()
    bench.add("if1")
    return play(parse(write(conversation.acts)), bench)


def recorded(*doings) -> Conversation:
    """What is recorded while these things are done with a bench and an IF1, half a second apart."""
    bench = Bench()
    if1 = bench.add("if1")
    with recording(bench) as recorder:
        bench.run(1.5)
        for doing in doings:
            doing(if1)
            bench.run(0.5)
    return recorder.conversation()


def write_bytes(data: bytes):
    return lambda if1: if1.serial.write(data)


READY = (write_bytes(b"("), write_bytes(b"U61\r"), lambda _: None, lambda _: None)


def test_a_session():
    conversation = recorded(*READY, write_bytes(b"X100$\r"), write_bytes(b"E\r"))
    assert write(conversation.acts) == (
        "; model: if1\n"
        "+1.5\n"
        "> (\n"
        "< U\\r\n"
        "= clock 1.503229167\n"
        "+0.496770833\n"
        "> U61\\r\n"
        "+1.5\n"
        "> X100$\\r\n"
        "+0.5\n"
        "> E\\r\n"
        "< C\\r\n"
        "= clock 4.005187500\n"
        "+0.4948125\n"
        "= X.position 100\n"
    )
    assert replayed(conversation) is None


def test_a_replay_notices_a_nanosecond():
    text = write(recorded(write_bytes(b"(")).acts).replace("1.503229167", "1.503229168")
    bench = Bench()
    bench.add("if1")
    assert "clock is different" in str(play(parse(text), bench))


def test_pins_that_somebody_drives_are_acts_and_those_the_controller_sets_are_not():
    conversation = recorded(
        *READY,
        lambda if1: if1.pins["input1"].drive(True),
        write_bytes(b"S1$\r"),
        lambda if1: if1.pins["input1"].release(),
    )
    assert [act for act in conversation.acts if isinstance(act, Do)] == [Do("input1", "high"), Do("input1", "release")]
    assert replayed(conversation) is None


def test_the_hosts_lines_and_its_format_are_acts():
    def changed(if1):
        if1.serial.host.baudrate = 1200
        if1.serial.host.rts = False

    conversation = recorded(changed, write_bytes(b"("), lambda if1: if1.serial.host.rts_line.set(True))
    assert [act for act in conversation.acts if isinstance(act, Do)] == [
        Do("rts", "low"), Do("line", "1200 8N2"), Do("rts", "high"),
    ]  # fmt: skip
    assert replayed(conversation) is None


def test_a_break_is_an_act():
    conversation = recorded(*READY, lambda if1: if1.serial.send_break(0.25), write_bytes(b"F\r"))
    assert [act for act in conversation.acts if isinstance(act, Do)] == [Do("break", "0.250000000")]
    assert replayed(conversation) is None


def test_a_long_silence_before_an_answer_is_told():
    bench = Bench()
    if1 = bench.add("if1")
    with recording(bench) as recorder:
        for text, seconds in (("", 1.5), ("(", 0.5), ("U61\r", 1.5), (":P0,99:=29,1:%:$\r", 40.0)):
            if1.serial.write(text.encode())
            bench.run(seconds)
    text = write(recorder.conversation().acts)
    assert "\n+28\n< %\\r\n" in text
    assert replayed(recorder.conversation()) is None


def test_with_two_controllers_each_line_says_which():
    bench = Bench()
    for name in ("left", "right"):
        bench.add("if1", name)
    with recording(bench) as recorder:
        bench.run(1.5)
        bench["left"].serial.write(b"(")
        bench["right"].serial.write(b"(")
        bench.run(0.1)
    heard = [act for act in recorder.conversation().acts if isinstance(act, Hear)]
    assert {(act.controller) for act in heard} == {"left", "right"}
    assert all(not act.controller for act in recorder.conversation().acts if isinstance(act, Expect))
    again = Bench()
    for name in ("left", "right"):
        again.add("if1", name)
    assert play(recorder.conversation(), again) is None


@settings(max_examples=25, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=12), st.sampled_from([b"X50$\r", b"E\r", b"#\r", b"N\r"])), max_size=6))
def test_whatever_a_host_says_can_be_replayed(messages):
    assert replayed(recorded(*READY, *map(write_bytes, messages))) is None
