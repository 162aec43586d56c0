"""RFC 2217 byte by byte, without sockets."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.links.comport import ComPort, Control, Purge, SetBreak, SetFlow, SetLines, Suspend
from axistwin.links.telnet import escape
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.serial_port import SetFormat

WILL, WONT, DO, DONT = (bytes((0xFF, verb)) for verb in (0xFB, 0xFC, 0xFD, 0xFE))
BINARY, ECHO, SGA, STATUS, COM_PORT = (bytes((option,)) for option in (0, 1, 3, 5, 44))
USUAL = UartFormat(9600, 8, "N", 2)


def sub(code, value=b""):
    """Return a command or an answer as bytes on the connection."""
    return b"\xff\xfa\x2c" + bytes((code,)) + value.replace(b"\xff", b"\xff\xff") + b"\xff\xf0"


@pytest.fixture
def port():
    """Return a port whose client has negotiated RFC 2217."""
    port = ComPort(USUAL, "axistwin if1")
    port.set_modem_state(dsr=True, cts=False)
    port.receive(WILL + COM_PORT)
    port.take_replies()
    return port


def say(port, data):
    return port.receive(data), port.take_replies()


# Negotiation


@pytest.mark.parametrize(("asked", "answer"), [
    (DO + BINARY, WILL + BINARY), (DO + ECHO, WILL + ECHO), (DO + SGA, WILL + SGA), (DO + STATUS, WONT + STATUS),
    (WILL + BINARY, DO + BINARY), (WILL + SGA, DO + SGA), (WILL + ECHO, DONT + ECHO), (WILL + STATUS, DONT + STATUS),
    (DONT + BINARY, b""), (WONT + BINARY, b""), (DO + BINARY + DO + BINARY, WILL + BINARY),
    (DO + BINARY + DONT + BINARY, WILL + BINARY + WONT + BINARY),
    (WILL + BINARY + WONT + BINARY, DO + BINARY + DONT + BINARY)])  # fmt: skip
def test_an_option_is_answered_when_it_changes(asked, answer):
    assert say(ComPort(USUAL, ""), asked) == ([], answer)


@pytest.mark.parametrize(("asked", "answer"), [(WILL, DO), (DO, WILL)])
def test_whoever_agrees_on_com_port_control_is_told_the_control_lines(asked, answer):
    """A client that agrees to COM port control receives the control lines, even if the client has sent DO first."""
    port = ComPort(USUAL, "")
    port.set_modem_state(dsr=True, cts=True)
    assert port.take_replies() == b"" and say(port, asked + COM_PORT) == ([], answer + COM_PORT + sub(107, b"\x30"))


def test_nothing_is_told_to_a_client_that_does_not_speak_rfc_2217():
    port = ComPort(USUAL, "")
    port.set_modem_state(dsr=True, cts=True)
    port.set_line_state(LineError.FRAMING)
    assert say(port, b"E\r") == ([b"E\r"], b"")


# Data


def test_data_is_passed_on_with_doubled_iac_undone(port):
    assert say(port, b"a\xff\xffb") == ([b"a\xffb"], b"")


def test_data_to_the_client_has_its_iac_doubled():
    assert escape(b"a\xffb") == b"a\xff\xffb"


# Commands: bytes sent, event, answer


@pytest.mark.parametrize(
    ("code", "value", "event", "answer"),
    [
        (1, b"\x00\x00\x04\xb0", SetFormat(UartFormat(1200, 8, "N", 2)), b"\x00\x00\x04\xb0"),
        (1, b"\x00\x00\x25\xff", SetFormat(UartFormat(9727, 8, "N", 2)), b"\x00\x00\x25\xff"),
        (1, bytes(4), None, b"\x00\x00\x25\x80"),  # a query of the baud rate
        (1, b"\x00\xb7\x1b\x01", None, b"\x00\x00\x25\x80"),  # 12,000,001 baud, above any UART
        (1, b"\x04\xb0", None, b"\x00\x00\x25\x80"),
        (2, b"\x07", SetFormat(UartFormat(9600, 7, "N", 2)), b"\x07"),
        (2, b"\x00", None, b"\x08"),
        (2, b"\x09", None, b"\x08"),
        (3, b"\x01", SetFormat(UartFormat(9600, 8, "N", 2)), b"\x01"),
        (3, b"\x02", SetFormat(UartFormat(9600, 8, "O", 2)), b"\x02"),
        (3, b"\x03", SetFormat(UartFormat(9600, 8, "E", 2)), b"\x03"),
        (3, b"\x04", SetFormat(UartFormat(9600, 8, "M", 2)), b"\x04"),
        (3, b"\x05", SetFormat(UartFormat(9600, 8, "S", 2)), b"\x05"),
        (3, b"\x00", None, b"\x01"),
        (4, b"\x01", SetFormat(UartFormat(9600, 8, "N", 1)), b"\x01"),
        (4, b"\x02", SetFormat(UartFormat(9600, 8, "N", 2)), b"\x02"),
        (4, b"\x03", SetFormat(UartFormat(9600, 8, "N", 1.5)), b"\x03"),
        (4, b"\x00", None, b"\x02"),
        (5, b"\x00", None, b"\x01"),
        (5, b"\x01", SetFlow(Control.FLOW_NONE), b"\x01"),
        (5, b"\x02", SetFlow(Control.FLOW_X_ON_X_OFF), b"\x02"),
        (5, b"\x03", SetFlow(Control.FLOW_HARDWARE), b"\x03"),
        (5, b"\x04", None, b"\x06"),
        (5, b"\x05", SetBreak(True), b"\x05"),
        (5, b"\x06", SetBreak(False), b"\x06"),
        (5, b"\x07", None, b"\x08"),
        (5, b"\x08", SetLines(dtr=True, rts=True), b"\x08"),
        (5, b"\x09", SetLines(dtr=False, rts=True), b"\x09"),
        (5, b"\x0a", None, b"\x0b"),
        (5, b"\x0b", SetLines(dtr=True, rts=True), b"\x0b"),
        (5, b"\x0c", SetLines(dtr=True, rts=False), b"\x0c"),
        (5, b"\x0d", None, b"\x0e"),
        (5, b"\x0e", None, b"\x0e"),
        (5, b"\x0f", None, b"\x0f"),
        (5, b"\x10", None, b"\x10"),
        (5, b"\x11", None, b"\x01"),  # DCD flow control: there is no DCD
        (5, b"\x12", None, b"\x12"),
        (5, b"\x13", SetFlow(Control.FLOW_DSR), b"\x13"),
        (10, b"\x0c", None, b"\x0c"),
        (12, b"\x01", Purge(received=True, to_transmit=False), b"\x01"),
        (12, b"\x02", Purge(received=False, to_transmit=True), b"\x02"),
        (12, b"\x03", Purge(received=True, to_transmit=True), b"\x03"),
    ],
)
def test_a_command_is_answered_with_what_is_in_force(port, code, value, event, answer):
    assert say(port, sub(code, value)) == ([] if event is None else [event], sub(code + 100, answer))


@pytest.mark.parametrize("data", [sub(5), sub(5, b"\x14"), sub(12, b"\x04"), sub(12), sub(13), sub(255), sub(0, b"me")])
def test_what_makes_no_sense_is_ignored(port, data):
    assert say(port, data) == ([], b"")


def test_a_client_is_told_whom_it_speaks_to(port):
    assert say(port, sub(0)) == ([], sub(100, b"axistwin if1"))


def test_suspending_and_resuming_are_not_answered(port):
    assert say(port, sub(8) + sub(9)) == ([Suspend(True), Suspend(False)], b"")


def test_what_is_set_is_told_when_asked(port):
    for value in (b"\x05", b"\x09", b"\x0c", b"\x03"):
        say(port, sub(5, value))
    queries = b"".join(sub(5, bytes((value,))) for value in (0, 4, 7, 10, 13))
    assert say(port, queries)[1] == b"".join(sub(105, bytes((value,))) for value in (3, 5, 9, 12, 16))


def test_a_longer_talk_is_obeyed_in_order(port):
    events, _ = say(port, b"(" + sub(1, b"\x00\x00\x09\x60") + b"U61\r" + sub(5, b"\x09"))
    assert events == [b"(", SetFormat(UartFormat(2400, 8, "N", 2)), b"U61\r", SetLines(dtr=False, rts=True)]


# Notifications of the server


def test_a_change_of_a_control_line_is_told_with_its_delta(port):
    port.set_modem_state(dsr=False, cts=False)
    assert port.take_replies() == sub(107, b"\x02")
    port.set_modem_state(dsr=False, cts=True)
    assert port.take_replies() == sub(107, b"\x11")
    port.set_modem_state(dsr=False, cts=True)
    assert port.take_replies() == b""


def test_a_line_that_moved_and_is_back_shows_in_the_delta(port):
    from axistwin.links.comport import ModemState

    port.set_modem_state(dsr=True, cts=False, moved=ModemState.CTS_CHANGED)
    assert port.take_replies() == sub(107, b"\x21")


def test_the_mask_chooses_which_changes_are_told(port):
    assert say(port, sub(11, b"\x22")) == ([], sub(111, b"\x22") + sub(107, b"\x20"))
    port.set_modem_state(dsr=True, cts=True)
    assert port.take_replies() == b""
    port.set_modem_state(dsr=False, cts=True)
    assert port.take_replies() == sub(107, b"\x02")


def test_the_control_lines_are_told_when_asked(port):
    assert say(port, sub(7)) == ([], sub(107, b"\x20"))


@pytest.mark.parametrize(("errors", "mask", "told"), [
    (LineError.PARITY, 0x04, sub(106, b"\x64")), (LineError.FRAMING, 0x08, sub(106, b"\x68")),
    (LineError.FRAMING | LineError.BREAK, 0x10, sub(106, b"\x78")), (LineError.PARITY, 0x18, b""),
    (LineError.NONE, 0xFF, b"")])  # fmt: skip
def test_a_line_error_is_told_if_the_client_wants_to_know(port, errors, mask, told):
    say(port, sub(10, bytes((mask,))))
    port.set_line_state(errors)
    assert port.take_replies() == told


def test_the_last_line_error_is_told_once_when_asked(port):
    port.set_line_state(LineError.PARITY)
    assert say(port, sub(6)) == ([], sub(106, b"\x64")) and say(port, sub(6)) == ([], sub(106, b"\x60"))


# Properties

TALK = st.lists(
    st.one_of(
        st.binary(max_size=6),
        st.builds(sub, st.integers(0, 14), st.binary(max_size=5)),
        st.builds(
            lambda verb, option: verb + bytes((option,)), st.sampled_from([WILL, WONT, DO, DONT]), st.integers(0, 50)
        ),
    )
).map(b"".join)


@settings(max_examples=50)
@given(TALK)
def test_fed_whole_or_byte_by_byte_the_client_gets_the_same_answers(data):
    whole, slow = ComPort(USUAL, "x"), ComPort(USUAL, "x")
    events = whole.receive(data)
    slow_events = [event for byte in data for event in slow.receive(bytes([byte]))]
    assert slow.take_replies() == whole.take_replies()
    assert [e for e in slow_events if not isinstance(e, bytes)] == [e for e in events if not isinstance(e, bytes)]
    assert b"".join(e for e in slow_events if isinstance(e, bytes)) == b"".join(
        e for e in events if isinstance(e, bytes)
    )
