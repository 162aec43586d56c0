"""A serial device on which axistwin is the controller; a pty pair replaces cable and host."""

import os
import sys
import tty

import pytest

from axistwin.core.errors import LinkError
from axistwin.links.serialdev import SerialDevice
from axistwin.sim.frames import UartFormat

from .serving import Served, dial, receive

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")


@pytest.fixture
def cable():
    """Return the host's end of a cable, and the path of the device at the other end."""
    host, device = os.openpty()
    tty.setraw(host)
    yield host, os.ttyname(device)
    for end in (host, device):
        os.close(end)


def read(host, count):
    data = b""
    while len(data) < count:
        data += os.read(host, count - len(data))
    return data


def test_a_host_at_the_other_end_of_the_cable_is_answered(served, cable):
    host, path = cable
    if1 = served.add(line=None, initialised=False)
    assert str(served.open(if1, f"serial://{path}?baud=4800")) == f"serial://{path}?baud=4800"
    os.write(host, b"(")
    assert read(host, 2) == b"U\r"
    os.write(host, b"U61\rX100$\rN\r")
    assert read(host, 2) == b"0\r" and if1.serial.to_device.receiver.format.baudrate == 4800
    served.until(lambda: if1.axes["X"].position == 100)


def test_without_a_baud_rate_it_is_that_of_the_line(served, cable):
    _, path = cable
    assert served.open(served.add(line="1200 8N2"), f"serial://{path}").baud == 1200


def test_the_real_uart_follows_the_controllers(served, cable, monkeypatch):
    """U31: 8 data bits, 1 stop bit; U63: 8 data bits, odd parity, 2 stop bits; at the real baud rate."""
    host, path = cable
    applied, if1 = [], served.add(line="9600 8N2", initialised=False)
    served.open(if1, f"serial://{path}?baud=2400")
    device = served.server._plugs["if1"].client
    assert isinstance(device, SerialDevice)
    monkeypatch.setattr(device._device, "apply_settings", applied.append)
    os.write(host, b"(")
    assert read(host, 2) == b"U\r"
    os.write(host, b"U63\r")
    served.until(lambda: applied)
    os.write(host, b"E\r")
    assert read(host, 2) == b"C\r"
    assert applied[-1] == {"baudrate": 2400, "bytesize": 8, "parity": "O", "stopbits": 2}
    assert if1.serial.host.format == UartFormat(2400, 8, "O", 2)
    served.act(if1.power_cycle)
    served.until(lambda: applied[-1] == {"baudrate": 2400, "bytesize": 8, "parity": "N", "stopbits": 2})


def test_a_format_that_the_device_cannot_do_is_told(served, cable, monkeypatch, caplog):
    host, path = cable
    served.open(served.add(initialised=False), f"serial://{path}")

    def refuse(_):
        raise ValueError("not with this chip")

    monkeypatch.setattr(served.server._plugs["if1"].client._device, "apply_settings", refuse)
    os.write(host, b"(")
    assert read(host, 2) == b"U\r"
    os.write(host, b"U23\r")
    served.until(lambda: caplog.text)
    os.write(host, b"E\r")
    assert read(host, 2) == b"C\r"
    assert "does not support 9600 7O2: not with this chip" in caplog.text


class Adapter:
    dtr = rts = dsr = cts = False


def test_control_lines_go_both_ways(cable, monkeypatch):
    host, path = cable
    with Served() as served:
        if1 = served.add(initialised=False)
        lines = Adapter()
        monkeypatch.setattr("axistwin.links.serialdev.control_lines", lambda _: lines)
        served.open(if1, f"serial://{path}")
        served.until(lambda: lines.dtr and not if1.serial.host.dtr and not if1.serial.host.rts)
        os.write(host, b"(")
        lines.dsr = lines.cts = True  # "The interface will therefore not transmit data until DSR and CTS are both set"
        assert read(host, 2) == b"U\r"


def test_another_port_of_the_controller_is_refused(served, cable):
    _, path = cable
    if1 = served.add()
    other = served.open(if1)
    served.open(if1, f"serial://{path}")
    with dial(other) as connection:
        assert receive(connection, 1) == b""


def test_a_cable_that_is_pulled_is_told_and_the_others_go_on(served, caplog):
    host, device = os.openpty()
    served.open(served.add(), f"serial://{os.ttyname(device)}")
    other = served.open(served.add())
    os.close(device)
    os.close(host)
    served.until(lambda: served.server._plugs["if1"].client is None)
    assert ": lost " in caplog.text
    with dial(other) as connection:
        connection.sendall(b"E\r")
        assert receive(connection, 2) == b"C\r"


def test_a_device_that_is_not_there_is_one_line(served):
    with pytest.raises(
        LinkError, match=r"cannot open serial:///dev/no-such\?baud=9600 \(.*check the name of the port"
    ) as caught:
        served.open(served.add(), "serial:///dev/no-such?baud=9600")
    assert "\n" not in str(caught.value)
