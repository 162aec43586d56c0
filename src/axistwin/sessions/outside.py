"""Everything that reaches a bench from outside: what people do, what hosts do; kept, and done again.

What the bench's own hosts, script and faults do while it goes on is not from outside: it happens again by itself.
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


class Outside:
    """What reaches one bench after the other, each in the place of the one before."""

    def __init__(self, pacer: Pacer) -> None:
        self.pacer, self.journal = pacer, Journal()
        self.texts: dict[str, str] = {}
        """Programs that have been loaded, by the names of their files."""
        self._watched: dict[str, Callable[[], None]] = {}

    def attach(self, bench: Bench) -> None:
        """From now on to this bench, and to none before."""
        for unwatch in self._watched.values():
            unwatch()
        self._watched.clear()
        self.bench = bench
        self.runner = ActionRunner(bench, loader(bench, self._text))
        self.watch()

    def watch(self) -> None:
        """Note what hosts do to whom they can talk to."""
        for name in endpoints.names(self.bench):
            if name not in self._watched:
                at_a_bus = endpoints.at_a_bus(self.bench, name)
                port = self.bench[name].bus if at_a_bus else self.bench.port(name)
                self._watched[name] = port.watch_host(partial(self._by_a_host, name))

    def _text(self, file: str) -> str:
        if file not in self.texts:
            raise UsageError(f"{file} has not been given: load it with its text")
        return self.texts[file]

    def prepared(self, act: Act) -> Callable[[], None]:
        """Somebody is going to do this; what cannot be done is found now.  Raises AxistwinError."""
        check(act)
        return partial(self._do, act, self.runner.prepare(act))

    def _do(self, act: Act, do: Callable[[], object]) -> None:
        self.pacer.sync()
        try:
            with one_act(self.bench.clock):
                do()
        except AxistwinError:
            if isinstance(act, Do) and act.target == LOAD:
                self._note(act)  # it has been begun, and will be again
            raise
        self._note(act)
        self.pacer.work()
        self.watch()

    def again(self, act: Act) -> None:
        """Somebody has done this before; what could not be done then is told, and nothing is done again."""
        try:
            with one_act(self.bench.clock):
                self.runner.prepare(act)()
        except AxistwinError as error:
            log.warning("%s", error)

    def _by_a_host(self, name: str, done: HostAct) -> None:
        """About to be done; what the bench does by itself is not from outside."""
        if self.pacer.advancing:
            return
        if endpoints.at_a_bus(self.bench, name):
            self.runner.leave(name)
            self._note(_at_registers(name, done))
        elif done.kind not in ("dtr", "rts") or self.bench.port(name).handshake:  # else nobody sees them
            self._note(_at_a_line(name, done))

    def _note(self, act: Act) -> None:
        was_full = self.journal.full_ns is not None
        if not self.journal.add(self.bench.now, self.pacer.passes, act) and not was_full:
            log.warning("no more is kept of what is done from %.3f s on", to_seconds(self.bench.now))


def _at_a_line(name: str, done: HostAct) -> Act:
    """As a conversation has it."""
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


def _at_registers(name: str, done: HostAct) -> Act:
    match done.kind:
        case "write":
            offset, value = done.value
            return Do("write", f"{offset} {value:02X}", controller=name)
        case "read":
            return Do("read", "0", controller=name)
    return Do("init", "on", controller=name)


class Repetition:
    """Moments of a journal that happen again on a bench, each when all else has happened that is due then.

    `over` is called when all of them have been, at `end_ns`.
    """

    def __init__(
        self, clock: Clock, journal: Journal, do: Callable[[Act], object], end_ns: int, over: Callable[[], None]
    ) -> None:
        self.clock, self.journal, self.end_ns = clock, journal, end_ns
        self._do, self._over = do, over
        self._cursor = Cursor()
        self._wait()

    def happens_by(self, time_ns: int) -> bool:
        """Whether there is something to happen at this time or before."""
        return self._next_ns <= time_ns

    def forget_rest(self) -> None:
        """What has not happened yet never will."""
        self._cancel()
        self.journal.forget_from(self._cursor)

    def _wait(self) -> None:
        found = self.journal.moment(self._cursor)
        if found is None or found[0].time_ns > self.end_ns:
            self._next_ns = self.end_ns
            self._cancel = self.clock.after_all(self.end_ns, self._end)
            return
        moment, behind = found
        self._next_ns = moment.time_ns
        self._cancel = self.clock.after_all(moment.time_ns, lambda: self._happen(moment.acts, behind))

    def _happen(self, acts: tuple[Act, ...], behind: Cursor) -> None:
        for act in acts:
            self._do(act)
        self._cursor = behind
        self._wait()

    def _end(self) -> None:
        self.journal.forget_from(self._cursor)
        self._over()
