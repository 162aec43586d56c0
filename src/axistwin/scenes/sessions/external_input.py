"""External input of a bench: the actions of users and of hosts at real ports, which are recorded and replayed.

Actions of the scene's own hosts, script and faults are not external; the bench repeats them by itself.
"""

from collections.abc import Callable
from functools import partial
from logging import getLogger

from axistwin.bench import Bench
from axistwin.bench.action_runner import LOAD, ActionRunner
from axistwin.bench.actions import line_action
from axistwin.bench.acts import Do, Say
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.units import to_seconds
from axistwin.links.pacing import Pacer
from axistwin.links.server import Server
from axistwin.scenes.hosting import loader
from axistwin.scenes.sessions.journal import Act, Cursor, Journal, Tail, check
from axistwin.scenes.sessions.recorded_port import RecordedBus, RecordedPort
from axistwin.sim.clock import Clock
from axistwin.sim.registers import BusAct, Init, ReadData, WriteRegister
from axistwin.sim.serial_port import LineAct, SetLine, Write

log = getLogger("axistwin")

REPEATING = "the run is being repeated"  # Reason that is given to new clients that are refused during a replay.


class ExternalInput:
    """Performs and records the actions of users and hosts in a session."""

    def __init__(self, pacer: Pacer) -> None:
        self.pacer, self.journal = pacer, Journal()
        self.texts: dict[str, str] = {}  # Texts of loaded programs, by file name.
        self._ports: dict[str, RecordedPort] = {}
        self._buses: dict[str, RecordedBus] = {}
        self._muted = False
        self._server: Server | None = None

    def attach(self, bench: Bench) -> None:
        """Connect the session's ports to this bench.  Clients stay connected, and the bench's ports are not changed.

        Raises UsageError, without any change, if the bench has no port of a name that is in use.  Not allowed while the
        bench is being advanced.
        """
        ports = [(port, bench.port(name)) for name, port in self._ports.items()]
        buses = [(bus, bench[name].bus) for name, bus in self._buses.items()]
        self.bench = bench
        self.runner = ActionRunner(bench, loader(bench, self._text))
        for recorded, port in ports:
            recorded.attach(port)
        for registers, bus in buses:
            registers.attach(bus)
        if self._server is not None:
            self._server.bench = bench
        self.pacer.pace(bench.clock)

    def serial(self, name: str) -> RecordedPort:
        """Return the port of an endpoint for a host; the host's actions are recorded.  Raises UsageError."""
        if name not in self._ports:
            self._ports[name] = RecordedPort(self.bench.port(name), partial(self._record_line_act, name))
            self._ports[name].mute(self._muted)
        return self._ports[name]

    def bus(self, name: str) -> RecordedBus:
        """Return the registers of a board for a host; the host's actions are recorded.  Raises UsageError."""
        if name not in self._buses:
            self._buses[name] = RecordedBus(self.bench[name].bus, partial(self._record_bus_act, name))
            self._buses[name].mute(self._muted)
        return self._buses[name]

    def serve(self, server: Server) -> None:
        """Add a server whose clients are also blocked during a replay."""
        self._server = server
        server.bench = self.bench
        if self._muted:
            server.gate.close(REPEATING)

    def mute(self) -> None:
        """Block the data between hosts and controllers, and refuse new clients."""
        if self._server is not None:
            self._server.gate.close(REPEATING)
        self._mute(True)

    def unmute(self) -> None:
        """End the block of hosts, and report the changes of lines during the block to them."""
        self.pacer.sync()
        self._mute(False)
        if self._server is not None:
            self._server.gate.open()
        self.pacer.work()

    def _mute(self, on: bool) -> None:
        self._muted = on
        for port in self._ports.values():
            port.mute(on)
        for bus in self._buses.values():
            bus.mute(on)

    def _text(self, file: str) -> str:
        if file not in self.texts:
            raise UsageError(f"unknown program {file}: expected the name of a program that this session has loaded")
        return self.texts[file]

    def prepare(self, act: Act) -> Callable[[], None]:
        """Return a function that performs and records an action.  Raises AxistwinError if it is invalid."""
        check(act)
        return partial(self._do, act, self.runner.prepare(act))

    def _do(self, act: Act, do: Callable[[], object]) -> None:
        self.pacer.sync()
        try:
            do()
        except AxistwinError:
            # Record the failed load of a program, so that a replay fails in the same way.
            if isinstance(act, Do) and act.target == LOAD:
                self._record(act)
            raise
        else:
            self._record(act)
        finally:
            self.pacer.work()

    def replay(self, act: Act) -> None:
        """Repeat a recorded action.  If the action fails, log the error."""
        try:
            self.runner.prepare(act)()
        except AxistwinError as error:
            log.warning("%s", error)

    def _record_line_act(self, name: str, act: LineAct) -> None:
        """Record an action of a host before it is performed, unless the bench itself performs it."""
        if self.pacer.advancing or (isinstance(act, SetLine) and not self.bench.port(name).handshake):
            return
        if isinstance(act, Write):
            self._record(Say(bytes(act.data), controller=name))
        else:
            self._record(Do(*line_action(act), controller=name))

    def _record_bus_act(self, name: str, act: BusAct) -> None:
        if self.pacer.advancing:
            return
        self.runner.leave(name)
        match act:
            case WriteRegister(offset, value):
                self._record(Do("write", f"{offset} {value:02X}", controller=name))
            case ReadData():
                self._record(Do("read", "0", controller=name))
            case Init():
                self._record(Do("init", "on", controller=name))

    def _record(self, act: Act) -> None:
        was_full = self.journal.full_ns is not None
        if not self.journal.add(self.bench.now, self.pacer.passes, act) and not was_full:
            log.warning("the journal is full: acts after %.3f s are not recorded", to_seconds(self.bench.now))


class Replay:
    """Repeats the recorded actions of a journal.

    Each action is performed after all other events of its time.  `on_end` is called at `end_ns`, after the last
    recorded action.
    """

    def __init__(
        self, clock: Clock, journal: Journal, do: Callable[[Act], object], end_ns: int, on_end: Callable[[], None]
    ) -> None:
        self.clock, self.journal, self.end_ns = clock, journal, end_ns
        self._do, self._on_end = do, on_end
        self._cursor = Cursor()
        self.finished = False  # True if all recorded actions are performed and the time `end_ns` is reached.
        self._schedule_next()

    def is_due_by(self, time_ns: int) -> bool:
        return self._next_ns <= time_ns

    def abandon(self) -> Tail:
        """End the replay early; delete and return the part of the journal that has not been replayed."""
        self._cancel()
        return self.journal.truncate(self._cursor)

    def _schedule_next(self) -> None:
        found = self.journal.moment(self._cursor)
        if found is None or found[0].time_ns > self.end_ns:
            self._next_ns = self.end_ns
            self._cancel = self.clock.call_last(self.end_ns, self._end)
            return
        moment, after = found
        self._next_ns = moment.time_ns
        self._cancel = self.clock.call_last(moment.time_ns, lambda: self._perform(moment.acts, after))

    def _perform(self, acts: tuple[Act, ...], after: Cursor) -> None:
        for act in acts:
            self._do(act)
        self._cursor = after
        self._schedule_next()

    def _end(self) -> None:
        self.journal.truncate(self._cursor)
        self.finished = True
        self._on_end()
