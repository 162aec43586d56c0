"""The host's end of a serial line: what holds its characters back, and who is told of what it does."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.frames import UartFormat
from axistwin.sim.host_acts import HostAct
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import X_OFF, X_ON, Flow, SerialPort
from axistwin.sim.wirings import direct

FORMAT = UartFormat(9600, 8, "N", 1)
FRAME = FORMAT.frame_ns  # 10 bits at 9600 baud: 1,041,667 ns
MS = 10**6


class Device:
    """Something with a UART and a DTR, and what it has heard; the host's end of its line is `port`."""

    def __init__(self, instant=False):
        self.clock, self.heard, self.times = Clock(), b"", []
        self.dtr = Pin(self.clock, "dtr", True)
        self.uart = Uart(self.clock, FORMAT, on_receive=self._take)
        self.port = SerialPort(self.clock, direct(self.uart, instant=instant), self.dtr, line=FORMAT)

    def _take(self, byte, errors):
        self.heard += bytes([byte])
        self.times.append((self.clock.now, errors))

    def run(self, frames):
        """Let so many characters pass, and a little more."""
        self.clock.run_to(self.clock.now + frames * FRAME + FRAME // 10)
        return self.heard


@pytest.fixture
def device():
    return Device()


def test_without_flow_control_nothing_holds_a_host_back(device):
    device.dtr.set(False)
    device.uart.send(bytes([X_OFF]))
    device.run(1)
    device.port.write(b"ab")
    assert device.run(2) == b"ab"


def test_a_host_that_minds_dtr_ends_with_the_character_on_the_wire_and_goes_on_where_it_was(device):
    device.port.flow = Flow.DTR
    device.port.write(b"abc")
    device.clock.call_later(FRAME // 2, lambda: device.dtr.set(False))
    assert device.run(5) == b"a"
    device.dtr.set(True)
    assert device.run(2) == b"abc"


def test_a_host_that_minds_x_off_waits_for_x_on(device):
    device.port.flow = Flow.X_ON_X_OFF
    device.uart.send(bytes([X_OFF]))
    device.run(1)
    device.port.write(b"abc")
    assert device.run(5) == b""
    device.uart.send(bytes([X_ON]))
    assert device.run(4) == b"abc"


def test_a_host_that_minds_one_thing_does_not_mind_the_other(device):
    device.port.flow = Flow.X_ON_X_OFF
    device.dtr.set(False)
    device.port.write(b"a")
    assert device.run(1) == b"a"
    device.port.flow = Flow.DTR
    device.dtr.set(True)
    device.uart.send(bytes([X_OFF]))
    device.run(1)
    device.port.write(b"b")
    assert device.run(1) == b"ab"


def test_a_host_that_sets_its_flow_control_anew_has_forgotten_an_x_off(device):
    device.port.flow = Flow.X_ON_X_OFF
    device.uart.send(bytes([X_OFF]))
    device.run(1)
    device.port.write(b"a")
    device.port.flow = Flow.X_ON_X_OFF
    assert device.run(1) == b"a"


def test_dtr_that_has_gone_off_before_counts_when_a_host_begins_to_mind_it(device):
    device.dtr.set(False)
    device.port.flow = Flow.DTR
    device.port.write(b"a")
    assert device.run(1) == b""
    device.port.flow = Flow.NONE
    assert device.run(1) == b"a"


def test_a_host_that_is_held_waits_whatever_its_flow_control_says(device):
    device.port.flow = Flow.DTR
    device.port.held = True
    device.port.write(b"a")
    device.dtr.set(False)
    device.dtr.set(True)
    assert device.run(1) == b""
    device.port.held = False
    assert device.run(1) == b"a"


def test_a_host_let_go_by_one_is_still_held_by_the_other(device):
    device.port.flow = Flow.DTR
    device.dtr.set(False)
    device.port.held = True
    device.port.write(b"a")
    device.port.held = False
    assert device.run(1) == b""


def test_on_a_line_that_takes_no_time_x_off_stops_what_follows_it_at_once():
    device = Device(instant=True)
    device.port.flow = Flow.X_ON_X_OFF
    device.uart.on_receive = lambda byte, errors: device._take(byte, errors) or device.uart.send(bytes([X_OFF]))
    device.port.write(b"abc")
    assert (device.heard, device.port.pending, device.clock.now) == (b"a", 2, 0)


# What a host does is told, and can be done again

ACTS = {
    "write": lambda port: port.write(b"ab"),
    "break": lambda port: port.send_break(0.002),
    "hold": lambda port: setattr(port, "held", True),
    "flow": lambda port: setattr(port, "flow", Flow.DTR),
    "format": lambda port: setattr(port.host, "baudrate", 4800),
    "dtr": lambda port: setattr(port.host, "dtr", False),
    "rts": lambda port: port.host.rts_line.set(False),
    "drop": lambda port: port.drop_pending(),
}
VALUES = {
    "write": b"ab", "break": 0.002, "hold": True, "flow": Flow.DTR, "format": UartFormat(4800, 8, "N", 1), "dtr": False,
    "rts": False, "drop": None,
}  # fmt: skip


@pytest.mark.parametrize("kind", ACTS)
def test_each_thing_that_a_host_does_is_told_with_its_value_until_nobody_asks(device, kind):
    told = []
    unwatch = device.port.watch_host(told.append)
    ACTS[kind](device.port)
    unwatch()
    ACTS[kind](device.port)
    assert told == [HostAct(kind, VALUES[kind])]


def test_reading_what_has_come_is_nothing_that_the_device_notices(device):
    told = []
    device.port.watch_host(told.append)
    device.uart.send(b"a")
    device.run(1)
    assert (device.port.read(), told) == (b"a", [])


def test_what_is_done_is_told_before_it_is_done():
    device, seen = Device(instant=True), []
    device.port.watch_host(lambda act: seen.append(device.heard))
    device.port.write(b"a")
    device.port.write(b"b")
    assert seen == [b"", b"a"]


def test_what_an_act_brings_about_at_once_is_not_told_and_what_comes_after_it_is():
    device, told = Device(instant=True), []
    device.uart.on_receive = lambda byte, errors: setattr(device.port.host, "baudrate", 4800)
    device.port.watch_host(told.append)
    device.port.write(b"a")
    device.port.host.dtr = False
    assert told == [HostAct("write", b"a"), HostAct("dtr", False)]


def test_an_act_that_no_host_can_do_is_refused(device):
    with pytest.raises(UsageError, match="unknown action 'sing'"):
        device.port.perform(HostAct("sing"))


DOINGS = st.tuples(
    st.integers(0, 3 * FRAME),
    st.one_of(
        st.binary(min_size=1, max_size=4).map(lambda data: HostAct("write", data)),
        st.sampled_from([0.0005, 0.003]).map(lambda seconds: HostAct("break", seconds)),
        st.booleans().map(lambda on: HostAct("hold", on)),
        st.sampled_from(Flow).map(lambda flow: HostAct("flow", flow)),
        st.sampled_from([4800, 9600]).map(lambda baudrate: HostAct("format", UartFormat(baudrate, 8, "N", 1))),
        st.booleans().map(lambda on: HostAct("dtr", on)),
        st.just(HostAct("drop")),
    ),
)


@settings(max_examples=60, deadline=None)
@given(st.booleans(), st.lists(DOINGS, max_size=12))
def test_what_was_told_done_again_at_its_times_is_the_same_run(instant, doings):
    """The device's DTR goes off and on, and it sends X_OFF and X_ON, so that flow control has something to do."""
    first, told = _moody(instant), []
    first.port.watch_host(lambda act: told.append((first.clock.now, act)))
    for wait_ns, act in doings:
        first.clock.run_to(first.clock.now + wait_ns)
        first.port.perform(act)
    first.run(60)
    second = _moody(instant)
    for at_ns, act in told:
        second.clock.run_to(at_ns)
        second.port.perform(act)
    second.clock.run_to(first.clock.now)
    assert [act for _, act in told] == [act for _, act in doings]
    assert (second.heard, second.times) == (first.heard, first.times)


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


@pytest.mark.parametrize("seconds", [0, -1, 4e-10])
def test_a_break_that_takes_no_time_is_refused(seconds):
    bench = Bench()
    port = bench.add("if1").serial
    with pytest.raises(UsageError, match="expected 1 ns or more"):
        port.send_break(seconds)
    assert port.pending == 0
