"""Build a bench from a scene file.

The parts are built in the order of a real machine: controllers with their axes and stored programs; encoders on shafts;
wires; shared lines; faults; the script; hosts.  Each error message has the place of the error in the scene file.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields
from fractions import Fraction
from hashlib import sha256
from pathlib import Path
from typing import TypeVar

from axistwin.bench import Bench, Controller, endpoints, line_format, product
from axistwin.bench.action_runner import ActionRunner
from axistwin.bench.actions import FAULT_ACTS
from axistwin.bench.acts import Do
from axistwin.bench.faults.injector import Terms, free_name
from axistwin.bench.faults.kinds import KINDS, kind_of
from axistwin.bench.faults.sentences import name_in
from axistwin.bench.faults.triggers import other_fault
from axistwin.bench.programs import stored_programs
from axistwin.bench.talk.conversation import parse_line
from axistwin.core.errors import SceneError, UsageError, instead
from axistwin.core.units import to_ns
from axistwin.plant.axes import Axis
from axistwin.scenes import hosting, toml_places
from axistwin.scenes.source import Source
from axistwin.scenes.tables import ControllerTable, FaultTerms, SceneFile, ScriptTable, WireTable, shared_lines
from axistwin.sim.pins import Pin, connect

Path_ = toml_places.Path
FAULTS_A_SCENE = 1_000  # Factor for the seed of a scene in the seeds of its faults.

T = TypeVar("T")


def is_in_loop(name: str, leads_to: Mapping[str, str | None]) -> bool:
    at, seen = leads_to.get(name), {name}
    while at is not None and at not in seen:
        seen.add(at)
        at = leads_to.get(at)
    return at == name


def _check_wire(source: Pin, target: Pin, wire: WireTable, laid: Mapping[Pin, tuple[Pin, WireTable]]) -> None:
    if target in laid:
        other = laid[target][1]
        if other.to != wire.to:
            raise UsageError(
                f"{wire.to} and {other.to} are two names of one terminal, which can have only one wire: remove a wire"
            )
        raise UsageError(f"{wire.to} already has a wire from {other.from_}: remove one of the wires")
    at: Pin | None = source
    while at is not None:
        if at is target:
            raise UsageError(f"the wires form a loop through {wire.to}: remove one of the wires")
        at = laid[at][0] if at in laid else None


class Builder:
    """Builds a bench from the contents of a scene.

    `served`: controllers with ports have outside hosts.  `texts`: texts of programs that have been read, by path; all
    benches of a scene use the same texts.  `errors`: a list for the errors in masters, wires, faults, the script and
    hosts; without a list, the first error is raised.
    """

    def __init__(
        self, contents: SceneFile, source: Source, served: bool, texts: dict[str, str],
        errors: list[SceneError] | None = None,
    ) -> None:  # fmt: skip
        self._errors = errors
        self.contents, self.source, self.served, self.texts = contents, source, served, texts
        self.bench = Bench()
        load = hosting.loader(self.bench, lambda file: self._text(str(self._relative_to_scene(Path(file)))))
        self._runner = ActionRunner(self.bench, load, own=True)

    def build(self) -> Bench:
        self._note_origin()
        self._add_controllers()
        self._connect_masters()
        self._connect_wires()
        self._add_shared_lines()
        self._open_second_channels()
        self._check_operator()
        self._plan_faults()
        self._plan_script()
        self._start_hosts()
        return self.bench

    @contextmanager
    def _separately(self) -> Iterator[None]:
        try:
            yield
        except SceneError as error:
            if self._errors is None:
                raise
            self._errors.append(error)

    def _note_origin(self) -> None:
        digest = sha256(self.source.text.encode()).hexdigest()
        self.bench.origin["scene"] = f"{self.source.file.name} sha256:{digest[:16]}"
        if title := " ".join(self.contents.title.split()):
            self.bench.origin["title"] = title
        if self.contents.seed is not None:
            self.bench.origin["seed"] = str(self.contents.seed)

    # Controllers

    def _add_controllers(self) -> None:
        for number, table in enumerate(self.contents.controller):
            path: Path_ = ("controller", number)
            self._add(table, path)
            if table.program is not None:
                self._store(self.bench[table.called], table.program, (*path, "program"))
            for name, value in table.variables.items():
                with self.source.placing_errors(*path, "variables", name):
                    self.bench[table.called].assign(name, value)

    def _add(self, table: ControllerTable, path: Path_) -> None:
        made = product(table.model)
        with self.source.placing_errors(*path, "line"):
            if made.line is not None:
                line_format(table.line, made.line)
        self._check_keys((*path, "options"), table.options, [field.name for field in fields(made.options)])
        self._check_keys((*path, "axes"), table.axes, made.axes)
        given = table.model_dump(include={"line", "history"}, exclude_none=True)
        if table.state is not None:
            given["state"] = self._relative_to_scene(table.state)
        axes = table.model_dump(include={"axes"}, exclude_none=True)["axes"]
        with self.source.placing_errors_at_key(path, ("axes", axes), ("options", table.options), ("", given)):
            self.bench.add(table.model, table.called, **given, **table.options, **axes)

    def _check_keys(self, path: Path_, given: Iterable[str], known: Collection[str]) -> None:
        for key in given:
            if key not in known:
                raise self.source.error(f"unknown key {key!r} in {path[-1]}: {instead(key, known)}", (*path, key))

    def _store(self, motor: Controller, program: Path, path: Path_) -> None:
        with self.source.placing_errors(*path):
            stored_programs.check_motor(motor)
            source = stored_programs.as_sent(self._text(str(self._relative_to_scene(program))))
            stored_programs.store(source, str(program), motor)

    # Connections

    def _connect_masters(self) -> None:
        for number, table in enumerate(self.contents.controller):
            if table.master is not None:
                with self._separately():
                    self._connect_master(table, table.master, ("controller", number, "master"))

    def _connect_master(self, table: ControllerTable, master: str, path: Path_) -> None:
        axis = self._axis(master, path)
        with self.source.placing_errors(*path):
            self.bench[table.called].master.follow(axis, Fraction(*table.master_ratio))

    def _connect_wires(self) -> None:
        laid: dict[Pin, tuple[Pin, WireTable]] = {}
        for number, wire in enumerate(self.contents.wire):
            with self._separately():
                self._connect_wire(number, wire, laid)

    def _connect_wire(self, number: int, wire: WireTable, laid: dict[Pin, tuple[Pin, WireTable]]) -> None:
        source = self._pin(wire.from_, ("wire", number, "from"))
        target = self._pin(wire.to, ("wire", number, "to"))
        self._check_direction(number, wire)
        with self.source.placing_errors("wire", number, "to"):
            _check_wire(source, target, wire, laid)
        laid[target] = source, wire
        self.bench.wires.append((wire.from_, wire.to))
        with self.source.placing_errors("wire", number, "delay_ms"):
            connect(source, target, invert=wire.invert, delay_ns=to_ns(wire.delay_ms / 1000))

    def _check_direction(self, number: int, wire: WireTable) -> None:
        from_, to = wire.from_, wire.to
        if self._pin(from_, ("wire", number, "from")).silent:
            name, _, pin = from_.rpartition(".")
            axes = self.bench[name].axes
            axis = next((axis for axis in axes if pin.startswith(axis.lower())), next(iter(axes)))
            raise self.source.error(
                f"a wire cannot begin at the step output {from_}: "
                f'to send step pulses to a SmartMotor, use its key `master`, e.g. master = "{name}.{axis}"',
                ("wire", number, "from"),
            )
        if self._pin(to, ("wire", number, "to")).is_output:
            raise self.source.error(f"{to} is an output: expected a wire that ends at an input", ("wire", number, "to"))

    def _add_shared_lines(self) -> None:
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
        return self._named(name, self.bench.controllers, "the scene", "controller", path)

    def _pin(self, terminal: str, path: Path_) -> Pin:
        controller, _, pin = terminal.rpartition(".")
        if not controller:
            example = self._example_pin(output=path[-1] == "from" or "lamp" in path)
            raise self.source.error(f"invalid terminal {terminal!r}: expected CONTROLLER.PIN, e.g. {example}", path)
        return self._named(pin, self._motor(controller, path).pins, controller, "pin", path)

    def _axis(self, whole: str, path: Path_) -> Axis:
        controller, _, axis = whole.rpartition(".")
        if not controller:
            example = self._example_axis(but=self.contents.controller[int(path[1])].called)
            raise self.source.error(f"invalid axis {whole!r}: expected CONTROLLER.AXIS, e.g. {example}", path)
        return self._named(axis, self._motor(controller, path).axes, controller, "axis", path)

    def _example_pin(self, output: bool) -> str:
        machines = self.bench.controllers.items()
        pins = (f"{name}.{pin}" for name, each in machines for pin in each.pins if each.pins[pin].is_output is output)
        return next(pins, "table.input1")

    def _example_axis(self, but: str = "") -> str:
        machines = self.bench.controllers.items()
        return next((f"{name}.{axis}" for name, each in machines if name != but for axis in each.axes), "table.X")

    def _named(self, name: str, known: Mapping[str, T], owner: str, kind: str, path: Path_) -> T:
        if name not in known:
            raise self.source.error(f"{owner} has no {kind} {name!r}: {instead(name, known)}", path)
        return known[name]

    # Faults, scripted actions and simulated hosts of a scene

    def _plan_faults(self) -> None:
        tables: list[FaultTerms] = self.contents.fault
        names: list[str] = []
        for table in tables:
            names.append(table.name or free_name(table.kind, names))
        self.bench.faults.announced = (*names, *self._scripted())
        with self._separately():
            self._check_fault_order(names, tables)
        for number, table in enumerate(tables):
            with self._separately():
                self._plan_fault(table, number, ("fault", number))

    def _scripted(self) -> list[str]:
        named = (name_in(act) for table in self.contents.script for act in table.do)
        return [name for name in named if name is not None]

    def _check_fault_order(self, names: Sequence[str], tables: Sequence[FaultTerms]) -> None:
        waits_for = {name: other_fault(table.when) for name, table in zip(names, tables, strict=True)}
        for number, (name, table) in enumerate(zip(names, tables, strict=True)):
            if is_in_loop(name, waits_for):
                raise self.source.error(
                    f"the fault {name} can never begin: its trigger {table.when!r} happens only after the fault {name} "
                    f"has begun; expected another trigger, e.g. '{self._example_axis()} passes 1000'",
                    ("fault", number, "when"),
                )

    def _plan_fault(self, table: FaultTerms, number: int, path: Path_) -> None:
        faults, on = self.bench.faults, table.on or self._only()
        with self.source.placing_errors(*path, "kind"):
            kind = kind_of(table.kind)
        with self.source.placing_errors(*path, "on" if table.on else "kind"):
            kind.check(faults.spot(kind, on, self._only()))
        with self.source.placing_errors(*path, "when"):
            faults.trigger(table.when, self._only())
        with self.source.placing_errors_at_key(path, ("", table.model_dump(exclude_none=True, exclude={"kind", "on"}))):
            seed, whole = table.seed, self.contents.seed
            if seed is None and whole is not None:  # Each fault of a scene gets a different random seed.
                seed = FAULTS_A_SCENE * whole + number
            terms = Terms(table.name, table.at, table.when, table.nth, table.duration, seed, self._only())
            faults.plan(table.kind, on, terms, table.parameters)()

    def _check_operator(self) -> None:
        panel = self.contents.operator
        for number, button in enumerate(panel.button):
            self._check_operated(button.pin, ("operator", "button", number, "pin"))
        for number, lamp in enumerate(panel.lamp):
            self._pin(lamp.pin, ("operator", "lamp", number, "pin"))
        for number, selector in enumerate(panel.selector):
            for word, pin in selector.positions.items():
                if pin:
                    self._check_operated(pin, ("operator", "selector", number, "positions", word))

    def _check_operated(self, name: str, path: Path_) -> None:
        if not self._pin(name, path).drivable:
            example = self._example_pin(output=False)
            raise self.source.error(f"{name} is an output: expected an input of a controller, e.g. {example}", path)

    def _plan_script(self) -> None:
        for number, table in enumerate(self.contents.script):
            with self._separately():
                self._plan_entry(number, table)

    def _plan_entry(self, number: int, table: ScriptTable) -> None:
        with self.source.placing_errors("script", number, "at"):
            at_ns = to_ns(table.at)
        acts = []
        for which, text in enumerate(table.do):
            path: Path_ = ("script", number, "do", which)
            with self.source.placing_errors(*path):
                acts.append((path, self._act(table, text)))
        self._plan_acts(at_ns, acts)
        who = f"{table.on} " if table.on else ""
        self.bench.planned.append((at_ns, f"script: {who}{', '.join(table.do)}"))

    def _plan_acts(self, at_ns: int, acts: Sequence[tuple[Path_, Callable[[], object]]]) -> None:
        """Schedule the actions of a script entry.

        The actions are performed after all other events of the same time.  Errors have their place in the scene file.
        Hosts that wait until no event is due ignore these actions.
        """
        clock = self.bench.clock

        def happen() -> None:
            clock.background -= 1
            for path, do in acts:
                with self.source.placing_errors(*path):
                    do()

        clock.background += 1
        clock.call_last(at_ns, happen, rank=hosting.SCRIPT)
        self.bench.agenda_ns = max(self.bench.agenda_ns, at_ns)

    def _act(self, table: ScriptTable, text: str) -> Callable[[], object]:
        act = parse_line(f"! {text}", 0, "")
        assert isinstance(act, Do), "! begins an action"
        here = table.on or self._only()
        if here and here not in (*self.bench.controllers, *endpoints.names(self.bench)):
            controllers = ", ".join(self.bench.controllers)
            raise UsageError(f"the scene has no controller {here!r}: expected one of {controllers}")
        names = self.bench.faults.names
        if act.target == "mend" and act.value not in (*names, *KINDS, *self._scripted(), "all"):
            raise UsageError(f"unknown fault {act.value!r}: known faults are {', '.join(names) or 'none'}")
        if not here and act.target not in FAULT_ACTS:
            controllers = ", ".join(self.bench.controllers)
            raise UsageError(f"the key `on` is missing: expected the name of a controller, one of {controllers}")
        return self._runner.prepare(Do(act.target, act.value, controller=here))

    def _only(self) -> str:
        return next(iter(self.bench.controllers)) if len(self.bench.controllers) == 1 else ""

    def _start_hosts(self) -> None:
        for path, name, file in self._hosts():
            with self._separately(), self.source.placing_errors(*path):
                start = hosting.prepare_host(
                    self.bench, name, str(self._relative_to_scene(file)), self._text, self._runner
                )
                self.bench.hosts.setdefault(name, []).append(start())

    def _hosts(self) -> Iterator[tuple[Path_, str, Path]]:
        for number, table in enumerate(self.contents.controller):
            if not (self.served and table.ports):
                for which, file in enumerate(table.host):
                    yield ("controller", number, "host", which), table.called, file
        for _, name, line, place in shared_lines(self.contents):
            if not (self.served and line.ports):
                for which, file in enumerate(line.host):
                    yield (*place, "host", which), name, file

    def _text(self, file: str) -> str:
        if file not in self.texts:
            self.texts[file] = hosting.program_text(Path(file))
        return self.texts[file]

    def _relative_to_scene(self, path: Path) -> Path:
        return self.source.file.parent / path
