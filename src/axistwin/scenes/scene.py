"""A scene: controllers with their machines, the wires between the controllers, and their ports, as a TOML file.

    [[controller]]                      # as many as you like
    model = "if2"
    name = "table"
    ports = ["tcp://127.0.0.1:5001"]
    options.wiring = "3-wire"           # options of `Bench.add` for this model
    axes.X.limits = [-100, 20_000]      # beyond these positions a limit switch opens

    [[wire]]
    from = "table.output1"
    to = "table.input1"
    delay_ms = 250

    [[chain]]                           # SmartMotors on one RS232 line
    motors = ["left", "right"]
    ports = ["tcp://127.0.0.1:5002"]

    [[fault]]                           # faults
    kind = "lose"
    on = "table.serial"
    at = 12.5

    [[script]]                          # actions at the machine
    at = 3.0
    on = "table"
    do = ["input1 high", "X.load 0.2"]

`docs/scenes.md` lists all keys; `Scene.schema()` returns them as a JSON Schema for editors.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

from axistwin.bench import Bench, product
from axistwin.controllers.product import Product
from axistwin.controllers.registry import texts_of
from axistwin.core.errors import SceneError
from axistwin.scenes.addresses import check_ports
from axistwin.scenes.build import Builder, is_in_loop
from axistwin.scenes.source import Given, Source
from axistwin.scenes.tables import OperatorTable, SceneFile, StandInTable, shared_lines

if TYPE_CHECKING:
    from axistwin.scenes.copying import Copy


class Scene:
    """A scene file that has been read and checked."""

    def __init__(self, contents: SceneFile, source: Source) -> None:
        self._contents, self._source = contents, source
        self._texts: dict[str, str] = {}
        self._check_names()
        check_ports(contents, source)
        self._check_masters()

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a scene file.  Raises SceneError with file, line, column and remedy."""
        source = Source(Path(path))
        return cls(source.contents(), source)

    @classmethod
    def given(cls, table: Mapping[str, Any]) -> Self:
        """Create a scene from a dict, e.g. `{"controller": [{"model": "if1"}]}`.

        The dict has the keys of a scene file.  Raises SceneError, which names the wrong key.
        """
        source = Given(table)
        return cls(source.contents(), source)

    @staticmethod
    def schema() -> dict[str, Any]:
        """Return the JSON Schema of a scene file."""
        return SceneFile.model_json_schema()

    @property
    def title(self) -> str:
        """Title of the scene; "" if the scene has no title."""
        return self._contents.title

    @property
    def ports(self) -> list[tuple[str, str]]:
        """Names and URLs of the ports: the name of a controller, a second channel or a shared line."""
        found = [(table.called, url) for table in self._contents.controller for url in table.ports]
        found += [(f"{table.called}.rs485", url) for table in self._contents.controller for url in table.rs485_ports]
        return found + [(name, url) for _, name, table, _ in shared_lines(self._contents) for url in table.ports]

    @property
    def stand_in(self) -> StandInTable | None:
        """Settings for real motors from the table [stand-in]; None without this table."""
        return self._contents.stand_in

    @property
    def waits(self) -> bool:
        """True if virtual time starts only when the first browser or host connects."""
        return self._contents.panel.wait

    @property
    def operator(self) -> OperatorTable:
        """Buttons, lamps and selector switches of the operator panel; empty if the scene has none."""
        return self._contents.operator

    @property
    def file(self) -> Path:
        """The scene file.  Names of programs are relative to the folder of this file."""
        return self._source.file

    def placing_errors(self, *path: str | int) -> AbstractContextManager[None]:
        """Within a `with` block, convert a UsageError to a SceneError with the place of `path` in the file."""
        return self._source.placing_errors(*path)

    @property
    def hosted(self) -> set[str]:
        """Names of the controllers that have a simulated host and no ports."""
        return {table.called for table in self._contents.controller if table.host and not table.ports}

    @property
    def programs(self) -> dict[str, str]:
        """Texts of all programs in the folder of the scene, by path."""
        beside = self._source.file.parent
        named = {path.relative_to(beside): path for path in map(Path, self._texts) if path.is_relative_to(beside)}
        return {str(name): self._texts[str(path)] for name, path in named.items() if ".." not in name.parts}

    def named_programs(self) -> Iterator[tuple[str, Path]]:
        """Yield each program, host and conversation that the scene names: its endpoint and its file."""
        beside = self._source.file.parent
        for table in self._contents.controller:
            files = [*([table.program] if table.program else []), *table.host]
            yield from ((table.called, beside / file) for file in files)
        for _, name, line, _ in shared_lines(self._contents):
            yield from ((name, beside / file) for file in line.host)
        only = self._contents.controller[0].called if len(self._contents.controller) == 1 else ""
        for script in self._contents.script:
            loads = (text.split(maxsplit=1) for text in script.do)
            yield from (
                (script.on or only, beside / words[1]) for words in loads if words[:1] == ["load"] and words[1:]
            )

    @property
    def models(self) -> dict[str, Product]:
        """Dictionary with the names of serial ports and buses as keys, and the controller models as values.

        Examples of names: `table`, `table.rs485`, the name of a shared line.
        """
        found = {table.called: product(table.model).with_options(table.options) for table in self._contents.controller}
        found |= {f"{name}.rs485": made for name, made in found.items()}
        lines = ((name, line.motors[0]) for _, name, line, _ in shared_lines(self._contents))
        return found | {name: found[motor] for name, motor in lines if motor in found}

    @property
    def device_files(self) -> dict[str, str]:
        """Texts of the loaded Python files that the scene's models are in, by path."""
        return texts_of(table.model for table in self._contents.controller)

    def build(self, *, served: bool = False) -> Bench:
        """Build all controllers and machines of the scene; the controllers are switched on.

        Every call returns an equal bench.  `served`: True if hosts outside this process use the controllers with ports;
        their `host` files are then not sent.
        """
        return Builder(self._contents, self._source, served, self._texts).build()

    def build_errors(self) -> list[SceneError]:
        """Build the scene, and return all errors in its wires, faults, script and hosts.

        An error in a controller or a shared line is returned alone, because other parts refer to controllers.
        """
        errors: list[SceneError] = []
        try:
            Builder(self._contents, self._source, served=False, texts=self._texts, errors=errors).build()
        except SceneError as error:
            errors.append(error)
        return errors

    @property
    def data(self) -> Mapping[str, Any]:
        """Contents of the scene file as dicts, lists and values."""
        return self._source.data

    @property
    def text(self) -> str:
        """Text of the scene file."""
        return self._source.text

    def text_of(self, program: str) -> str:
        """Return the text of the program file at a path.  The scene must have been built before."""
        return self._texts[program]

    def varied(self, data: Mapping[str, Any], texts: Mapping[str, str] = MappingProxyType({})) -> Self:
        """Return the scene with other contents; `texts` replaces the texts of programs, by path.

        Raises SceneError with the place of an invalid value in the file.
        """
        source = self._source.with_data(dict(data))
        other = type(self)(source.contents(), source)
        other._texts = {**self._texts, **texts}
        return other

    def copied(self, copy: "Copy", served: bool, note: str) -> str:
        """Return the text of the scene with the hosts and the script of `copy`; needed files are added to `copy`."""
        copy.read.update(self._texts)
        return copy.of_scene(self._contents, self._source, served, note)

    # Checks that compare several TOML tables of the scene

    def _check_names(self) -> None:
        count: Counter[str] = Counter()
        for number, table in enumerate(self._contents.controller):
            count[table.called] += 1
            if count[table.called] > 1:
                raise self._source.error(
                    f"two controllers have the name {table.called!r}: expected different names",
                    ("controller", number, "model" if table.name is None else "name"),
                )

    def _check_masters(self) -> None:
        sits_on = {table.called: table.master.rpartition(".")[0] for table in self._contents.controller if table.master}
        for number, table in enumerate(self._contents.controller):
            if is_in_loop(table.called, sits_on):
                motor, axis = table.called, table.master
                raise self._source.error(
                    f"{motor} would follow its own shaft: expected an axis other than {axis} in the key `master`",
                    ("controller", number, "master"),
                )
