"""A new bench replaces the served one: clients stay connected, are blocked during a replay, and then continue."""

import logging

import pytest
import serial

from axistwin import Bench
from axistwin.bench import Do, Say
from axistwin.core.errors import UsageError
from axistwin.core.units import S
from axistwin.links.pacing import Pacer
from axistwin.links.plug import FULL, Plug
from axistwin.links.server import Server
from axistwin.links.single_client import Gate
from axistwin.scenes.sessions.external_input import ExternalInput
from axistwin.scenes.sessions.journal import Cursor
from axistwin.scenes.sessions.recorded_port import RecordedPort
from axistwin.sim.clock import Clock
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import Flow, Hold, SendBreak, SerialPort, SetFlow, SetFormat, SetLine
from axistwin.sim.wirings import direct

from .serving import HOST_TIMEOUT_S, Served, ask, dial, initialise, receive
from .test_bus import Host

FAST = UartFormat(19200, 8, "N", 1)


class Client:
    def __init__(self, name="me", flow=None):
        self.name, self.flow = name, flow
        self.heard, self.reading = b"", True

    def deliver(self, data, errors):
        self.heard += data

    def hung_up(self):
        return False

    def drop(self):
        raise AssertionError("the client must not be dropped")

    def pause(self):
        self.reading = False

    def resume(self):
        self.reading = True


class Device:
    """A device with control lines on an instant line; `port` is the host's end."""

    def __init__(self):
        self.clock = Clock()
        self.uart = Uart(self.clock)
        lines = Pin(self.clock, "dtr", True), Pin(self.clock, "rts", True)
        self.port = SerialPort(self.clock, direct(self.uart, instant=True), *lines, line=UartFormat())


class Place:
    """A device with a plug and a client; the test advances the time."""

    def __init__(self):
        self.device, self.acts = Device(), []
        self.pacer = Pacer(self.device.clock)
        self.port = RecordedPort(self.device.port, self.acts.append)
        self.gate = Gate()
        self.plug = Plug("if1", self.port, self.pacer, gate=self.gate)
        self.client = Client()

    def run(self, seconds):
        self.device.clock.run_to(round(seconds * S))

    def again(self, seconds=0.0):
        """Replace the device by an equal one, at this time."""
        self.mute()
        self.device = Device()
        self.run(seconds)
        self.port.attach(self.device.port)
        self.pacer.pace(self.device.clock)

    def mute(self):
        self.gate.close("the run is being repeated")
        self.port.mute(True)

    def hear_again(self):
        self.pacer.sync()
        self.port.mute(False)
        self.gate.open()

    def told(self):
        """Return a list that receives the host's acts from now on."""
        self.acts.clear()
        return self.acts

    def say(self, data):
        """Transmit data from the controller."""
        self.device.uart.send(data)
        self.pacer.work()


@pytest.fixture
def place():
    return Place()


# A plug that is muted


def test_what_is_said_while_it_is_deaf_is_not_heard_and_what_was_said_before_is(place):
    place.plug.connect(place.client)
    place.say(b"a")
    place.mute()
    place.say(b"b")
    assert (place.client.heard, place.client.reading) == (b"a", False)
    place.hear_again()
    place.say(b"c")
    assert (place.client.heard, place.client.reading) == (b"ac", True)


def test_words_that_had_not_been_handed_over_are_when_it_falls_muted(place):
    place.plug.connect(place.client)
    place.device.uart.send(b"a")
    place.mute()
    assert place.client.heard == b"a"


def test_another_client_is_refused_and_told_once_why(place, caplog):
    place.mute()
    with caplog.at_level(logging.WARNING, "axistwin.links"):
        assert not place.plug.connect(Client("first")) and not place.plug.connect(Client("second"))
    assert [record.getMessage() for record in caplog.records] == ["if1: refused first, as the run is being repeated"]
    place.hear_again()
    assert place.plug.connect(Client("third")) and place.plug.client_name == "third"


def test_nothing_is_done_when_a_client_goes_and_all_of_it_later(place):
    place.plug.connect(place.client)
    place.plug.change(lambda: setattr(place.port.host, "rts", False))
    acts = place.told()
    place.mute()
    place.plug.disconnect(place.client)
    assert (acts, place.plug.client_name, place.port.host.rts) == ([], "", False)
    place.hear_again()
    assert (place.plug.client, place.port.host.rts) == (None, True)
    assert SetLine("rts", True) in acts


def test_a_client_that_is_not_read_from_for_another_reason_waits_on(place):
    place.plug.connect(place.client)
    place.port.held = True
    place.plug.send(b"x" * (FULL + 1))
    place.mute()
    place.hear_again()
    assert place.client.reading is False
    place.port.drop_pending()
    place.pacer.work()
    assert place.client.reading is True


def test_room_that_there_is_again_while_it_is_deaf_is_used_afterwards(place):
    place.plug.connect(place.client)
    place.port.held = True
    place.plug.send(b"x" * (FULL + 1))
    place.mute()
    place.port.drop_pending()
    place.pacer.work()
    assert (place.client.reading, place.plug.full) == (False, True)
    place.hear_again()
    assert (place.client.reading, place.plug.full) == (True, False)


# On another bench


def test_a_client_hears_the_bench_that_has_come_and_no_more_the_one_that_was(place):
    place.plug.connect(place.client)
    old = place.device
    place.again()
    place.hear_again()
    old.uart.send(b"old")
    place.say(b"new")
    place.plug.send(b"(")
    assert place.client.heard == b"new" and old.port.read() == b"old"


def test_the_port_that_has_come_is_left_as_it_is(place):
    place.plug.connect(place.client)
    place.run(1)
    place.again(seconds=2)
    acts = place.told()
    place.hear_again()
    assert acts == []


def test_what_a_client_has_asked_for_later_is_asked_for_again(place):
    """After 3 s a client has set a format, flow control and lines; a return to 1 s keeps these requests."""
    place.client.flow = Flow.X_ON_X_OFF
    place.run(3)
    place.plug.connect(place.client)
    place.plug.change(lambda: setattr(place.port.host, "format", FAST))
    place.plug.change(lambda: setattr(place.port.host, "dtr", False))
    place.plug.change(lambda: setattr(place.port.host, "rts", False))
    place.plug.change(lambda: setattr(place.port.host, "rts", True))
    place.again(seconds=1)
    acts = place.told()
    place.hear_again()
    wanted = {SetFlow(Flow.X_ON_X_OFF), SetFormat(FAST), SetLine("dtr", False), SetLine("rts", True)}
    assert set(acts) == wanted
    assert (place.port.host.format, place.port.host.dtr, place.port.flow) == (FAST, False, Flow.X_ON_X_OFF)


def test_what_somebody_else_has_changed_since_then_stays(place):
    place.plug.connect(place.client)
    place.run(3)
    place.again(seconds=3)
    place.device.port.host.format = FAST
    place.hear_again()
    assert place.port.host.format == FAST


def test_back_before_a_client_that_has_gone_its_lines_are_as_it_left_them(place):
    place.plug.connect(place.client)
    place.plug.change(lambda: setattr(place.port.host, "rts", False))
    place.run(3)
    place.plug.disconnect(place.client)
    place.again(seconds=1)
    place.device.port.host.rts = False  # the level that it had at 1 s
    place.hear_again()
    assert place.port.host.rts is True


def test_a_break_that_was_begun_later_goes_on_and_ends(place):
    place.run(3)
    place.plug.connect(place.client)
    place.plug.change(lambda: place.plug.set_break(True))
    place.again(seconds=1)
    place.hear_again()
    assert place.port.held is True
    acts = place.told()
    place.plug.change(lambda: place.plug.set_break(False))
    assert [type(act) for act in acts] == [SendBreak, Hold] and place.port.held is False


# Lines with subscribers


def test_whoever_watches_a_line_watches_it_on_the_bench_that_has_come(place):
    seen = []
    unwatch = place.port.dtr_line.subscribe(lambda pin: seen.append((pin is place.port.dtr_line, pin.level)))
    before = place.port.dtr_line.level
    place.again()
    place.hear_again()
    place.device.port.dtr_line.set(not before)
    assert seen == [(True, not before)]
    unwatch()
    place.device.port.dtr_line.set(before)
    assert len(seen) == 1


@pytest.mark.parametrize(("after", "told"), [(True, []), (False, [False])])
def test_while_it_is_deaf_a_line_may_go_up_and_down_and_how_it_stands_is_told_afterwards(place, after, told):
    seen = []
    place.plug.connect(place.client)
    place.port.dtr_line.subscribe(lambda pin: seen.append(pin.level))
    place.again()
    for level in (False, True, False, after):
        place.device.port.dtr_line.set(level)
    assert seen == []
    place.hear_again()
    assert seen == told


# A server, with clients on sockets


class Exchanged(Served):
    """A served bench with recorded external input, which another bench can replace."""

    def __init__(self):
        super().__init__()
        self.input = ExternalInput(self.server.pacer)
        self.input.attach(self.bench)
        self.server = Server(self.bench, pacer=self.server.pacer, access=self.input)
        self.input.serve(self.server)

    def replace(self, bench):
        """Replace the bench; clients are blocked meanwhile."""
        muted = self.server.gate.closed
        self.input.mute()
        try:
            self.input.attach(bench)
            self.input.journal.truncate(Cursor())  # the recording of the old bench
        finally:
            if not muted:
                self.input.unmute()

    @property
    def acts(self):
        return [act for moment in self.input.journal for act in moment.acts]


@pytest.fixture
def served():
    with Exchanged() as served:
        yield served


def another(served, **options):
    """Return a bench equal to the served one: an initialised IF1 on an instant line."""
    bench = Bench()
    initialise(bench, bench.add("if1", line="instant", **options))
    return bench


def test_a_client_goes_on_with_a_bench_that_has_taken_the_place_of_another(served):
    served.add()
    url = served.open(served.bench["if1"])
    with dial(url) as host:
        assert ask(host) == b"C\r"
        old, new = served.bench, served.do(lambda: another(served))
        served.do(lambda: served.replace(new))
        reached = old.now
        assert ask(host) == b"C\r"
        host.sendall(b"X1000S3$\r")
        served.bench = new
        served.until(lambda: new["if1"].axes["X"].position == 1000)
    assert (served.server.bench, old.now) == (new, reached) and old["if1"].axes["X"].position == 0


def test_characters_sent_while_nobody_was_heard_arrive_then(served):
    url = served.open(served.add())
    with dial(url) as host:
        ask(host)
        served.do(served.input.mute)
        host.sendall(b"E\r")
        new = served.do(lambda: another(served))
        heard = []
        new["if1"].serial.subscribe_sent(heard.append)
        served.do(lambda: served.replace(new))
        served.do(lambda: None)  # the loop has made a turn
        assert heard == []
        served.do(served.input.unmute)
        assert receive(host, 2) == b"C\r" and b"".join(heard) == b"E\r"


@pytest.mark.slow
def test_who_is_connected_is_told_by_name_until_he_goes(served):
    url = served.open(served.add())
    assert served.do(lambda: served.server.client("if1")) == ""
    with dial(url) as host:
        ask(host)
        address = "{}:{}".format(*host.getsockname())
        assert served.do(lambda: served.server.client("if1")) == address
        assert served.do(lambda: served.server.client("somebody else")) == ""
        served.do(served.input.mute)
    served.do(served.input.unmute)
    served.until(lambda: served.server.client("if1") == "")


def test_a_client_that_comes_while_nobody_is_heard_is_disconnected_and_may_come_again(served):
    url = served.open(served.add())
    served.do(served.input.mute)
    with dial(url) as host:
        assert receive(host, 1) == b""
    served.do(served.input.unmute)
    with dial(url) as host:
        assert ask(host) == b"C\r"


def test_a_port_opened_while_nobody_is_heard_is_deaf_too(served):
    if1 = served.add()
    served.do(served.input.mute)
    with dial(served.open(if1)) as host:
        assert receive(host, 1) == b""


def test_a_bench_on_which_somebody_is_missing_is_refused_and_all_stays_as_it_was(served):
    url = served.open(served.add())
    with dial(url) as host:
        with pytest.raises(UsageError, match="no controller 'if1'"):
            served.do(lambda: served.replace(Bench()))
        assert (ask(host), served.server.bench) == (b"C\r", served.bench)


def test_a_master_goes_on_with_the_registers_that_have_come_and_is_told_how_the_interrupt_stands(served):
    served.add_board()
    url = served.open(served.bench["1811"], "bus://:0")
    with Host(url) as host:
        assert host.ask("s 1") == "ok"
        served.do(served.input.mute)
        host.send("r 1\n")
        new = served.do(Bench)
        served.do(lambda: new.add("1811"))
        served.do(lambda: served.replace(new))
        line = new["1811"].bus.interrupt_line
        for level in (True, False, True):
            served.do(lambda level=level: line.set(level))
        served.do(served.input.unmute)
        assert host.line() == "! 1" and int(host.line(), 16) == new["1811"].bus.status
        assert host.ask("w 0 41") == "ok"
        assert served.acts == [Do("write", "0 41", controller="1811")]


@pytest.mark.parametrize("model", ["if1", "1811"])
def test_what_a_new_client_finds_can_be_seen_to_by_somebody_else(model):
    seen = []
    with Served() as served:
        served.server = Server(served.bench, speed=None, reset=seen.append)
        served.do(served.server.start)
        served.do(lambda: served.bench.add(model))
        url = served.open(served.bench[model], "bus://:0" if model == "1811" else "tcp://127.0.0.1:0")
        with dial(url):
            served.until(lambda: seen)
    assert seen == [model]


def test_acts_at_a_second_channel_are_recorded_from_the_first_one_on(served):
    """A second channel exists on a bench only after its first use."""
    served.do(lambda: served.bench.add("smartmotor", line="instant"))
    for _ in range(2):
        address = served.open_name("smartmotor.rs485")
    written = Say(b"a=1 ", controller="smartmotor.rs485")
    with dial(address) as host:
        host.sendall(b"a=1 ")
        served.until(lambda: written in served.acts)
    assert served.acts[0] == Do("flow", "dtr", controller="smartmotor.rs485") and served.acts.count(written) == 1


def test_a_server_that_is_not_deaf_makes_the_ports_as_clients_want_them_at_once(served):
    served.add()
    url = served.open(served.bench["if1"])
    with dial(url) as host:
        ask(host)
        plug = served.server._plugs["if1"]
        served.do(lambda: plug.change(lambda: setattr(plug.serial.host, "rts", False)))
        new = Bench()
        new.add("if1", line="instant")
        served.do(lambda: served.replace(new))
        assert new["if1"].serial.host.rts is False


# Transports that show more than characters


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:set.* is deprecated:DeprecationWarning")  # pyserial's reader thread
def test_a_client_of_rfc_2217_has_its_format_and_lines_on_a_bench_that_is_earlier(served):
    url = served.open(served.add(), "rfc2217://127.0.0.1:0")
    with serial.serial_for_url(str(url), 9600, stopbits=2, timeout=HOST_TIMEOUT_S) as host:
        host.apply_settings({"baudrate": 1200, "bytesize": 7, "parity": "E", "stopbits": 1})
        host.rts = False
        new = served.do(Bench)
        served.do(lambda: new.add("if1", line="instant"))
        served.do(lambda: served.replace(new))
        port = new["if1"].serial
        assert (port.host.format, port.host.rts) == (UartFormat(1200, 7, "E", 1), False)
        heard = []
        served.do(lambda: port.subscribe_sent(heard.append))
        host.write(b"(")
        served.until(lambda: heard)


def test_a_client_of_a_pty_waits_and_goes_on(served):
    url = served.open(served.add(), "pty:")
    with serial.Serial(url.path, 9600, stopbits=2, timeout=HOST_TIMEOUT_S) as host:
        host.write(b"E\r")
        assert host.read(2) == b"C\r"
        served.do(served.input.mute)
        host.write(b"E\r")
        new = served.do(lambda: another(served))
        served.do(lambda: served.replace(new))
        heard = []
        new["if1"].serial.subscribe_sent(heard.append)
        assert heard == []
        served.do(served.input.unmute)
        assert host.read(2) == b"C\r"
        assert served.do(lambda: served.server.client("if1")) == str(url)
    served.until(lambda: served.server.client("if1") == "")


def test_a_pty_closed_while_nobody_is_heard_is_closed_afterwards(served):
    url = served.open(served.add(), "pty:")
    with serial.Serial(url.path, 9600, stopbits=2, timeout=HOST_TIMEOUT_S) as host:
        host.write(b"E\r")
        assert host.read(2) == b"C\r"
        served.do(served.input.mute)
    served.do(served.input.unmute)
    served.until(lambda: served.server.client("if1") == "")
    with serial.Serial(url.path, 9600, stopbits=2, timeout=HOST_TIMEOUT_S) as host:
        host.write(b"E\r")
        assert host.read(2) == b"C\r"
