"""Ports for hosts in a session: acts are recorded before they are performed, and can be repeated."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.core.errors import UsageError
from axistwin.scenes.sessions.recorded_port import RecordedBus, RecordedPort
from axistwin.sim.clock import Clock
from axistwin.sim.frames import UartFormat
from axistwin.sim.registers import CONTROL, DATA, NOBODY_DRIVES, Init, ReadData, RegisterPort, WriteRegister
from axistwin.sim.serial_port import X_OFF, X_ON, DropPending, Flow, Hold, SendBreak, SetFlow, SetFormat, SetLine, Write

from ..sim import test_serial_port as serial
from ..sim.test_serial_port import FORMAT, FRAME

SLOW = UartFormat(4800, 8, "N", 1)


class Device(serial.Device):
    """A device whose `port` is the recorded port of its host."""

    def __init__(self, instant=False):
        super().__init__(instant)
        self.raw, self.acts = self.port, []
        self.port = RecordedPort(self.raw, lambda act: self.acts.append((self.clock.now, act)))

    @property
    def recorded(self):
        return [act for _, act in self.acts]


def perform(port, act):
    match act:
        case Write(data):
            port.write(data)
        case SendBreak(seconds):
            port.send_break(seconds)
        case SetFormat(fmt):
            port.host.format = fmt
        case SetLine(line, on):
            setattr(port.host, line, on)
        case SetFlow(flow):
            port.flow = flow
        case Hold(on):
            port.held = on
        case DropPending():
            port.drop_pending()
        case WriteRegister(offset, value):
            port.write(offset, value)
        case ReadData():
            port.read(DATA)
        case Init():
            port.init()
        case _:
            raise AssertionError(act)


@pytest.fixture
def device():
    return Device()


@pytest.mark.parametrize(
    ("act", "state"),
    [
        (Write(b"ab"), lambda port: port.pending == 1),  # the first of two characters is being transmitted
        (SendBreak(0.002), lambda port: port.pending == 0),
        (Hold(True), lambda port: port.held),
        (SetFlow(Flow.DTR), lambda port: port.flow is Flow.DTR),
        (SetFormat(SLOW), lambda port: port.host.format == SLOW),
        (SetLine("dtr", False), lambda port: not port.host.dtr),
        (SetLine("rts", False), lambda port: not port.host.rts),
        (DropPending(), lambda port: port.pending == 0),
    ],
)
def test_each_act_of_a_host_is_recorded_and_performed(device, act, state):
    perform(device.port, act)
    assert device.recorded == [act] and state(device.port)
    assert state(device.raw)


def test_reading_received_characters_is_not_recorded(device):
    device.uart.send(b"a")
    device.run(1)
    assert (device.port.read(), device.acts) == (b"a", [])


def test_an_act_is_recorded_before_it_is_performed():
    device, seen = Device(instant=True), []
    port = RecordedPort(device.raw, lambda act: seen.append(device.heard))
    port.write(b"a")
    port.write(b"b")
    assert seen == [b"", b"a"]


def test_what_an_act_causes_at_once_is_not_recorded():
    device = Device(instant=True)
    device.uart.on_receive = lambda byte, errors: setattr(device.raw.host, "baudrate", 4800)
    device.port.write(b"a")
    device.port.host.dtr = False
    assert device.recorded == [Write(b"a"), SetLine("dtr", False)] and device.port.host.format == SLOW


def test_an_invalid_break_is_not_recorded(device):
    with pytest.raises(UsageError, match="expected 1 ns or more"):
        device.port.send_break(0)
    assert device.acts == []


ACTS = st.tuples(
    st.integers(0, 3 * FRAME),
    st.one_of(
        st.binary(min_size=1, max_size=4).map(Write),
        st.sampled_from([0.0005, 0.003]).map(SendBreak),
        st.booleans().map(Hold),
        st.sampled_from(Flow).map(SetFlow),
        st.sampled_from([SLOW, FORMAT]).map(SetFormat),
        st.booleans().map(lambda on: SetLine("dtr", on)),
        st.just(DropPending()),
    ),
)


@settings(max_examples=60, deadline=None)
@given(st.booleans(), st.lists(ACTS, max_size=12))
def test_recorded_acts_performed_again_at_their_times_are_the_same_run(instant, acts):
    """The device switches DTR off and on, and sends X_OFF and X_ON, so that flow control has an effect."""
    first = _moody(instant)
    for wait_ns, act in acts:
        first.clock.run_to(first.clock.now + wait_ns)
        perform(first.port, act)
    first.run(60)
    second = _moody(instant)
    for at_ns, act in first.acts:
        second.clock.run_to(at_ns)
        perform(second.raw, act)
    second.clock.run_to(first.clock.now)
    assert first.recorded == [act for _, act in acts]
    assert (second.heard, second.times, second.acts) == (first.heard, first.times, [])


def _moody(instant):
    device = Device(instant=instant)
    for frames, action in (
        (2, lambda: device.dtr.set(False)),
        (5, lambda: device.dtr.set(True)),
        (7, lambda: device.uart.send(bytes([X_OFF]))),
        (11, lambda: device.uart.send(bytes([X_ON]))),
    ):
        device.clock.call_later(frames * FRAME, action)
    return device


# Registers


class Board:
    """Registers, the bytes written to the control byte, and the recorded acts."""

    def __init__(self, powered=True):
        self.raw = RegisterPort(Clock())
        self.raw.powered = powered
        self.controls, self.acts = [], []
        self.raw.on_control = self.controls.append
        self.raw.on_init = lambda: self.controls.append("init")
        self.port = RecordedBus(self.raw, self.acts.append)


@pytest.fixture
def board():
    return Board()


def test_accesses_that_change_something_are_recorded_and_performed_again_they_are_the_same(board):
    again = Board()
    for one in (board, again):
        one.raw.output.load(b"xyz")
    board.port.write(DATA, 0x41)
    assert board.port.read(DATA) == ord("x")
    board.port.write(CONTROL, 0x10)
    board.port.init()
    assert board.acts == [WriteRegister(DATA, 0x41), ReadData(), WriteRegister(CONTROL, 0x10), Init()]
    for act in board.acts:
        perform(again.raw, act)
    assert (again.controls, again.acts) == ([0x10, "init"], [])
    assert (again.raw.input.contents, again.raw.output.contents) == (b"A", b"yz")


def test_reading_the_status_is_not_recorded(board):
    board.raw.status = 0x50
    assert (board.port.read(CONTROL), board.acts) == (0x50, [])


def test_at_a_board_without_power_nothing_is_recorded():
    board = Board(powered=False)
    board.port.write(DATA, 0x41)
    board.port.init()
    assert (board.port.read(DATA), board.acts) == (NOBODY_DRIVES, [])


@pytest.mark.parametrize("access", [(DATA, 256), (2, 0x41), (DATA, True)])
def test_an_invalid_access_is_not_recorded(board, access):
    with pytest.raises(UsageError, match=r"invalid (offset|value)"):
        board.port.write(*access)
    assert board.acts == []


def test_an_access_by_a_subscriber_to_the_status_belongs_to_the_act_that_changed_it(board):
    board.raw.on_control = lambda value: setattr(board.raw, "status", value)
    board.raw.status_changes.subscribe(lambda: board.raw.write(DATA, 0x42))
    board.port.write(CONTROL, 0x10)
    assert (board.acts, board.raw.input.contents) == ([WriteRegister(CONTROL, 0x10)], b"B")
