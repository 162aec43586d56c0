"""The host's end of a serial line: flow control."""

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import X_OFF, X_ON, Flow, SerialPort
from axistwin.sim.wirings import direct

FORMAT = UartFormat(9600, 8, "N", 1)
FRAME = FORMAT.frame_ns  # 10 bits at 9600 baud: 1,041,667 ns
MS = 10**6


class Device:
    """A device with a UART and a DTR line, and its received characters; `port` is the host's end."""

    def __init__(self, instant=False):
        self.clock, self.heard, self.times = Clock(), b"", []
        self.dtr = Pin(self.clock, "dtr", True)
        self.uart = Uart(self.clock, FORMAT, on_receive=self._take)
        self.port = SerialPort(self.clock, direct(self.uart, instant=instant), self.dtr, line=FORMAT)

    def _take(self, byte, errors):
        self.heard += bytes([byte])
        self.times.append((self.clock.now, errors))

    def run(self, frames):
        """Advance by the duration of a number of characters, and a little more."""
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


@pytest.mark.parametrize("seconds", [0, -1, 4e-10])
def test_a_break_that_takes_no_time_is_refused(seconds):
    port = Bench().add("if1").serial
    with pytest.raises(UsageError, match="expected 1 ns or more"):
        port.send_break(seconds)
    assert port.pending == 0
