"""RFC 2217 with the clients of pyserial and serialx."""

import pytest
import serial
import serialx

from axistwin.sim.frames import UartFormat

from .serving import HOST_TIMEOUT_S, Served, dial, receive
from .test_comport import COM_PORT, DO, WILL, sub

pytestmark = pytest.mark.filterwarnings("ignore:set.* is deprecated:DeprecationWarning")  # pyserial's reader thread

USUAL = {"baudrate": 9600, "bytesize": 8, "parity": "N", "stopbits": 2}


@pytest.fixture
def if1(served):
    return served.add(initialised=False)


@pytest.fixture
def url(served, if1):
    return served.open(if1, "rfc2217://127.0.0.1:0")


def initialise(host):
    host.write(b"(")
    assert host.read(2) == b"U\r"
    host.write(b"U61\r")
    host.write(b"E\r")
    assert host.read(2) == b"C\r"


@pytest.mark.slow
def test_pyserial_negotiates_format_lines_and_break(served, if1, url):
    with serial.serial_for_url(str(url), timeout=HOST_TIMEOUT_S, **USUAL) as host:
        assert if1.serial.host.format == UartFormat(9600, 8, "N", 2)
        initialise(host)
        host.apply_settings({"baudrate": 1200, "bytesize": 7, "parity": "E", "stopbits": 1})
        assert if1.serial.host.format == UartFormat(1200, 7, "E", 1)
        assert (host.dsr, host.cts) == (True, False)  # the device's DTR and RTS; RTS only while sending
        host.dtr, host.rts = False, False
        assert (if1.serial.host.dtr, if1.serial.host.rts) == (False, False)
        host.rts = True
        assert (if1.serial.host.dtr, if1.serial.host.rts) == (False, True)
        host.dtr = True
        host.apply_settings(USUAL)
        host.break_condition = True
        host.break_condition = False
        host.reset_output_buffer()
        host.write(b"F\r")
        assert host.read(2) == b"4\r"  # a break is a framing error
    served.until(lambda: if1.serial.host.dtr)


def test_pyserial_keeps_its_own_format_from_the_beginning(url):
    """The host uses 8 bits, even parity, 2 stop bits; until `U44` the interface receives 8 bits without parity."""
    with serial.serial_for_url(str(url), 9600, parity="E", stopbits=2, timeout=HOST_TIMEOUT_S) as host:
        host.write(b"(")
        assert host.read(2) == b"U\r"
        host.write(b"U44\r")
        host.write(b"E\r")
        assert host.read(2) == b"C\r"


@pytest.mark.slow
def test_a_host_that_waits_for_cts_gets_the_devices_dtr_if_asked_for(served, if1):
    """Control of data transfer: "the DTR line may be connected to the CTS input at the controller"."""
    url = served.open(if1, "rfc2217://127.0.0.1:0?cts=dtr")
    with serial.serial_for_url(f"rfc2217://{url.address}", timeout=HOST_TIMEOUT_S, rtscts=True, **USUAL) as host:
        initialise(host)
        assert (host.dsr, host.cts) == (True, True)


def test_serialx_negotiates_format_lines_and_break(served, if1, url):
    with serialx.serial_for_url(str(url), 9600, stopbits=2, read_timeout=HOST_TIMEOUT_S) as host:
        assert if1.serial.host.format == UartFormat(9600, 8, "N", 2)
        initialise(host)
        host.reconfigure_port(baudrate=2400)
        assert if1.serial.host.baudrate == 2400
        served.act(lambda: if1.serial.dtr_line.drive(False))
        pins = host.get_modem_pins()
        assert (pins.dsr, pins.cts) == (serialx.PinState.LOW, serialx.PinState.LOW)
        served.act(if1.serial.dtr_line.release)
        assert host.get_modem_pins().dsr is serialx.PinState.HIGH
        host.set_modem_pins(dtr=False, rts=True)
        assert (if1.serial.host.dtr, if1.serial.host.rts) == (False, True)


# Byte by byte, for sequences that these clients do not send


class Host:
    def __init__(self, url):
        self.connection = dial(url)
        self.connection.sendall(WILL + COM_PORT)
        self.agreed = receive(self.connection, 10)

    def say(self, data, answer=b""):
        self.connection.sendall(data)
        got = receive(self.connection, len(answer))
        assert got == answer, got

    def control(self, value):
        self.say(sub(5, bytes((value,))), sub(105, bytes((value,))))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.connection.close()


@pytest.fixture
def ready(served):
    """Return an initialised IF1; changes of RTS are not reported, as RTS changes with each answer."""
    if1 = served.add()
    with Host(served.open(if1, "rfc2217://127.0.0.1:0")) as host:
        host.say(sub(11, b"\x22"), sub(111, b"\x22") + sub(107, b"\x20"))
        yield host


def test_a_client_learns_the_lines_when_it_agrees(served, if1, url):
    with Host(url) as host:
        assert host.agreed == DO + COM_PORT + sub(107, b"\x20")


def test_a_client_learns_that_the_device_has_sent(served):
    """The device sets RTS during transmission."""
    with Host(served.open(served.add(), "rfc2217://127.0.0.1:0")) as host:
        host.say(b"E\r", sub(107, b"\x21") + b"C\r")


def test_a_client_that_negotiates_nothing_is_served_like_raw_tcp(served, if1, url):
    with dial(url) as connection:
        connection.sendall(b"(")
        assert receive(connection, 2) == b"U\r"


def test_a_suspended_client_gets_its_answer_when_it_resumes(ready):
    ready.say(sub(8) + b"E\r" + sub(0), sub(100, b"axistwin if1"))
    ready.say(sub(9), b"C\r")


def test_a_wrong_parity_of_the_host_is_a_fault_of_the_device(ready):
    ready.say(sub(3, b"\x04"), sub(103, b"\x04"))  # mark parity is a 1 in place of the first stop bit: no fault
    ready.say(b"F\r", b"0\r")
    ready.say(sub(3, b"\x05"), sub(103, b"\x05"))  # space parity is a 0 in place of it: a fault
    ready.say(b"E\r" + sub(3, b"\x01"), sub(103, b"\x01"))
    ready.say(b"F\r", b"4\r")


def test_a_wrong_speed_of_the_host_is_told_as_line_errors(served, ready):
    """The device sends at 9600 baud and the host receives at 19200: the stop bit is in a wrong place."""
    ready.say(sub(10, b"\x08"), sub(110, b"\x08"))
    ready.say(sub(1, (19200).to_bytes(4, "big")), sub(101, (19200).to_bytes(4, "big")))
    if1 = served.bench["if1"]
    served.act(lambda: if1.serial.to_device.receiver.send(b"\x01"))
    ready.say(b"", sub(106, b"\x68"))


def test_hardware_flow_control_waits_for_the_devices_dtr(served, ready):
    if1 = served.bench["if1"]
    served.act(lambda: if1.serial.dtr_line.drive(False))
    ready.say(b"", sub(107, b"\x02"))
    ready.say(b"E\r", b"C\r")  # without flow control characters are not held
    ready.control(3)
    ready.say(b"E\r")
    served.until(lambda: if1.serial.pending == 2)
    served.act(if1.serial.dtr_line.release)
    ready.say(b"", sub(107, b"\x22") + b"C\r")


def test_x_on_x_off_is_obeyed_and_not_passed_on(served, ready):
    if1 = served.bench["if1"]
    ready.control(2)
    served.act(lambda: if1.serial.to_device.receiver.send(b"a\x13b"))
    ready.say(b"E\r", b"ab")
    served.until(lambda: if1.serial.pending == 2)
    served.act(lambda: if1.serial.to_device.receiver.send(b"\x11"))
    ready.say(b"", b"C\r")


def test_purging_forgets_what_has_not_left(served, ready):
    if1 = served.bench["if1"]
    ready.control(3)
    served.act(lambda: if1.serial.dtr_line.drive(False))
    ready.say(b"X100$\r" + sub(12, b"\x02"), sub(107, b"\x02") + sub(112, b"\x02"))
    assert if1.serial.pending == 0


def test_a_break_lasts_as_long_as_the_client_holds_it():
    """The break lasts for two characters at least."""
    with Served(speed=1000) as served:
        if1, seen = served.add(line=None), []
        with Host(served.open(if1, "rfc2217://127.0.0.1:0")) as host:
            served.do(lambda: setattr(if1.serial.to_device.receiver, "on_receive", lambda *char: seen.append(char)))
            host.control(5)
            host.control(6)
            served.until(lambda: seen)
    [(byte, errors)] = seen
    assert byte == 0 and errors.name == "FRAMING|BREAK"


def test_a_client_that_goes_leaves_the_lines_on_and_the_format_usual(served, ready):
    if1 = served.bench["if1"]
    for value in (9, 12):
        ready.control(value)
    ready.say(sub(1, (1200).to_bytes(4, "big")), sub(101, (1200).to_bytes(4, "big")))
    ready.connection.close()
    served.until(lambda: if1.serial.host.dtr and if1.serial.host.rts)
    with Host(served.server.ports[0][1]) as host:
        host.say(sub(1, bytes(4)), sub(101, (9600).to_bytes(4, "big")))


def test_a_client_that_asks_and_never_reads_is_not_obeyed_for_ever(served, ready):
    """Without a limit, the pending answers of a client that never reads would grow for ever."""
    ready.connection.settimeout(0.2)
    with pytest.raises(TimeoutError):
        ready.connection.sendall(sub(7) * 2_000_000)
    client = served.server._plugs["if1"].client
    assert served.do(lambda: client._transport.get_write_buffer_size()) < 200_000
