"""Controllers on real ports while a `with` block lasts, for tests of host programs: `axistwin.serve`.

    import axistwin, serial

    with axistwin.serve("if1", speed="manual") as twin:
        host = serial.serial_for_url(twin.ports["if1"], timeout=5)
        twin.advance(1.5)               # it has just been switched on
        host.write(b"(")
        twin.advance(0.1)
        assert host.read(2) == b"U\\r"

The ports are served by a thread; the bench belongs to it.  With `speed="manual"` virtual time passes only when it is
told to, and between two of these calls the bench may be looked at and touched; at other speeds `do` touches it safely.
"""

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, NamedTuple, Self, TypeVar

from axistwin.bench import Bench, endpoints
from axistwin.errors import UsageError
from axistwin.links.hand import ManualClock, ServedClock
from axistwin.links.host_thread import HostThread
from axistwin.links.manual import ManualPacer
from axistwin.links.pacing import Pacer, read_speed
from axistwin.links.server import Server
from axistwin.links.thread import LoopThread
from axistwin.links.urls import PortUrl, parse
from axistwin.scenes.toml_text import toml_value

T = TypeVar("T")
Writer = Callable[[Bench], AbstractContextManager[object]]
"""Writes down what happens on a bench meanwhile."""
Speed = float | Literal["manual", "max"]
ANYWHERE = {"tcp": "tcp://127.0.0.1:0", "rfc2217": "rfc2217://127.0.0.1:0", "pty": "pty:", "bus": "bus://127.0.0.1:0"}
SCHEMES = ("tcp", "rfc2217", "pty")
PATIENCE_S = 10.0


class Url(str):
    """Where a port is, as `serial.serial_for_url` takes it; of a board, `bus://host:port`."""

    __slots__ = ()

    @property
    def address(self) -> str:
        """`host:port`, as EPICS asyn takes it."""
        return self.partition("://")[2]

    @property
    def host(self) -> str:
        """The host's name or number."""
        return self.address.rpartition(":")[0].strip("[]")

    @property
    def port(self) -> int:
        """The number of its port."""
        return int(self.address.rpartition(":")[2])

    @property
    def visa(self) -> str:
        """As PyVISA takes it."""
        return f"TCPIP0::{self.host}::{self.port}::SOCKET" if "://" in self else f"ASRL{self}::INSTR"


class HostCall:
    """What a host does in a thread of its own."""

    def __init__(self, clock: ServedClock, thread: HostThread) -> None:
        self._clock, self._thread = clock, thread

    @property
    def done(self) -> bool:
        """Whether it has come to its end."""
        return self._thread.done

    def result(self, timeout: float = PATIENCE_S) -> Any:
        """Let it come to its end; returns what it returns, raises what it raises.

        With `speed="manual"` time passes while it waits.  Raises LinkError if it still waits after `timeout` (virtual)
        seconds in which nobody has said anything.
        """
        return self._clock.attend(self._thread, timeout)


class _Service(NamedTuple):
    """What serves a twin while its `with` block lasts."""

    loop: LoopThread
    server: Server
    clock: ServedClock


class Twin:
    """A bench on real ports, between entering and leaving a `with` block.  Made by `serve`."""

    def __init__(
        self, bench: Bench, wanted: list[tuple[str, PortUrl]], speed: Speed, writers: Iterable[Writer] = ()
    ) -> None:
        self.bench = bench
        """The virtual machines themselves: `bench["if1"].axes["X"].position`."""
        self.ports: dict[str, Url] = {}
        """Where each controller, second channel and line of motors is reached, by name."""
        self._wanted, self._speed, self._writers = wanted, speed, writers
        self._written = ExitStack()
        self._served: _Service | None = None

    @property
    def clock(self) -> ServedClock:
        """Virtual time."""
        return self._service.clock

    @property
    def _service(self) -> _Service:
        if self._served is None:
            raise UsageError("this twin is not served yet: enter it first, `with axistwin.serve(…) as twin:`")
        return self._served

    def __enter__(self) -> Self:
        manual = self._speed == "manual"
        pacer = ManualPacer(self.bench) if manual else Pacer(self.bench.clock, read_speed(str(self._speed)))
        loop = LoopThread()
        clock = ManualClock(loop, pacer) if isinstance(pacer, ManualPacer) else ServedClock(loop, pacer)
        self._served = _Service(loop, Server(self.bench, pacer=pacer), clock)
        try:
            for writer in self._writers:
                self._written.enter_context(writer(self.bench))
            for name, url in self._wanted:
                found = loop.run(self._served.server.open(name, url))
                self.ports.setdefault(name, _url(found))
            self.do(self._served.server.start)
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.do(self._written.close)
            for controller in self.bench.controllers.values():
                self.do(lambda controller=controller: controller.power(False))  # type: ignore[misc]
        finally:
            self._close()
        for problem in self._service.loop.problems:
            if error is None and not isinstance(problem.get("exception"), OSError):
                raise problem.get("exception") or RuntimeError(problem["message"])

    def _close(self) -> None:
        self.do(self._service.server.close)
        self._service.loop.stop()

    def advance(self, seconds: float) -> None:
        """With `speed="manual"`: let so much virtual time pass.  What hosts have sent before is heard first."""
        self.clock.advance(seconds)

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Let time pass until `condition()` is true or `timeout` seconds have passed; tells which.

        Virtual seconds with `speed="manual"`, real ones otherwise.
        """
        return self.clock.run_until(condition, timeout)

    def start(self, function: Callable[..., Any], *arguments: Any, **keywords: Any) -> HostCall:
        """Let a host do something in a thread of its own; `result` of what this returns lets it come to its end.

        With `speed="manual"`, whenever time is about to pass the host is first given all the (real) time it takes to
        wait for something.
        """
        thread = HostThread(function, arguments, keywords)
        self.clock.add(thread)
        thread.start()
        return HostCall(self.clock, thread)

    def call(self, function: Callable[..., T], *arguments: Any, **keywords: Any) -> T:
        """Let a host do something that waits for answers: virtual time passes while it waits.  Returns its result."""
        result: T = self.start(function, *arguments, **keywords).result()
        return result

    def do(self, action: Callable[[], T]) -> T:
        """Do something with the bench in the thread that it belongs to, now: at a number as speed, by the wall clock.

        What is due by then has happened before, what is due because of it happens at once.
        """

        def act() -> T:
            service.server.pacer.sync()
            result = action()
            service.server.pacer.work()
            return result

        service = self._service
        return service.loop.do(act)


def serve(
    what: str | Path | Mapping[str, Any] | Bench,
    *,
    speed: Speed = 1.0,
    scheme: Literal["tcp", "rfc2217", "pty"] | None = None,
    fixed_ports: bool = False,
    record: str | Path | None = None,
    trace: str | Path | None = None,
    **options: Any,
) -> Twin:
    """Put controllers on real ports of this machine while a `with` block lasts.

    `what`: a model, a scene (its path, or a dict with what the file would have), or a Bench.  `speed`: times real
    time, "max" for as fast as it goes, or "manual": virtual time passes only when told.  `scheme`: the kind of port;
    else that of the scene, else "tcp".  Ports are free ones of this machine, unless `fixed_ports` asks for those that
    the scene names.  `record`, `trace`: files that are written meanwhile.  `options`: of the model, as `Bench.add` has
    them.  Raises UsageError, SceneError; LinkError on entering.
    """
    _check_speed(speed)
    bench, named = _bench(what, options)
    wanted = [(name, parse(url)) for name, url in named]
    if not fixed_ports:
        wanted = _free(bench, wanted, scheme)
    elif not wanted:
        raise UsageError("fixed_ports=True is for a scene that names ports, and this has none: leave it out")
    return Twin(bench, wanted, speed, tuple(_writers(record, trace, _headers(what, options))))


def _check_speed(speed: Speed) -> None:
    """Raises UsageError if there is no such speed."""
    if speed != "manual":
        try:
            read_speed(str(speed))
        except UsageError as error:
            raise UsageError(f'{error}, or "manual"') from None


def _bench(
    what: str | Path | Mapping[str, Any] | Bench, options: dict[str, Any]
) -> tuple[Bench, list[tuple[str, str]]]:
    """The bench, and the ports that its scene names."""
    if isinstance(what, str) and not what.endswith(".toml"):
        bench = Bench()
        bench.add(what, **options)
        return bench, []
    if options:
        raise UsageError(f"{', '.join(options)}: options are for a model; write them into the scene")
    if isinstance(what, Bench):
        return what, []
    from axistwin.scenes.scene import Scene  # late: brings pydantic along

    scene = Scene.given(what) if isinstance(what, Mapping) else Scene.load(what)
    return scene.build(served=True), scene.ports


def _free(bench: Bench, wanted: list[tuple[str, PortUrl]], scheme: str | None) -> list[tuple[str, PortUrl]]:
    """Any free port for everyone, of the kind that is asked for.  Raises UsageError."""
    if scheme is not None and scheme not in SCHEMES:
        raise UsageError(f"no kind of port {scheme!r}: there are {', '.join(SCHEMES)}")
    kinds = {name: url.scheme for name, url in reversed(wanted) if url.scheme in ANYWHERE}
    found = []
    for name in endpoints.names(bench):
        kind = "bus" if endpoints.at_a_bus(bench, name) else scheme or kinds.get(name, "tcp")
        found.append((name, parse(ANYWHERE[kind])))
    return found


def _writers(record: str | Path | None, trace: str | Path | None, headers: dict[str, str] | None) -> Iterator[Writer]:
    if record is not None:
        from axistwin.conversations.recorder import recording_to  # late, as not everybody asks for it

        yield partial(recording_to, path=Path(record), headers=headers)
    if trace is not None:
        from axistwin.traces.trace import tracing

        yield partial(tracing, path=Path(trace))


def _headers(what: object, options: dict[str, Any]) -> dict[str, str] | None:
    """What a recording says it is of; of a scene that is left to its reader."""
    if not isinstance(what, str) or what.endswith(".toml"):
        return None
    kept = {name: value for name, value in options.items() if name not in ("name", "state", "line", "history")}
    words = [f"{name}={toml_value(value)}" for name, value in kept.items()]
    return {"model": what, "options": shlex.join(words), "line": str(options.get("line") or "")}


def _url(found: PortUrl) -> Url:
    """A port as pyserial knows it."""
    schemes = {"tcp": "socket", "rfc2217": "rfc2217", "bus": "bus"}
    return Url(f"{schemes[found.scheme]}://{found.address}" if found.scheme in schemes else found.path)
