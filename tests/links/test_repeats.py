"""Acts of hosts at a port, at any speed and with pauses: repeated at their times, they give the same run."""

from itertools import groupby

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.links.pacing import Pacer
from axistwin.links.plug import Plug
from axistwin.scenes.sessions.recorded_port import RecordedPort
from axistwin.sim.frames import UartFormat
from axistwin.sim.serial_port import Flow

from ..sessions.test_recorded_port import perform
from .fake_loop import Loop
from .serving import initialise
from .test_exchange import Client

LINES = st.sampled_from(["9600 8N2", "instant"])
SPEEDS = st.sampled_from([0.5, 1.0, 7.0, 100.0, None])
SAYINGS = st.sampled_from([b"E\r", b"X100$\r", b"X-7Y30$\rN\r", b"S1$\r", b"#\r", b"\x13", b"K"])
STEPS = st.one_of(
    st.tuples(st.just("wait"), st.floats(0, 0.2)),
    st.tuples(st.just("say"), SAYINGS),
    st.tuples(st.just("line"), st.sampled_from([4800, 9600])),
    st.tuples(st.just("rts"), st.booleans()),
    st.tuples(st.just("break"), st.booleans()),
    st.tuples(st.just("flow"), st.sampled_from(Flow)),
    st.tuples(st.just("speed"), SPEEDS),
    st.tuples(st.just("stop"), st.none()),
    st.tuples(st.just("start"), st.none()),
    st.tuples(st.just("client"), st.booleans()),
)


class Noted:
    """An initialised IF1; its output and its level changes are recorded with their times."""

    def __init__(self, line):
        self.bench = Bench()
        self.if1 = initialise(self.bench, self.bench.add("if1", line=line))
        self.port = self.if1.serial
        self.seen = []
        self.port.subscribe_received(lambda byte, errors: self.note("heard", byte, errors))
        for pin in self.if1.pins.values():
            pin.subscribe(lambda pin: self.note(pin.name, pin.level))

    def note(self, *what):
        self.seen.append((self.bench.now, *what))

    def finished(self, end_ns):
        self.bench.clock.run_to(end_ns)
        return self.seen, {name: axis.position for name, axis in self.if1.axes.items()}


class Hasty(Loop):
    """A loop whose clock advances a little at each read, as a real clock does."""

    def time(self):
        self.now_s += 1e-6
        return self.now_s


class Session:
    """Hosts at a plug, with a fake wall clock, and the record of their acts."""

    def __init__(self, line, speed):
        self.noted, self.loop = Noted(line), Hasty()
        self.pacer = Pacer(self.noted.bench.clock, speed)
        self.kept = []
        self.port = RecordedPort(self.noted.port, self._keep)
        self.plug = Plug("if1", self.port, self.pacer)
        self.pacer.start(self.loop)

    def _keep(self, act):
        if not self.pacer.advancing:
            self.kept.append(((self.noted.bench.now, self.pacer.passes), act))

    def take(self, what, value):
        host = self.port.host
        match what:
            case "wait":
                self.loop.run_to(self.loop.now_s + value)
            case "say":
                self.plug.send(value)
            case "line":
                self.plug.change(lambda: setattr(host, "format", UartFormat(value, 8, "N", 2)))
            case "rts":
                self.plug.change(lambda: setattr(host, "rts", value))
            case "break":
                self.plug.change(lambda: self.plug.set_break(value))
            case "flow":
                self.plug.flow = value
                self.plug.change(self.plug.apply_flow)
            case "speed":
                self.pacer.speed = value
            case "stop":
                self.pacer.stop()
            case "start":
                self.pacer.start(self.loop)
            case "client" if value:
                self.plug.connect(Client())
            case "client" if self.plug.client is not None:
                self.plug.disconnect(self.plug.client)


@settings(max_examples=30, deadline=None)
@given(LINES, SPEEDS, st.lists(STEPS, max_size=25))
def test_moments_kept_and_done_again_are_the_same_run(line, speed, steps):
    session = Session(line, speed)
    for what, value in steps:
        session.take(what, value)
    session.pacer.stop()
    session.pacer.sync()
    end_ns = session.noted.bench.now + 2_000_000_000
    again = Noted(line)
    for (time_ns, _), acts in groupby(session.kept, key=lambda one: one[0]):
        moment = [act for _, act in acts]
        again.bench.clock.call_last(time_ns, lambda moment=moment: [perform(again.port, act) for act in moment])
    assert again.finished(end_ns) == session.noted.finished(end_ns)
