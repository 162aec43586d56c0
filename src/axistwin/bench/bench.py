"""A bench: controllers and machines with a clock of their own; seconds at its interface, nanoseconds inside."""

import re
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from axistwin.controllers.product import (
    AlarmDevice,
    BusDevice,
    BusHost,
    BusyDevice,
    Device,
    FollowedDevice,
    Follower,
    HandshakeDevice,
    HintingDevice,
    Listing,
    ProceduralDevice,
    Product,
    ProgrammedDevice,
    Register,
    RegisteredDevice,
    Rs485Device,
    SerialDevice,
    TroubledDevice,
)
from axistwin.errors import UsageError
from axistwin.motion.train import HISTORY
from axistwin.numbers import shortened, whole
from axistwin.plant.axes import Axis
from axistwin.plant.joystick import Joystick
from axistwin.plant.master import Master
from axistwin.plant.servo_axis import ServoAxis
from axistwin.plant.switches import PositionSwitch, in_series
from axistwin.sim.by_hand import ByHand
from axistwin.sim.clock import Clock, Process
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin, connect
from axistwin.sim.progress import Line, LineWatcher
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import SerialPort
from axistwin.sim.wirings import Wiring, daisy_chain, direct, shared_pair
from axistwin.storage import FileStore, MemoryStore
from axistwin.units import to_ns, to_seconds

if TYPE_CHECKING:
    from axistwin.fault_injection.injector import Faults

LINE = re.compile(
    r"(?P<baudrate>[1-9]\d{0,8})? ?(?P<frame>(?P<bits>[5-8])(?P<parity>[NEOMSneoms])(?P<stop>1|1\.5|2))?", re.ASCII
)
FAMILIES = {
    "if1": "digiplan", "if2": "digiplan", "1810": "compumotor", "1811": "compumotor", "smartmotor": "smartmotor",
}  # fmt: skip
"""The package of each model in `axistwin.controllers`, imported at the model's first use."""


def product(model: str) -> Product:
    """Return the product of this model name.  Raises UsageError if there is none."""
    try:
        family = import_module(f"axistwin.controllers.{FAMILIES[model.lower()]}")
    except KeyError:
        raise UsageError(f"no model {model!r}: choose one of {', '.join(FAMILIES)}") from None
    found: Product = family.PRODUCTS[model.lower()]
    return found


class Controller:
    """A controller on a bench, with its plug, its terminals and its axes."""

    def __init__(
        self, name: str, made: Product, device: Device, axes: Mapping[str, Axis], plug: "_Plug | None" = None
    ) -> None:
        self.name, self.product = name, made
        self.axes: Mapping[str, Axis] = axes
        self.pins: Mapping[str, Pin] = device.pins
        self.bench: Bench | None = None
        """The bench that the controller is on."""
        self._device, self._plug = device, plug
        self.by_hand = ByHand(next(iter(self.pins.values())).clock)
        """Reports a person's actions: `power`."""
        self.powered = False
        """True while the power is on."""
        self._turns: deque[bool] = deque()
        """Turns of the power switch in progress, in order."""
        self.given: Mapping[str, Any] = {}
        """The options given to `Bench.add`, except those about the storage of its state."""
        self.store: MemoryStore | FileStore = MemoryStore()
        """Memory that persists without power."""
        self._second = _second_port(device, plug)
        self._asked_for_second = False
        self._lines: dict[str, str] = {}  # shared line by channel (serial or rs485)
        self._bus = device.bus if isinstance(device, BusDevice) else None
        self.alarms = device.alarms if isinstance(device, AlarmDevice) else None
        """Subscriptions to its fault flags; None: the device has no fault flags."""
        self._servo = next((axis for axis in axes.values() if isinstance(axis, ServoAxis)), None)

    def __repr__(self) -> str:
        return f"<Controller {self.name}: {self.product.model}>"

    @property
    def serial(self) -> SerialPort:
        """The host's end of its serial port.  Raises UsageError if it has no port of its own."""
        if self._plug is None:
            raise UsageError(f"{self.name} has no serial port: a {self.product.model} is reached through its `bus`")
        if "serial" in self._lines:
            raise UsageError(
                f"{self.name} is in the daisy chain {self._lines['serial']!r}: talk to the port that `chain` returned"
            )
        return self._plug.port

    @property
    def rs485(self) -> SerialPort:
        """The host's end of its second channel, a pair of wires.  Raises UsageError if it has no such channel."""
        if "rs485" in self._lines:
            raise UsageError(
                f"{self.name} is on the shared line {self._lines['rs485']!r}: talk to the port that `rs485` returned"
            )
        if self._second is None:
            raise UsageError(f"{self.name} has no second serial channel: that is for SmartMotors")
        self._asked_for_second = True
        return self._second

    @property
    def bus(self) -> RegisterPort:
        """Its registers as the host accesses them on the bus.  Raises UsageError if it has no registers."""
        if self._bus is None:
            raise UsageError(f"{self.name} is on no bus: a {self.product.model} is reached through its `serial` port")
        return self._bus

    @property
    def ports(self) -> dict[str, SerialPort]:
        """Serial ports of the controller itself, by name; the second channel only once it has been used."""
        found = {} if self._plug is None or "serial" in self._lines else {self.name: self._plug.port}
        if self._second is not None and self._asked_for_second and "rs485" not in self._lines:
            found[f"{self.name}.rs485"] = self._second
        return found

    @cached_property
    def terminals(self) -> Mapping[str, Pin]:
        """All terminals with a level: its pins, the control lines at its plug, its interrupt on the bus."""
        if self._bus is not None:
            return {**self.pins, "interrupt": self._bus.interrupt_line}
        if not isinstance(self._device, HandshakeDevice):
            return self.pins
        lines = self._device.lines
        return {**self.pins, "dtr": lines.dtr, "rts": lines.rts, "dsr": lines.dsr, "cts": lines.cts}

    @cached_property
    def joystick(self) -> Joystick:
        """The joystick connected to it.  Raises UsageError if it has no joystick input."""
        if self.product.joystick is None:
            raise UsageError(f"{self.name} has no joystick input")
        assert self.bench is not None, "the controller is on a bench"
        return Joystick(self.bench.clock, self.pins, self.product.joystick)

    @cached_property
    def registers(self) -> Mapping[str, Register]:
        """Readable numbers and texts inside the controller; traces can record them."""
        return self._device.registers() if isinstance(self._device, RegisteredDevice) else {}

    def follow(self, names: Sequence[str], follower: Follower) -> Callable[[], None] | None:
        """Call `follower` with all changes of these registers, also when the controller computes ahead of the clock.

        Changes may be reported with delay.  Return an unsubscribe function; None: the registers change only at events,
        and can be read then.
        """
        return self._device.follow(names, follower) if isinstance(self._device, FollowedDevice) else None

    @property
    def programs(self) -> Mapping[str, Listing]:
        """Its stored programs or sequences by name, each with the line that is running now."""
        return self._device.programs() if isinstance(self._device, ProgrammedDevice) else {}

    def subscribe_lines(self, watcher: LineWatcher, only: Line | None = None) -> Callable[[], None]:
        """Call `watcher(program, index)` at the exact moment at which a line of a stored program begins.

        `index` is from 0.  `only`: this program and index only, which may cost much less.  The callback may read the
        bench but must not change it.  Return an unsubscribe function.  A controller without programs never calls it.
        """
        return (
            self._device.subscribe_lines(watcher, only) if isinstance(self._device, ProgrammedDevice) else lambda: None
        )

    @property
    def ambient(self) -> float:
        """Temperature around its motor, in °C.  Raises UsageError if it is no SmartMotor."""
        return self._motor("is no motor and has no `ambient`").ambient

    @ambient.setter
    def ambient(self, celsius: float) -> None:
        self._motor("is no motor and has no `ambient`").ambient = celsius

    @property
    def master(self) -> Master:
        """The external encoder wired to its pins A and B.  Raises UsageError if it has no such input."""
        return self._motor("is no motor and has no `master`").master

    @property
    def hint(self) -> str:
        """A status hint: why the controller does not move, and the remedy, in one line; empty if there is none."""
        return self._device.hint() if isinstance(self._device, TroubledDevice) else ""

    def subscribe_hint(self, watcher: Callable[[str], None]) -> Callable[[], None]:
        """Call `watcher(line)` when there is a new hint.  Return an unsubscribe function."""
        return self._device.subscribe_hint(watcher) if isinstance(self._device, HintingDevice) else lambda: None

    @property
    def busy(self) -> bool:
        """True while the controller works on a host's request; False if the device does not report its work."""
        return isinstance(self._device, BusyDevice) and self._device.busy

    def power(self, on: bool) -> None:
        """Switch the power on or off.  The same data persist as in the real device.

        If one of the controller's own procedures switches the power (by an edge that has subscribers), the power
        changes when the procedure next yields, in the same nanosecond.
        """
        self.by_hand.report("power", on)
        device = self._device
        if isinstance(device, ProceduralDevice) and device.clock.active_process in device.procedures:
            device.clock.soon(partial(self._switch, on))
        else:
            self._switch(on)

    def power_cycle(self) -> None:
        """Switch the power off and on again."""
        self.power(False)
        self.power(True)

    def _switch(self, on: bool) -> None:
        """Turn the switch.  Who turns it again because of what changes meanwhile does so when it has been turned."""
        self._turns.append(on)
        if len(self._turns) > 1:
            return
        try:
            while self._turns:
                self._turn(self._turns[0])
                self._turns.popleft()
        finally:
            self._turns.clear()

    def _turn(self, on: bool) -> None:
        self.powered = on
        self._device.power(on)
        if not on:
            self.store.end()

    def _motor(self, complaint: str) -> ServoAxis:
        if self._servo is None:
            raise UsageError(f"{self.name} {complaint}: that is for SmartMotors")
        return self._servo

    def _rs485_uart(self) -> Uart:
        if not isinstance(self._device, Rs485Device):
            raise UsageError(f"{self.name} has no second serial channel: that is for SmartMotors")
        return self._device.rs485

    def _serial_uart(self) -> Uart:
        if not isinstance(self._device, SerialDevice) or isinstance(self._device, HandshakeDevice):
            raise UsageError(f"{self.name} cannot be in a daisy chain: that is for SmartMotors")
        return self._device.uart


@dataclass(frozen=True)
class _Plug:
    """A controller's serial connection and the settings it was made with."""

    port: SerialPort
    format: UartFormat
    instant: bool


def _second_port(device: Device, plug: _Plug | None) -> SerialPort | None:
    """Return the host's end of a second channel, a pair of wires, if there is such a channel."""
    if not isinstance(device, Rs485Device):
        return None
    assert plug is not None, "a second channel is beside a first"
    return SerialPort(plug.port.clock, shared_pair([device.rs485], instant=plug.instant), line=plug.format)


@dataclass(frozen=True)
class SharedLine:
    """A daisy chain or an RS-485 line: its host's end, and its motors in order."""

    port: SerialPort
    motors: tuple[Controller, ...]


class Bench:
    """Controllers and machines in one virtual time, from 0 ns."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.controllers: dict[str, Controller] = {}
        self.lines: dict[str, SharedLine] = {}
        """Daisy chains and RS-485 lines by name."""
        self.origin: dict[str, str] = {}
        """Origin of the bench: `scene` (its name and hash), `seed`."""
        self.agenda_ns = 0
        """Time until which planned actions follow, such as a scene's script."""
        self.attendants: dict[str, BusHost] = {}
        """Hosts that send whole commands to boards on a bus, by board name; each board has at most one."""
        self.senders: dict[str, Process] = {}
        """Hosts that send loaded programs, by controller name."""
        self._faults: Faults | None = None

    @property
    def faults(self) -> "Faults":
        """The fault injector: `bench.faults.add("lose", "if1.serial", count=3, at=1.5)`."""
        if self._faults is None:
            from axistwin.fault_injection.injector import Faults  # lazy import: most benches have no faults

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
        """Return the controller of this name.  Raises UsageError if there is none."""
        try:
            return self.controllers[name]
        except KeyError:
            known = ", ".join((*self.controllers, *self.lines))
            raise UsageError(f"no controller {name!r} here: there are {known}") from None

    @property
    def ports(self) -> dict[str, SerialPort]:
        """All serial ports for hosts, by name: first the controllers' own, then shared lines."""
        own = {name: port for controller in self.controllers.values() for name, port in controller.ports.items()}
        return own | {name: line.port for name, line in self.lines.items()}

    def port(self, name: str) -> SerialPort:
        """Return the host's end of an endpoint: `motor`, its second channel `motor.rs485`, or a shared line `chain`.

        Raises UsageError if nothing has this name.
        """
        if name in self.lines:
            return self.lines[name].port
        controller, dot, channel = name.rpartition(".")
        if dot and channel == "rs485" and controller in self.controllers:
            return self[controller].rs485
        return self[name].serial

    def when(self, sentence: str, happens: Callable[[], None], here: str = "") -> Callable[[], object]:
        """Call `happens` each time an event occurs, in that nanosecond: "table.X passes 1000", "motor raises Be".

        The sentences are those of faults' triggers.  `here`: the controller whose parts may be named without its name.
        Return an unsubscribe function.  Raises UsageError for an invalid sentence.
        """
        from axistwin.fault_injection import triggers  # lazy import: most benches have no triggers

        return triggers.read(sentence, self, self.faults, here)(happens)

    def run(self, seconds: float) -> None:
        """Advance virtual time by `seconds`; all events due by then, inclusive, happen.

        Raises UsageError for a negative time, and for a time after the end of virtual time (292 years).
        """
        if seconds < 0:
            raise UsageError(f"negative time in run({seconds!r}): expected 0 seconds or more")
        self.clock.run_to(self.clock.later(to_ns(seconds)))

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Advance until `condition()` is true or `timeout` seconds have passed; return True if the condition is true.

        The condition is checked at every event (an edge, a character, the beginning or end of a motion) and, while a
        servo moves, at every sample.  Single pulses are no events: a condition on a stepper's position within a move is
        checked at the next event.  Raises UsageError for a time-out after the end of virtual time (292 years).
        """
        deadline_ns = self.clock.later(to_ns(timeout))
        servos = [controller._servo for controller in self.controllers.values() if controller._servo is not None]
        while not condition():
            samples_ns = (servo.next_sample_ns() for servo in servos)
            due_ns = min((ns for ns in (self.clock.next_event_ns(), *samples_ns) if ns is not None), default=None)
            if due_ns is None or due_ns > deadline_ns:
                self.clock.run_to(deadline_ns)
                return bool(condition())
            if due_ns == self.clock.next_event_ns():
                self.clock.step()
            else:
                self.clock.run_to(due_ns)
        return True

    def add(
        self,
        model: str,
        name: str | None = None,
        *,
        state: str | Path | None = None,
        line: str | UartFormat | None = None,
        history: int = HISTORY,
        **options: Any,
    ) -> Controller:
        """Add a controller to the bench, just switched on.

        `state`: directory for its persistent memory (None: memory lasts as long as the bench).  `line`: the host's UART
        format, such as "9600 8N2"; "instant" makes characters take no time.  `history`: number of moves per axis to
        remember (of a servo, ten samples with motion for each).  An axis name takes that axis's options (`limits`,
        `home`, `encoder`, `motor`, `load`); all other keywords are options of the model.
        """
        made = product(model)
        name = name or self._free_name(made.model)
        self._check_name(name)
        given = {key: value for key, value in {**options, "line": line}.items() if value is not None}
        axis_options = {axis: _table(axis, options.pop(axis, None) or {}) for axis in made.axes}
        own_options = _options(made, options)
        if type(history) is not int or history < 2:
            raise UsageError(f"history={history!r}: expected a number of moves, 2 or more")
        if line is not None and made.line is None:
            raise UsageError(f"{made.model} has no serial port: leave out `line`")
        axes = {axis: made.make_axis(self.clock, axis, given, history) for axis, given in axis_options.items()}
        store: MemoryStore | FileStore = MemoryStore() if state is None else FileStore(Path(state) / f"{name}.json")
        device = made.build(self.clock, axes, own_options, store)
        _fit_switches(made, device, axes, axis_options)
        plug = _plug(self.clock, device, line, made.line) if isinstance(device, SerialDevice) else None
        controller = Controller(name, made, device, axes, plug)
        controller.bench, controller.given, controller.store = self, given, store
        self.controllers[name] = controller
        controller.power(True)
        return controller

    def chain(self, *motors: Controller, name: str | None = None) -> SerialPort:
        """Return the host's end of an RS232 daisy chain: host, first motor, …, last motor, host.

        A motor's output goes to the next motor, so each motor must echo data for the others (`ECHO`).  The chain
        replaces the motors' own `serial` ports, in the format of the first motor.
        """
        return self._share("serial", "chain", daisy_chain, [motor._serial_uart() for motor in motors], motors, name)

    def rs485(self, *motors: Controller, name: str | None = None) -> SerialPort:
        """Return the host's end of an RS485 line: one pair of wires, on which every end receives what all others send.

        Two simultaneous senders garble each other's characters.  The line replaces the motors' own `rs485` ports.
        """
        return self._share("rs485", "rs485", shared_pair, [motor._rs485_uart() for motor in motors], motors, name)

    def _share(
        self,
        channel: str,
        kind: str,
        wiring: Callable[..., Wiring],
        uarts: list[Uart],
        motors: tuple[Controller, ...],
        name: str | None,
    ) -> SerialPort:
        """Connect one channel of each motor to a shared line."""
        if not motors:
            raise UsageError(f"{kind}() joins motors: name at least one")
        for motor in motors:
            if self.controllers.get(motor.name) is not motor:
                raise UsageError(f"{motor.name} is not on this bench: {kind}() joins motors of one bench")
            if channel in motor._lines or motors.count(motor) > 1:
                raise UsageError(f"{motor.name} is on {motor._lines.get(channel, 'this line')!r} already: name it once")
        name = name or self._free_name(kind)
        self._check_name(name)
        plug = motors[0]._plug
        assert plug is not None, "motors with channels have a plug"
        port = SerialPort(self.clock, wiring(uarts, instant=plug.instant), line=plug.format)
        for motor in motors:
            motor._lines[channel] = name
        self.lines[name] = SharedLine(port, motors)
        return port

    def _check_name(self, name: str) -> None:
        if name in self.controllers or name in self.lines:
            kind = "a controller" if name in self.controllers else "a line"
            raise UsageError(f"there is {kind} {name!r} already: choose another name")

    def _free_name(self, model: str) -> str:
        taken = self.controllers.keys() | self.lines.keys()
        candidates = (model if n == 1 else f"{model}-{n}" for n in range(1, len(taken) + 2))
        return next(name for name in candidates if name not in taken)


def _plug(clock: Clock, device: SerialDevice, line: str | UartFormat | None, usual: UartFormat | None) -> _Plug:
    """Return the host's end.  Its DTR goes to the device's DSR and its RTS to the device's CTS, if these exist."""
    assert usual is not None, "a product with a serial port names its usual format"
    fmt, instant = line_format(line, usual)
    wiring = direct(device.uart, instant=instant)
    if not isinstance(device, HandshakeDevice):
        return _Plug(SerialPort(clock, wiring, line=fmt), fmt, instant)
    port = SerialPort(clock, wiring, device.dtr, device.rts, line=fmt)
    connect(port.host.dtr_line, device.dsr)
    connect(port.host.rts_line, device.cts)
    return _Plug(port, fmt, instant)


def line_format(text: str | UartFormat | None, usual: UartFormat) -> tuple[UartFormat, bool]:
    """Return the format in a text, and True if characters take no time: `"9600 8N2"`, `"instant"` or both."""
    if text is None or isinstance(text, UartFormat):
        return text or usual, False
    if not isinstance(text, str):
        raise UsageError(f"invalid line format {text!r}: expected e.g. '9600 8N2' or 'instant'")
    words = text.replace(",", " ").split()
    instant = "instant" in words
    match = LINE.fullmatch(" ".join(word for word in words if word != "instant"))
    if match is None:
        raise UsageError(f"invalid line format {shortened(text)}: expected e.g. '9600 8N2' or 'instant'")
    baudrate = usual.baudrate if match["baudrate"] is None else whole(match["baudrate"])
    if match["frame"] is None:
        return replace(usual, baudrate=baudrate), instant
    parity: Any = match["parity"].upper()
    return UartFormat(baudrate, int(match["bits"]), parity, float(match["stop"])), instant


def _options(made: Product, given: dict[str, Any]) -> Any:
    known = [field.name for field in fields(made.options)]
    for name in given:
        if name not in known:
            raise UsageError(f"{made.model} has no option {name!r}: it takes {', '.join((*made.axes, *known))}")
    return made.options(**given)


def _table(name: str, given: object) -> dict[str, Any]:
    """Return an axis's options as they were given."""
    if not isinstance(given, Mapping):
        raise UsageError(f'axis {name}={given!r}: expected its options, e.g. {name}={{"limits": (-100, 5000)}}')
    return dict(given)


def _fit_switches(
    made: Product, device: Device, axes: Mapping[str, Axis], options: Mapping[str, Mapping[str, Any]]
) -> None:
    """Fit switches: limit switches open beyond `limits`; the home input is high within `home`."""
    minus, plus = [], []
    for name, axis in axes.items():
        if options[name].get("limits") is not None:
            first, last = options[name]["limits"]
            minus.append(PositionSwitch(axis, first, None))
            plus.append(PositionSwitch(axis, None, last))
        if options[name].get("home") is not None:
            if made.home_pin is None:
                raise UsageError(f"{made.model} has no home input: leave out `home` of axis {name}")
            in_series([PositionSwitch(axis, *options[name]["home"])], device.pins[made.home_pin])
    if made.limit_pins and minus:
        in_series(minus, device.pins[made.limit_pins[0]], closed=made.closed_level)
        in_series(plus, device.pins[made.limit_pins[1]], closed=made.closed_level)
