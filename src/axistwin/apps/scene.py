"""A scene: controllers with their machines, the wires between them and the ports they are reached at, as a TOML file.

    [[controller]]                      # as many as you like
    model = "if2"
    name = "table"
    ports = ["tcp://127.0.0.1:5001"]
    options.wiring = "3-wire"           # what `Bench.add` takes for this model
    axes.X.limits = [-100, 20_000]      # beyond these positions a limit switch opens

    [[wire]]
    from = "table.output1"
    to = "table.input1"
    delay_ms = 250

    [[chain]]                           # SmartMotors on one RS232 line
    motors = ["left", "right"]
    ports = ["tcp://127.0.0.1:5002"]

All keys are told in `docs/scenes.md`, and to editors by the JSON Schema that `Scene.schema()` returns.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, Self

from axistwin.apps import toml_places
from axistwin.apps.scene_source import Source, instead
from axistwin.apps.scene_tables import ControllerTable, LineTable, SceneFile
from axistwin.bench import Bench, Controller, line_format, product
from axistwin.links.urls import parse as parse_url
from axistwin.sim.pins import Pin, connect
from axistwin.units import to_ns


class Scene:
    """A scene that has been read and checked.  `build` puts it on a bench."""

    def __init__(self, contents: SceneFile, source: Source) -> None:
        self._contents, self._source = contents, source
        self._check_names()
        self._check_ports()
        self._check_wires()

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a scene file.  Raises SceneError with file, line, column and what to do."""
        source = Source(Path(path))
        return cls(source.contents(), source)

    @staticmethod
    def schema() -> dict[str, Any]:
        """The JSON Schema of a scene file."""
        return SceneFile.model_json_schema()

    @property
    def ports(self) -> list[tuple[str, str]]:
        """Where a host is to reach whom: the name of a controller, its second channel or a line, and a URL."""
        found = [(table.called, url) for table in self._contents.controller for url in table.ports]
        found += [(f"{table.called}.rs485", url) for table in self._contents.controller for url in table.rs485_ports]
        return found + [(name, url) for _, name, table, _ in self._lines() for url in table.ports]

    def build(self) -> Bench:
        """A new bench with everything on it; the controllers have just been switched on."""
        bench = Bench()
        for number, table in enumerate(self._contents.controller):
            self._add(bench, table, ("controller", number))
        for number, wire in enumerate(self._contents.wire):
            source = self._pin(bench, wire.from_, ("wire", number, "from"))
            target = self._pin(bench, wire.to, ("wire", number, "to"))
            connect(source, target, invert=wire.invert, delay_ns=to_ns(wire.delay_ms / 1000))
        for kind, name, line, path in self._lines():
            motors = [self._motor(bench, motor, (*path, "motors", n)) for n, motor in enumerate(line.motors)]
            with self._source.blaming(*path):
                (bench.chain if kind == "chain" else bench.rs485)(*motors, name=name)
        for number, table in enumerate(self._contents.controller):
            if table.rs485_ports:
                with self._source.blaming("controller", number, "rs485_ports"):
                    bench.port(f"{table.called}.rs485")
        return bench

    def _lines(self) -> Iterator[tuple[str, str, LineTable, toml_places.Path]]:
        """The lines that motors share: kind, name, table and place."""
        for kind, tables in (("chain", self._contents.chain), ("rs485", self._contents.rs485)):
            for number, table in enumerate(tables):
                yield kind, table.name or (kind if not number else f"{kind}-{number + 1}"), table, (kind, number)

    def _motor(self, bench: Bench, name: str, path: toml_places.Path) -> Controller:
        if name not in bench.controllers:
            raise self._source.error(path, f"no controller {name!r}: {instead(name, bench.controllers)}")
        return bench[name]

    def _add(self, bench: Bench, table: ControllerTable, path: toml_places.Path) -> None:
        with self._source.blaming(*path, "model"):
            made = product(table.model)
        with self._source.blaming(*path, "line"):
            if made.line is not None:
                line_format(table.line, made.line)
        self._check_keys((*path, "options"), table.options, [field.name for field in fields(made.options)])
        self._check_keys((*path, "axes"), table.axes, made.axes)
        given = table.model_dump(include={"line", "history"}, exclude_none=True)
        if table.state is not None:
            given["state"] = self._source.file.parent / table.state
        axes = table.model_dump(include={"axes"}, exclude_none=True)["axes"]
        keys = {**dict.fromkeys(table.options, "options"), **dict.fromkeys(axes, "axes")}
        with self._source.blaming_one_of(path, keys):
            bench.add(table.model, table.called, **given, **table.options, **axes)

    def _check_keys(self, path: toml_places.Path, given: Iterable[str], known: Collection[str]) -> None:
        for key in given:
            if key not in known:
                raise self._source.error((*path, key), f"{path[-1]}: unknown key {key!r}: {instead(key, known)}")

    def _pin(self, bench: Bench, terminal: str, path: toml_places.Path) -> Pin:
        name, _, pin = terminal.rpartition(".")
        if not name:
            raise self._source.error(path, f"no terminal {terminal!r}: write it as NAME.PIN")
        if name not in bench.controllers:
            raise self._source.error(path, f"no controller {name!r}: {instead(name, bench.controllers)}")
        pins = bench[name].pins
        if pin not in pins:
            raise self._source.error(path, f"{name} has no pin {pin!r}: {instead(pin, pins)}")
        return pins[pin]

    # What a table by itself cannot tell

    def _check_names(self) -> None:
        count: Counter[str] = Counter()
        for number, table in enumerate(self._contents.controller):
            count[table.called] += 1
            if count[table.called] > 1:
                key = "model" if table.name is None else "name"
                message = f"there is a controller {table.called!r} already: give each a name of its own"
                raise self._source.error(("controller", number, key), message)

    def _check_ports(self) -> None:
        for number, table in enumerate(self._contents.controller):
            self._check_urls(("controller", number, "ports"), table.ports)
            self._check_urls(("controller", number, "rs485_ports"), table.rs485_ports)
        for _, _, line, path in self._lines():
            self._check_urls((*path, "ports"), line.ports)

    def _check_urls(self, path: toml_places.Path, urls: Iterable[str]) -> None:
        for which, url in enumerate(urls):
            with self._source.blaming(*path, which):
                parse_url(url)

    def _check_wires(self) -> None:
        """A terminal hangs on one wire at most, and wires do not go round in circles."""
        comes_from: dict[str, str] = {}
        for number, wire in enumerate(self._contents.wire):
            path = ("wire", number, "to")
            if wire.to in comes_from:
                raise self._source.error(path, f"{wire.to} hangs on a wire from {comes_from[wire.to]} already")
            comes_from[wire.to] = wire.from_
            at: str | None = wire.from_
            while at is not None:
                if at == wire.to:
                    raise self._source.error(path, f"these wires lead from {wire.to} back to itself: leave one out")
                at = comes_from.get(at)
