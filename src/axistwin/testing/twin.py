"""`axistwin.serve`: controllers on real ports within a `with` block, for tests of host programs.

    import axistwin, serial

    with axistwin.serve("if1", speed="manual") as twin:
        host = serial.serial_for_url(twin.ports["if1"], timeout=5)
        twin.advance(1.5)               # the controller has just been switched on
        host.write(b"(")
        twin.advance(0.1)
        assert host.read(2) == b"U\\r"

A thread serves the ports and owns the bench.  With `speed="manual"` virtual time passes only in `advance`, `run_until`
and `call`; between these calls a test may read and change the bench directly.  At other speeds use `do`.
"""

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self, TypeVar

from axistwin.bench import Bench, endpoints
from axistwin.bench.models import Model, product
from axistwin.controllers.product import Product
from axistwin.core.errors import UsageError
from axistwin.links.host_thread import HostThread
from axistwin.links.loop_thread import LoopThread
from axistwin.links.manual_clock import ManualClock, ServedClock
from axistwin.links.manual_pacer import ManualPacer
from axistwin.links.pacing import Pacer, read_speed
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse
from axistwin.scenes.diagnostics.refused_lines import RefusedLines
from axistwin.scenes.toml_text import toml_value

T = TypeVar("T")
Writer = Callable[[Bench], AbstractContextManager[object]]
"""Context manager that records a bench to a file."""
Speed = float | Literal["manual", "max"]
FREE_PORTS = {"tcp": "tcp://127.0.0.1:0", "rfc2217": "rfc2217://127.0.0.1:0", "pty": "pty:", "bus": "bus://127.0.0.1:0"}
SCHEMES = ("tcp", "rfc2217", "pty")
HOST_TIMEOUT_S = 10.0
STOOD_STILL = (
    "virtual time has stood still since the host's last data, so that no answer could come: call the host by "
    "twin.call, e.g. twin.call(host.read, 2), or let time pass by twin.advance"
)


class Url(str):
    """URL of a port for `serial.serial_for_url`; for an 1810 or 1811, `bus://host:port`."""

    __slots__ = ()

    @property
    def address(self) -> str:
        """Address of the port as `host:port`, for EPICS asyn."""
        return self.partition("://")[2]

    @property
    def host(self) -> str:
        """Host name or IP address in the URL of the served port, e.g. `127.0.0.1`."""
        return self.address.rpartition(":")[0].strip("[]")

    @property
    def port(self) -> int:
        """Number of the emulated controller's TCP port, e.g. 5001."""
        return int(self.address.rpartition(":")[2])

    @property
    def visa(self) -> str:
        """Name of the port as a PyVISA resource, e.g. `TCPIP0::127.0.0.1::5001::SOCKET`."""
        return f"TCPIP0::{self.host}::{self.port}::SOCKET" if "://" in self else f"ASRL{self}::INSTR"


class HostCall:
    """A Python function that acts as the host and runs in its own thread."""

    def __init__(self, clock: ServedClock, thread: HostThread) -> None:
        self._clock, self._thread = clock, thread

    @property
    def done(self) -> bool:
        """True after the host's function has returned or raised an exception."""
        return self._thread.done

    def result(self, timeout: float = HOST_TIMEOUT_S) -> Any:
        """Wait for the function.  Returns the result, or raises the exception.

        With `speed="manual"` virtual time passes while the function waits.  Raises LinkError after `timeout`
        (virtual) seconds without any communication.
        """
        return self._clock.wait_for(self._thread, timeout)


class _Service(NamedTuple):
    loop: LoopThread
    server: Server
    clock: ServedClock


class Twin:
    """Emulated controllers that are served on real ports within a `with` block.  `serve` returns a Twin."""

    def __init__(
        self, bench: Bench, wanted: list[tuple[str, PortUrl]], speed: Speed, writers: Iterable[Writer] = ()
    ) -> None:
        self.bench = bench
        """The bench with the virtual machines: `bench["if1"].axes["X"].position`."""
        self.ports: dict[str, Url] = {}
        """URLs of controllers, second channels and lines of motors, by name."""
        self._wanted, self._speed, self._writers = wanted, speed, writers
        self._written, self._refused = ExitStack(), RefusedLines()
        self._served: _Service | None = None

    @property
    def clock(self) -> ServedClock:
        """Clock that gives the virtual time of the served controllers."""
        return self._service.clock

    @property
    def _service(self) -> _Service:
        if self._served is None:
            raise UsageError(
                'the ports of the twin are not open: use a `with` block, e.g. `with axistwin.serve("if1") as twin:`'
            )
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
                self.ports.setdefault(name, _url(loop.run(self._served.server.open(name, url))))
            self._written.callback(self._refused.close)
            self._written.callback(self.do(partial(self._refused.watch, self.bench)))
            self.do(self._served.server.start)
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if error is not None:
            for note in self.notes():
                error.add_note(f"axistwin: {note}")
        try:
            self.do(self._written.close)
            for controller in self.bench.controllers.values():
                self.do(lambda controller=controller: controller.power(False))  # type: ignore[misc]
        finally:
            self._close()
        for problem in self._service.loop.problems:
            if error is None and not isinstance(problem.get("exception"), OSError):
                raise problem.get("exception") or RuntimeError(problem["message"])

    def notes(self) -> list[str]:
        """Return what may explain a failure: why a controller does not move, and that virtual time has stood still."""

        def read() -> list[str]:
            hints = [f"{name}: {made.hint}" for name, made in self.bench.controllers.items() if made.hint]
            stands = self._speed == "manual" and self._service.server.heard_ns == self.bench.clock.now
            return hints + [STOOD_STILL] * stands

        pacer = self._service.server.pacer
        if isinstance(pacer, ManualPacer):
            self._service.loop.run(pacer.receive_all())
        return self._service.loop.do(read)

    def _close(self) -> None:
        self.do(self._service.server.close)
        self._service.loop.stop()

    def advance(self, seconds: float) -> None:
        """Receive all data that hosts have sent, then advance virtual time by `seconds`.  Only for `speed="manual"`."""
        self.clock.advance(seconds)

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Advance time until `condition()` is true, and return True; return False after `timeout` seconds.

        `timeout` is in virtual seconds with `speed="manual"`, otherwise in real seconds.
        """
        return self.clock.run_until(condition, timeout)

    def start(self, function: Callable[..., Any], *arguments: Any, **keywords: Any) -> HostCall:
        """Start a function of the host program in a separate thread, and return a `HostCall` of this function.

        With `speed="manual"`, virtual time passes only while the function is blocked.
        """
        thread = HostThread(function, arguments, keywords)
        self.clock.add(thread)
        thread.start()
        return HostCall(self.clock, thread)

    def call(self, function: Callable[..., T], *arguments: Any, **keywords: Any) -> T:
        """Return the result of a host's function; virtual time passes while it waits for answers."""
        result: T = self.start(function, *arguments, **keywords).result()
        return result

    def do(self, action: Callable[[], T]) -> T:
        """Call a function in the thread of the simulation, at the present virtual time.

        If `speed` is a number, the present time is that of the wall clock.  All events due by then are executed
        before the call, and all events that the call makes due are executed after it.
        """

        def act() -> T:
            service.server.pacer.sync()
            result = action()
            service.server.pacer.work()
            return result

        service = self._service
        return service.loop.do(act)


def serve(
    what: "Model | Path | Mapping[str, Any] | Bench", *, speed: Speed = 1.0,
    scheme: Literal["tcp", "rfc2217", "pty"] | None = None, fixed_ports: bool = False, record: str | Path | None = None,
    trace: str | Path | None = None, **options: Any,
) -> Twin:  # fmt: skip
    """Connect controllers to ports of this computer for the duration of a `with` block.

    `what`: a model by name or class, a scene (a path, or a dict with the contents of a scene file), or a Bench.
    `speed`: times real time; "max": as fast as possible; "manual": virtual time passes only on request.  `scheme`: the
    kind of port; default: that of the scene, or "tcp".  Free ports are used, or with `fixed_ports` those of the scene.
    `record`, `trace`: files to write.  `options`: options of the model, see `Bench.add`.  Raises UsageError,
    SceneError; LinkError on entering the block.
    """
    _check_speed(speed)
    bench, named = _bench(what, options)
    wanted = [(name, parse(url)) for name, url in named]
    if not fixed_ports:
        wanted = _free(bench, wanted, scheme)
    elif not wanted:
        raise UsageError("no ports for the option fixed_ports=True: expected a scene that defines ports")
    return Twin(bench, wanted, speed, tuple(_writers(record, trace, _headers(what, options))))


def _check_speed(speed: Speed) -> None:
    if speed != "manual":
        try:
            read_speed(str(speed))
        except UsageError:
            raise UsageError(f'invalid speed {speed!r}: expected a number, "max" or "manual", e.g. 1.0') from None


def _bench(
    what: "Model | Path | Mapping[str, Any] | Bench", options: dict[str, Any]
) -> tuple[Bench, list[tuple[str, str]]]:
    if isinstance(what, type | Product) or (isinstance(what, str) and not what.endswith(".toml")):
        bench = Bench()
        bench.add(what, **options)
        return bench, []
    if options:
        raise UsageError(f"invalid options for a scene: {', '.join(options)}; only a model such as if1 accepts options")
    if isinstance(what, Bench):
        return what, []
    from axistwin.scenes.scene import Scene  # Only scenes need the library pydantic, which loads slowly.

    scene = Scene.given(what) if isinstance(what, Mapping) else Scene.load(what)
    return scene.build(served=True), scene.ports


def _free(bench: Bench, wanted: list[tuple[str, PortUrl]], scheme: str | None) -> list[tuple[str, PortUrl]]:
    """Return a URL for each serial port or bus of the simulation, e.g. `tcp://127.0.0.1:0`.

    For port 0, the operating system chooses a free port.  Raises UsageError for an unknown kind of port.
    """
    if scheme is not None and scheme not in SCHEMES:
        raise UsageError(f"invalid kind of port {scheme!r}: expected one of {', '.join(SCHEMES)}")
    kinds = {name: url.scheme for name, url in reversed(wanted) if url.scheme in FREE_PORTS}
    found = []
    for name in endpoints.names(bench):
        kind = "bus" if endpoints.at_a_bus(bench, name) else scheme or kinds.get(name, "tcp")
        found.append((name, parse(FREE_PORTS[kind])))
    return found


def _writers(record: str | Path | None, trace: str | Path | None, headers: dict[str, str] | None) -> Iterator[Writer]:
    if record is not None:
        from axistwin.bench.talk.recorder import recording_to

        yield partial(recording_to, path=Path(record), headers=headers)
    if trace is not None:
        from axistwin.records.traces.trace import tracing

        yield partial(tracing, path=Path(trace))


def _headers(what: object, options: dict[str, Any]) -> dict[str, str] | None:
    if isinstance(what, type | Product):
        what = product(what).model
    if not isinstance(what, str) or what.endswith(".toml"):
        return None
    kept = {name: value for name, value in options.items() if name not in ("name", "state", "line", "history")}
    words = [f"{name}={toml_value(value)}" for name, value in kept.items()]
    return {"model": what, "options": shlex.join(words), "line": str(options.get("line") or "")}


def _url(found: PortUrl) -> Url:
    schemes = {"tcp": "socket", "rfc2217": "rfc2217", "bus": "bus"}
    return Url(f"{schemes[found.scheme]}://{found.address}" if found.scheme in schemes else found.path)
