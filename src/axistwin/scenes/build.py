"""Puts what a scene file says on a bench, in the order in which one would build the machine.

Controllers with their axes and stored programs; what sits on whose shaft; wires; shared lines; faults; who does what at
which time; hosts.  Whatever cannot be is told with its place in the file.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from fractions import Fraction
from hashlib import sha256
from pathlib import Path

from axistwin.bench import Bench, Controller, endpoints, line_format, product
from axistwin.bench.action_runner import Hands
from axistwin.bench.actions import FAULT_ACTS
from axistwin.bench.acts import Do
from axistwin.conversations.conversation import parse_line
from axistwin.errors import UsageError
from axistwin.fault_injection.injector import Terms, free_name
from axistwin.fault_injection.kinds import KINDS, kind_of
from axistwin.fault_injection.sentences import name_in
from axistwin.fault_injection.triggers import other_fault
from axistwin.plant.axes import Axis
from axistwin.programs import stored_programs
from axistwin.scenes import hosting, toml_places
from axistwin.scenes.source import Source, instead
from axistwin.scenes.tables import ControllerTable, FaultTerms, SceneFile, ScriptTable, WireTable, shared_lines
from axistwin.sim.pins import Pin, connect
from axistwin.units import to_ns

Path_ = toml_places.Path
FAULTS_A_SCENE = 1_000
"""So far apart are the seeds of two scenes."""


def comes_back(name: str, leads_to: Mapping[str, str | None]) -> bool:
    """Whether one comes back to where one has begun."""
    at, seen = leads_to.get(name), {name}
    while at is not None and at not in seen:
        seen.add(at)
        at = leads_to.get(at)
    return at == name


def _check_way(source: Pin, target: Pin, wire: WireTable, laid: Mapping[Pin, tuple[Pin, WireTable]]) -> None:
    """A terminal is at the end of one wire at most, whatever name it is given, and wires do not form a circle.

    Raises UsageError.
    """
    if target in laid:
        other = laid[target][1]
        same = "" if other.to == wire.to else f" is the same terminal as {other.to}, which"
        raise UsageError(f"{wire.to}{same} hangs on a wire from {other.from_} already")
    at: Pin | None = source
    while at is not None:
        if at is target:
            raise UsageError(f"these wires lead from {wire.to} back to itself: leave one out")
        at = laid[at][0] if at in laid else None


class Builder:
    """One bench in the making.

    `served`: hosts come from outside where there are ports for them.  `texts`: programs that have been read before, by
    their names, so that each bench of a scene is the same.
    """

    def __init__(self, contents: SceneFile, source: Source, served: bool, texts: dict[str, str]) -> None:
        self.contents, self.source, self.served, self.texts = contents, source, served, texts
        self.bench = Bench()
        load = hosting.loader(self.bench, lambda file: self._text(str(self._beside(Path(file)))))
        self._hands = Hands(self.bench, load, own=True)

    def build(self) -> Bench:
        """All of it; the controllers have just been switched on."""
        self._tell_origin()
        self._add_controllers()
        self._join_shafts()
        self._lay_wires()
        self._share_lines()
        self._open_second_channels()
        self._plan_faults()
        self._plan_script()
        self._start_hosts()
        return self.bench

    def _tell_origin(self) -> None:
        digest = sha256(self.source.text.encode()).hexdigest()
        self.bench.origin["scene"] = f"{self.source.file.name} sha256:{digest[:16]}"
        if self.contents.seed is not None:
            self.bench.origin["seed"] = str(self.contents.seed)

    # Controllers

    def _add_controllers(self) -> None:
        for number, table in enumerate(self.contents.controller):
            path: Path_ = ("controller", number)
            self._add(table, path)
            if table.program is not None:
                self._store(self.bench[table.called], table.program, (*path, "program"))

    def _add(self, table: ControllerTable, path: Path_) -> None:
        made = product(table.model)
        with self.source.placing_errors(*path, "line"):
            if made.line is not None:
                line_format(table.line, made.line)
        self._check_keys((*path, "options"), table.options, [field.name for field in fields(made.options)])
        self._check_keys((*path, "axes"), table.axes, made.axes)
        given = table.model_dump(include={"line", "history"}, exclude_none=True)
        if table.state is not None:
            given["state"] = self._beside(table.state)
        axes = table.model_dump(include={"axes"}, exclude_none=True)["axes"]
        with self.source.placing_errors_at_key(path, ("axes", axes), ("options", table.options), ("", given)):
            self.bench.add(table.model, table.called, **given, **table.options, **axes)

    def _check_keys(self, path: Path_, given: Iterable[str], known: Collection[str]) -> None:
        for key in given:
            if key not in known:
                raise self.source.error((*path, key), f"{path[-1]}: unknown key {key!r}: {instead(key, known)}")

    def _store(self, motor: Controller, program: Path, path: Path_) -> None:
        with self.source.placing_errors(*path):
            stored_programs.check_motor(motor)
            source = stored_programs.as_sent(self._text(str(self._beside(program))))
            stored_programs.store(source, str(program), motor)

    # What connects them

    def _join_shafts(self) -> None:
        for number, table in enumerate(self.contents.controller):
            if table.master is not None:
                path: Path_ = ("controller", number, "master")
                axis = self._axis(table.master, path)
                with self.source.placing_errors(*path):
                    self.bench[table.called].master.follow(axis, Fraction(*table.master_ratio))

    def _lay_wires(self) -> None:
        laid: dict[Pin, tuple[Pin, WireTable]] = {}
        for number, wire in enumerate(self.contents.wire):
            source = self._pin(wire.from_, ("wire", number, "from"))
            target = self._pin(wire.to, ("wire", number, "to"))
            self._check_direction(number, wire)
            with self.source.placing_errors("wire", number, "to"):
                _check_way(source, target, wire, laid)
            laid[target] = source, wire
            with self.source.placing_errors("wire", number, "delay_ms"):
                connect(source, target, invert=wire.invert, delay_ns=to_ns(wire.delay_ms / 1000))

    def _check_direction(self, number: int, wire: WireTable) -> None:
        """From what tells of its changes, to what does not decide about its level itself."""
        from_, to = wire.from_, wire.to
        if self._pin(from_, ("wire", number, "from")).silent:
            message = f"no wire can follow the pulses of {from_}: let a motor's `master` sit on that axis"
            raise self.source.error(("wire", number, "from"), message)
        if self._pin(to, ("wire", number, "to")).is_output:
            message = f"{to} is an output, to which no wire can lead: lead it to an input, or away from {to}"
            raise self.source.error(("wire", number, "to"), message)

    def _share_lines(self) -> None:
        for kind, name, line, path in shared_lines(self.contents):
            motors = [self._motor(motor, (*path, "motors", n)) for n, motor in enumerate(line.motors)]
            with self.source.placing_errors(*path):
                (self.bench.chain if kind == "chain" else self.bench.rs485)(*motors, name=name)

    def _open_second_channels(self) -> None:
        for number, table in enumerate(self.contents.controller):
            if table.rs485_ports:
                with self.source.placing_errors("controller", number, "rs485_ports"):
                    self.bench.port(f"{table.called}.rs485")

    def _motor(self, name: str, path: Path_) -> Controller:
        if name not in self.bench.controllers:
            raise self.source.error(path, f"no controller {name!r}: {instead(name, self.bench.controllers)}")
        return self.bench[name]

    def _pin(self, terminal: str, path: Path_) -> Pin:
        name, _, pin = terminal.rpartition(".")
        if not name:
            raise self.source.error(path, f"no terminal {terminal!r}: write it as NAME.PIN")
        pins = self._motor(name, path).pins
        if pin not in pins:
            raise self.source.error(path, f"{name} has no pin {pin!r}: {instead(pin, pins)}")
        return pins[pin]

    def _axis(self, whole: str, path: Path_) -> Axis:
        name, _, axis = whole.rpartition(".")
        if not name:
            raise self.source.error(path, f"no axis {whole!r}: write it as NAME.AXIS")
        axes = self._motor(name, path).axes
        if axis not in axes:
            raise self.source.error(path, f"{name} has no axis {axis!r}: {instead(axis, axes)}")
        return axes[axis]

    # What happens

    def _plan_faults(self) -> None:
        tables: list[FaultTerms] = self.contents.fault
        names = self._names_of(tables)
        self.bench.faults.announced = (*names, *self._scripted())
        self._check_waiting(names, tables)
        for number, table in enumerate(tables):
            self._plan_fault(table, number, ("fault", number))

    def _names_of(self, tables: Iterable[FaultTerms]) -> list[str]:
        names: list[str] = []
        for table in tables:
            names.append(table.name or free_name(table.kind, names))
        return names

    def _scripted(self) -> list[str]:
        """Names that the script gives to faults."""
        named = (name_in(act) for table in self.contents.script for act in table.do)
        return [name for name in named if name is not None]

    def _check_waiting(self, names: Sequence[str], tables: Sequence[FaultTerms]) -> None:
        """Faults do not wait for one another in circles: none would ever begin."""
        waits_for = {name: other_fault(table.when) for name, table in zip(names, tables, strict=True)}
        for number, name in enumerate(names):
            if comes_back(name, waits_for):
                way = f", by way of {waits_for[name]}" if waits_for[name] != name else ""
                message = f"{name} waits for itself{way}: let it wait for something else"
                raise self.source.error(("fault", number, "when"), message)

    def _plan_fault(self, table: FaultTerms, number: int, path: Path_) -> None:
        faults, on = self.bench.faults, table.on or self._only()
        with self.source.placing_errors(*path, "kind"):
            kind = kind_of(table.kind)
        with self.source.placing_errors(*path, "on" if table.on else "kind"):
            kind.check(faults.spot(kind, on, self._only()))
        with self.source.placing_errors(*path, "when"):
            faults.trigger(table.when, self._only())
        with self.source.placing_errors_at_key(path, ("", table.model_dump(exclude_none=True, exclude={"kind", "on"}))):
            seed = self._seed(table, number)
            terms = Terms(table.name, table.at, table.when, table.nth, table.duration, seed, self._only())
            faults.plan(table.kind, on, terms, table.parameters)()

    def _seed(self, table: FaultTerms, number: int) -> int | None:
        """Its own, or one that follows from the scene's and is another for each fault."""
        whole = self.contents.seed
        return table.seed if table.seed is not None or whole is None else FAULTS_A_SCENE * whole + number

    def _plan_script(self) -> None:
        for number, table in enumerate(self.contents.script):
            with self.source.placing_errors("script", number, "at"):
                at_ns = to_ns(table.at)
            acts = []
            for which, text in enumerate(table.do):
                path: Path_ = ("script", number, "do", which)
                with self.source.placing_errors(*path):
                    acts.append((path, self._act(table, text)))
            self._plan_acts(at_ns, acts)

    def _plan_acts(self, at_ns: int, acts: Sequence[tuple[Path_, Callable[[], object]]]) -> None:
        """When everything else has happened that is due then.  What cannot be is told with its place.

        Nobody waits for it: who types a program's lines goes on.
        """
        clock = self.bench.clock

        def happen() -> None:
            clock.background -= 1
            for path, do in acts:
                with self.source.placing_errors(*path):
                    do()

        clock.background += 1
        clock.after_all(at_ns, happen, rank=hosting.SCRIPT)
        self.bench.agenda_ns = max(self.bench.agenda_ns, at_ns)

    def _act(self, table: ScriptTable, text: str) -> Callable[[], object]:
        act = parse_line(f"! {text}", 0, "")
        assert isinstance(act, Do), "that is what ! means"
        here = table.on or self._only()
        if here and here not in (*self.bench.controllers, *endpoints.names(self.bench)):
            raise UsageError(f"no controller {here!r}: {instead(here, self.bench.controllers)}")
        if act.target == "mend":
            self._check_mend(act.value)
        if not here and act.target not in FAULT_ACTS:
            raise UsageError(f"whose is that? Say on = one of {', '.join(self.bench.controllers)}")
        return self._hands.prepare(Do(act.target, act.value, controller=here))

    def _check_mend(self, name: str) -> None:
        """Faults of the script are there when their time has come."""
        if name not in (*self.bench.faults.names, *KINDS, *self._scripted(), "all"):
            raise UsageError(f"no fault {name!r} here: there are {', '.join(self.bench.faults.names) or 'none'}")

    def _only(self) -> str:
        """The name of the only controller, if there is one only."""
        return next(iter(self.bench.controllers)) if len(self.bench.controllers) == 1 else ""

    def _start_hosts(self) -> None:
        for path, name, file in self._hosts():
            with self.source.placing_errors(*path):
                hosting.prepared(self.bench, name, str(self._beside(file)), self._text, self._hands)()

    def _hosts(self) -> Iterator[tuple[Path_, str, Path]]:
        """Those that live here: where the file says so, whom they talk to, and what."""
        for number, table in enumerate(self.contents.controller):
            if not (self.served and table.ports):
                for which, file in enumerate(table.host):
                    yield ("controller", number, "host", which), table.called, file
        for _, name, line, place in shared_lines(self.contents):
            if not (self.served and line.ports):
                for which, file in enumerate(line.host):
                    yield (*place, "host", which), name, file

    def _text(self, file: str) -> str:
        """Of a program."""
        if file not in self.texts:
            self.texts[file] = hosting.program_text(Path(file))
        return self.texts[file]

    def _beside(self, path: Path) -> Path:
        """As seen from the scene file."""
        return self.source.file.parent / path
