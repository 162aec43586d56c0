"""A bench: controllers and machines on one clock.  Public functions use seconds, internal ones nanoseconds."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from axistwin.bench.controller import Controller
from axistwin.bench.fitting import fit_plug, fit_switches
from axistwin.bench.models import Model, axis_options, check_options, model_options, product
from axistwin.controllers.product import BusHost
from axistwin.core.errors import UsageError
from axistwin.core.storage import FileStore, MemoryStore
from axistwin.core.units import to_ns, to_seconds
from axistwin.sim.clock import Clock, Process
from axistwin.sim.frames import UartFormat
from axistwin.sim.motion.train import HISTORY
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import SerialPort
from axistwin.sim.wirings import Wiring, daisy_chain, shared_pair

if TYPE_CHECKING:
    from axistwin.bench.faults.injector import Faults


MOST_HISTORY = 1_000_000_000


class SharedLine(NamedTuple):
    """A daisy chain or an RS-485 line: the host's port, and the motors in order."""

    port: SerialPort
    motors: tuple[Controller, ...]
    channel: str  # The connected channel of each motor: "serial" or "rs485".


class Bench:
    """A set-up of controllers and machines that share one virtual clock.  The clock starts at 0 ns."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.controllers: dict[str, Controller] = {}
        self.lines: dict[str, SharedLine] = {}
        self.origin: dict[str, str] = {}  # The scene from which the bench was built: name and hash, title, seed.
        self.agenda_ns = 0  # Time in ns of the last planned action, e.g. of a scene's script.
        self.planned: list[tuple[int, str]] = []  # Time in nanoseconds and text of each planned action, for users.
        self.attendants: dict[str, BusHost] = {}  # Hosts that send whole commands to boards on a bus, by board.
        self.senders: dict[str, Process] = {}  # Hosts that send loaded programs, by controller name.
        self.hosts: dict[str, list[Process]] = {}  # Hosts of a scene, by endpoint.
        self.wires: list[tuple[str, str]] = []  # Names of both terminals, e.g. ("table.output1", "table.input1").
        self._faults: Faults | None = None

    @property
    def faults(self) -> "Faults":
        """The fault injector of the bench, e.g. `bench.faults.add("lose", "if1.serial", count=3, at=1.5)`."""
        if self._faults is None:
            from axistwin.bench.faults.injector import Faults

            self._faults = Faults(self)
        return self._faults

    @property
    def now(self) -> int:
        """Virtual time in nanoseconds."""
        return self.clock.now

    @property
    def seconds(self) -> float:
        """Virtual time in seconds."""
        return to_seconds(self.clock.now)

    def __getitem__(self, name: str) -> Controller:
        """Return the controller with this name.  Raises UsageError for an unknown name."""
        try:
            return self.controllers[name]
        except KeyError:
            names = ", ".join((*self.controllers, *self.lines))
            raise UsageError(f"no controller {name!r} on the bench: expected one of {names}") from None

    @property
    def ports(self) -> dict[str, SerialPort]:
        """All serial ports for hosts, by name: first those of single controllers, then those of shared lines."""
        own = {name: port for controller in self.controllers.values() for name, port in controller.ports.items()}
        return own | {name: line.port for name, line in self.lines.items()}

    def port(self, name: str) -> SerialPort:
        """Return the host's end of `motor`, its second channel `motor.rs485` or a shared line.  Raises UsageError."""
        if name in self.lines:
            return self.lines[name].port
        controller, dot, channel = name.rpartition(".")
        if dot and channel == "rs485" and controller in self.controllers:
            return self[controller].rs485
        return self[name].serial

    def when(self, sentence: str, happens: Callable[[], None], here: str = "") -> Callable[[], object]:
        """Call `happens` at the exact time of each occurrence of an event, e.g. "table.X passes 1000".

        The sentences are those of faults' triggers.  `here`: the controller whose parts may be named without its
        name.  Return an unsubscribe function.  Raises UsageError for an invalid sentence.
        """
        from axistwin.bench.faults import triggers

        return triggers.read(sentence, self, here)(happens)

    def run(self, seconds: float) -> None:
        """Advance by `seconds`, and execute all events up to then.  Raises UsageError below 0 s or after 292 years."""
        if seconds < 0:
            raise UsageError(f"negative time in run({seconds!r}): expected 0 seconds or more")
        self.clock.run_to(self.clock.later(to_ns(seconds)))

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Advance virtual time until `condition()` is true, for at most `timeout` seconds.

        Return True if the condition is true.  The condition is checked at every event (an edge, a character, the
        beginning or end of a motion) and, while a servo moves, at every sample.  Single pulses are no events: a
        condition on a stepper's position within a move is checked at the next event.  Raises UsageError for a time-out
        after the end of virtual time (292 years).
        """
        clock = self.clock
        deadline_ns = clock.later(to_ns(timeout))
        servos = [controller._servo for controller in self.controllers.values() if controller._servo is not None]
        while not condition():
            due_ns = event_ns = clock.next_event_ns()
            if servos:
                samples_ns = (servo.next_sample_ns() for servo in servos)
                due_ns = min((ns for ns in (event_ns, *samples_ns) if ns is not None), default=None)
            if due_ns is None or due_ns > deadline_ns:
                clock.run_to(deadline_ns)
                return bool(condition())
            if due_ns == event_ns:
                clock.step()
            else:
                clock.run_to(due_ns)
        return True

    def add(
        self, model: Model, name: str | None = None, *, state: str | Path | None = None,
        line: str | UartFormat | None = None, history: int = HISTORY, **options: Any,
    ) -> Controller:  # fmt: skip
        """Add a controller to the bench, and switch its power on.

        `state`: directory for its persistent memory (None: memory lasts as long as the bench).  `line`: the host's UART
        format, such as "9600 8N2"; "instant" makes characters take no time.  `history`: number of stored moves per
        axis; for a servo, ten samples with motion count as one move.  An axis name takes that axis's options (`units`,
        `limits`, `home`, `encoder`, `motor`, `load`); all other keywords are options of the model.
        """
        made = product(model)
        name = name or self._free_name(made.model)
        self._check_name(name)
        if not isinstance(state, str | Path | None):
            raise UsageError(f"invalid state={state!r}: expected a directory, e.g. './state'")
        check_options({**options, "history": history})
        given = {key: value for key, value in {**options, "line": line}.items() if value is not None}
        for_axes = {axis: axis_options(axis, options.pop(axis, None) or {}) for axis in made.axes}
        own_options = model_options(made, options)
        if type(history) is not int or not 2 <= history <= MOST_HISTORY:
            raise UsageError(f"invalid history={history!r}: expected a number of moves, from 2 to {MOST_HISTORY}")
        if line is not None and made.line is None:
            raise UsageError(f"{made.model} has no serial port: leave out the option `line`")
        axes = {axis: made.make_axis(self.clock, axis, given, history) for axis, given in for_axes.items()}
        store: MemoryStore | FileStore = MemoryStore() if state is None else FileStore(Path(state) / f"{name}.json")
        device = made.build(self.clock, axes, own_options, store)
        fit_switches(made, device, axes)
        plug = fit_plug(self.clock, device.abilities, line, made.line)
        controller = Controller(name, made, device, axes, plug, self.clock)
        controller.bench, controller.given, controller.store = self, given, store
        self.controllers[name] = controller
        controller.power(True)
        return controller

    def chain(self, *motors: Controller, name: str | None = None) -> SerialPort:
        """Connect motors to an RS232 daisy chain, and return the host's serial port.

        A motor's output goes to the next motor, so each motor must echo (`ECHO`) the data for the motors after it.  The
        chain replaces the motors' own `serial` ports, in the format of the first motor.
        """
        return self._share("serial", "chain", daisy_chain, [motor._serial_uart() for motor in motors], motors, name)

    def rs485(self, *motors: Controller, name: str | None = None) -> SerialPort:
        """Connect motors to a shared RS-485 line, and return the host's serial port.

        Two simultaneous senders garble each other's characters.  The line replaces the motors' own `rs485` ports.
        """
        return self._share("rs485", "rs485", shared_pair, [motor._rs485_uart() for motor in motors], motors, name)

    def _share(
        self, channel: str, method: str, wiring: Callable[..., Wiring], uarts: list[Uart],
        motors: tuple[Controller, ...], name: str | None,
    ) -> SerialPort:  # fmt: skip
        if not motors:
            raise UsageError(f"{method}() was called without motors: expected one or more motors of the bench")
        for motor in motors:
            if self.controllers.get(motor.name) is not motor:
                raise UsageError(f"motor {motor.name} belongs to another Bench: expected motors of one Bench")
            if channel in motor._lines:
                raise UsageError(
                    f"motor {motor.name} is already connected to the serial line {motor._lines[channel]!r}: "
                    f"expected each motor in only one call of {method}()"
                )
            if motors.count(motor) > 1:
                raise UsageError(f"motor {motor.name} is given twice to {method}(): expected each motor once")
        name = name or self._free_name(method)
        self._check_name(name)
        plug = motors[0]._plug
        assert plug is not None, "motors with channels have a plug"
        port = SerialPort(self.clock, wiring(uarts, instant=plug.instant), line=plug.format)
        for motor in motors:
            motor._lines[channel] = name
        self.lines[name] = SharedLine(port, motors, channel)
        return port

    def _check_name(self, name: str) -> None:
        if str(name) != name or not name.isprintable() or not {"/", "\\"}.isdisjoint(name):
            raise UsageError(f"invalid name {name!r}: expected letters, digits, _ and -, e.g. table")
        if name in self.controllers or name in self.lines:
            owner = "a controller" if name in self.controllers else "a line"
            raise UsageError(f"the name {name!r} is in use by {owner}: choose another name")

    def _free_name(self, model: str) -> str:
        taken = self.controllers.keys() | self.lines.keys()
        candidates = (model if n == 1 else f"{model}-{n}" for n in range(1, len(taken) + 2))
        return next(name for name in candidates if name not in taken)
