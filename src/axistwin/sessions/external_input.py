"""External input of a bench: acts of users and of hosts at real ports, recorded in a journal and replayed.

Acts of the scene's own hosts, script and faults are not external: the bench repeats them by itself.
"""

from collections.abc import Callable
from decimal import Decimal
from functools import partial
from logging import getLogger

from axistwin.bench import Bench, endpoints
from axistwin.bench.action_runner import LOAD, ActionRunner
from axistwin.bench.actions import level_name
from axistwin.bench.acts import Do, Say
from axistwin.errors import AxistwinError, UsageError
from axistwin.links.pacing import Pacer
from axistwin.scenes.hosting import loader
from axistwin.sessions.journal import Act, Cursor, Journal, check
from axistwin.sim.clock import Clock
from axistwin.sim.host_acts import HostAct, one_act
from axistwin.units import to_seconds

log = getLogger("axistwin")


class ExternalInput:
    """Performs and records external input, on the present bench of a session."""

    def __init__(self, pacer: Pacer) -> None:
        self.pacer, self.journal = pacer, Journal()
        self.texts: dict[str, str] = {}
        """Texts of loaded programs, by file name."""
        self._observed: dict[str, Callable[[], None]] = {}

    def attach(self, bench: Bench) -> None:
        """Apply external input to this bench from now on."""
        for unsubscribe in self._observed.values():
            unsubscribe()
        self._observed.clear()
        self.bench = bench
        self.runner = ActionRunner(bench, loader(bench, self._text))
        self.observe_hosts()

    def observe_hosts(self) -> None:
        """Observe the acts of hosts at all endpoints."""
        for name in endpoints.names(self.bench):
            if name not in self._observed:
                at_a_bus = endpoints.at_a_bus(self.bench, name)
                port = self.bench[name].bus if at_a_bus else self.bench.port(name)
                self._observed[name] = port.watch_host(partial(self._record_host_act, name))

    def _text(self, file: str) -> str:
        if file not in self.texts:
            raise UsageError(f"unknown program {file}: load it with its text first")
        return self.texts[file]

    def prepare(self, act: Act) -> Callable[[], None]:
        """Check an act of a user, and return the function that performs and records it.  Raises AxistwinError."""
        check(act)
        return partial(self._do, act, self.runner.prepare(act))

    def _do(self, act: Act, do: Callable[[], object]) -> None:
        self.pacer.sync()
        try:
            with one_act(self.bench.clock):
                do()
        except AxistwinError:
            if isinstance(act, Do) and act.target == LOAD:
                self._record(act)  # a load that fails half-way must fail in a replay, too
            raise
        self._record(act)
        self.pacer.work()
        self.observe_hosts()

    def replay(self, act: Act) -> None:
        """Perform a recorded act again; an error is logged."""
        try:
            with one_act(self.bench.clock):
                self.runner.prepare(act)()
        except AxistwinError as error:
            log.warning("%s", error)

    def _record_host_act(self, name: str, done: HostAct) -> None:
        """Record an act of a host before it is performed; acts of the bench itself are not recorded."""
        if self.pacer.advancing:
            return
        if endpoints.at_a_bus(self.bench, name):
            self.runner.leave(name)
            self._record(_bus_act(name, done))
        elif (
            done.kind not in ("dtr", "rts") or self.bench.port(name).handshake
        ):  # otherwise the lines are not connected
            self._record(_line_act(name, done))

    def _record(self, act: Act) -> None:
        was_full = self.journal.full_ns is not None
        if not self.journal.add(self.bench.now, self.pacer.passes, act) and not was_full:
            log.warning("the journal is full: acts after %.3f s are not recorded", to_seconds(self.bench.now))


def _line_act(name: str, done: HostAct) -> Act:
    """Return a host's act on a serial line as an act of a conversation."""
    match done.kind:
        case "write":
            return Say(bytes(done.value), controller=name)
        case "break":
            return Do("break", f"{Decimal(done.value).quantize(Decimal('1e-9')):f}", controller=name)
        case "format":
            return Do("line", str(done.value), controller=name)
        case "flow":
            return Do("flow", done.value.value, controller=name)
        case "drop":
            return Do("drop", "pending", controller=name)
    return Do(done.kind, level_name(done.value), controller=name)


def _bus_act(name: str, done: HostAct) -> Act:
    match done.kind:
        case "write":
            offset, value = done.value
            return Do("write", f"{offset} {value:02X}", controller=name)
        case "read":
            return Do("read", "0", controller=name)
    return Do("init", "on", controller=name)


class Replay:
    """Replays the moments of a journal on a bench, each after all other events of its nanosecond.

    `on_end` is called at `end_ns`, after the last moment.
    """

    def __init__(
        self, clock: Clock, journal: Journal, do: Callable[[Act], object], end_ns: int, on_end: Callable[[], None]
    ) -> None:
        self.clock, self.journal, self.end_ns = clock, journal, end_ns
        self._do, self._on_end = do, on_end
        self._cursor = Cursor()
        self.finished = False
        """True after the last moment, from `end_ns` on."""
        self._schedule_next()

    def is_due_by(self, time_ns: int) -> bool:
        """True if a moment at or before this time is left."""
        return self._next_ns <= time_ns

    def abandon(self) -> None:
        """End the replay, and delete the remaining moments from the journal."""
        self._cancel()
        self.journal.truncate(self._cursor)

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
