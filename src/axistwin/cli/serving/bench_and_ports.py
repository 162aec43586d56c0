"""The bench and the ports of `axistwin serve`."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from axistwin.bench import Bench, endpoints
from axistwin.core.errors import UsageError
from axistwin.links.urls import EXAMPLES, PortUrl, parse

if TYPE_CHECKING:
    from axistwin.scenes.scene import Scene

ANY_PORT, ANY_BUS_PORT = "tcp://127.0.0.1:0", "bus://127.0.0.1:0"

Ports = list[tuple[str, PortUrl]]


class Served(NamedTuple):
    """A model or a scene with its ports.  Each call of `build` returns a new bench."""

    title: str
    build: Callable[[], Bench]
    ports: Callable[[Bench], Ports]  # Names and URLs of ports.  Raises UsageError for impossible ports.
    scene: "Scene | None" = None  # The scene; None for a model.

    @property
    def waits(self) -> bool:
        """True if virtual time starts when the first browser or host connects."""
        return self.scene is not None and self.scene.waits


def model(name: str, given: list[PortUrl], second: list[PortUrl], options: Mapping[str, Any]) -> Served:
    """Return a model to serve on the given ports, or on any free port."""

    def build() -> Bench:
        bench = Bench()
        made = bench.add(name, **options)
        if second:
            # The motor creates its RS-485 channel when this channel is first requested.
            bench.port(f"{made.name}.rs485")
        return bench

    def ports(bench: Bench) -> Ports:
        only = next(iter(bench.controllers))
        return [(only, url) for url in given or [_any_port(bench, only)]] + [(f"{only}.rs485", url) for url in second]

    return Served(name, build, ports)


def scene(path: str, given: list[PortUrl], *, alone: bool) -> Served:
    """Load a scene.  `given`: ports that replace the scene's own; `alone`: the scene may have no ports."""
    # Import `Scene` only for a scene file (.toml), not for a model name such as if1, because the import is slow.
    from axistwin.scenes.scene import Scene

    loaded = Scene.load(Path(path))

    def ports(bench: Bench) -> Ports:
        names = [name for name in endpoints.names(bench) if name not in loaded.hosted]
        if not names and not alone:
            name, controller = next(iter(bench.controllers.items()))
            url = EXAMPLES["tcp" if controller.product.line is not None else "bus"]
            raise UsageError(
                f"no controller in {path} has a port for an external host: "
                f'add the key `ports` to a controller, e.g. to {name}: ports = ["{url}"]'
            )
        if not given:
            named = [(name, parse(url)) for name, url in loaded.ports]
            return named or [(name, _any_port(bench, name)) for name in names]
        if len(names) != 1:
            raise UsageError(f"{path} has several controllers: set the ports of each controller in the scene file")
        return [(name, url) for name in names for url in given]

    return Served(loaded.title or path, partial(loaded.build, served=True), ports, loaded)


def _any_port(bench: Bench, name: str) -> PortUrl:
    return parse(ANY_BUS_PORT if endpoints.at_a_bus(bench, name) else ANY_PORT)
