"""A bench: a world with its own clock, and the controllers and machines on it.  Seconds outside, nanoseconds inside."""

import re
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from axistwin.controllers.product import BusDevice, Device, Product, SerialDevice, Store
from axistwin.errors import UsageError
from axistwin.motion.train import HISTORY
from axistwin.plant.encoder import EncoderData
from axistwin.plant.stepper import StepperAxis
from axistwin.plant.switches import PositionSwitch, in_series
from axistwin.plant.torque import Load, StepperMotor
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin, connect
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial import SerialPort, UartFormat
from axistwin.storage import FileStore, MemoryStore
from axistwin.units import to_ns, to_seconds

LINE = re.compile(r"(?P<baudrate>[1-9]\d*)? ?(?P<frame>(?P<bits>[5-8])(?P<parity>[NEOMSneoms])(?P<stop>1|1\.5|2))?")
FAMILIES = {"if1": "digiplan", "if2": "digiplan", "1810": "compumotor", "1811": "compumotor"}
"""Each model's package in `axistwin.controllers`, imported when the model is first asked for."""


def product(model: str) -> Product:
    """The product of this model name.  Raises UsageError if there is none."""
    try:
        family = import_module(f"axistwin.controllers.{FAMILIES[model.lower()]}")
    except KeyError:
        raise UsageError(f"no model {model!r}: choose one of {', '.join(FAMILIES)}") from None
    found: Product = family.PRODUCTS[model.lower()]
    return found


class Controller:
    """A controller on a bench, with its plug, its terminals and its axes."""

    def __init__(
        self, name: str, made: Product, device: Device, axes: Mapping[str, StepperAxis], serial: SerialPort | None
    ) -> None:
        self.name, self.product = name, made
        self.axes: Mapping[str, StepperAxis] = axes
        self.pins: Mapping[str, Pin] = device.pins
        self._device, self._serial = device, serial
        self._bus = device.bus if isinstance(device, BusDevice) else None

    def __repr__(self) -> str:
        return f"<Controller {self.name}: {self.product.model}>"

    @property
    def serial(self) -> SerialPort:
        """The host's end of its serial port.  Raises UsageError if it has none."""
        if self._serial is None:
            raise UsageError(f"{self.name} has no serial port: a {self.product.model} is reached through its `bus`")
        return self._serial

    @property
    def bus(self) -> RegisterPort:
        """Its registers as the host finds them on the bus.  Raises UsageError if it has none."""
        if self._bus is None:
            raise UsageError(f"{self.name} is on no bus: a {self.product.model} is reached through its `serial` port")
        return self._bus

    def power(self, on: bool) -> None:
        """Switch it on or off.  What persists is what the real device keeps."""
        self._device.power(on)

    def power_cycle(self) -> None:
        """Off and on again."""
        self.power(False)
        self.power(True)


class Bench:
    """Controllers and machines in one virtual time, from 0 ns."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.controllers: dict[str, Controller] = {}

    @property
    def now(self) -> int:
        """Virtual time in nanoseconds."""
        return self.clock.now

    @property
    def seconds(self) -> float:
        """Virtual time in seconds."""
        return to_seconds(self.clock.now)

    def __getitem__(self, name: str) -> Controller:
        """The controller of this name."""
        try:
            return self.controllers[name]
        except KeyError:
            raise UsageError(f"no controller {name!r} here: there are {', '.join(self.controllers)}") from None

    def run(self, seconds: float) -> None:
        """Advance virtual time; everything due by then, inclusive, has happened."""
        if seconds < 0:
            raise UsageError(f"time runs forwards only: run({seconds!r})")
        self.clock.run_to(self.clock.now + to_ns(seconds))

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Advance until `condition()` is true or `timeout` seconds have passed; tells which.

        It is asked at every event: an edge, a character, the beginning or end of a motion.  Single pulses are no
        events, so a condition on a position within a move is seen at the next one.
        """
        deadline_ns = self.clock.now + to_ns(timeout)
        while not condition():
            due_ns = self.clock.next_event_ns()
            if due_ns is None or due_ns > deadline_ns:
                self.clock.run_to(deadline_ns)
                return bool(condition())
            self.clock.step()
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
        """Put a controller on the bench; it has just been switched on.

        `state`: directory for what it keeps without power (None: kept as long as the bench).  `line`: the host's
        UART format, such as "9600 8N2"; "instant" makes characters take no time.  `history`: strokes per axis to
        remember.  An axis name takes that axis's options (`limits`, `home`, `encoder`, `motor`, `load`); everything
        else is an option of the model.
        """
        made = product(model)
        name = name or self._free_name(made.model)
        if name in self.controllers:
            raise UsageError(f"there is a controller {name!r} already: choose another name")
        axis_options = {axis: _table(axis, options.pop(axis, None) or {}) for axis in made.axes}
        own_options = _options(made, options)
        if type(history) is not int or history < 2:
            raise UsageError(f"history={history!r}: give a number of strokes, 2 or more")
        if line is not None and made.line is None:
            raise UsageError(f"{made.model} has no serial port: leave out `line`")
        axes = {axis: _axis(self.clock, axis, given, history) for axis, given in axis_options.items()}
        store: Store = MemoryStore() if state is None else FileStore(Path(state) / f"{name}.json")
        device = made.build(self.clock, axes, own_options, store)
        _fit_switches(made, device, axes, axis_options)
        serial = _serial_port(self.clock, device, line, made.line) if isinstance(device, SerialDevice) else None
        controller = Controller(name, made, device, axes, serial)
        self.controllers[name] = controller
        device.power(True)
        return controller

    def _free_name(self, model: str) -> str:
        candidates = (model if n == 1 else f"{model}-{n}" for n in range(1, len(self.controllers) + 2))
        return next(name for name in candidates if name not in self.controllers)


def _serial_port(
    clock: Clock, device: SerialDevice, line: str | UartFormat | None, usual: UartFormat | None
) -> SerialPort:
    """The host's end.  Its DTR goes to the device's DSR, its RTS to the device's CTS."""
    assert usual is not None, "a product with a serial port names its usual format"
    fmt, instant = line_format(line, usual)
    port = SerialPort(clock, device.uart, device.dtr, device.rts, line=fmt, instant=instant)
    connect(port.host.dtr_line, device.dsr)
    connect(port.host.rts_line, device.cts)
    return port


def line_format(text: str | UartFormat | None, usual: UartFormat) -> tuple[UartFormat, bool]:
    """`"9600 8N2"`, `"instant"` or both, as a format and whether characters take no time."""
    if text is None or isinstance(text, UartFormat):
        return text or usual, False
    words = text.replace(",", " ").split()
    instant = "instant" in words
    match = LINE.fullmatch(" ".join(word for word in words if word != "instant"))
    if match is None:
        raise UsageError(f"no line format {text!r}: write it like '9600 8N2', '1200 7E1' or 'instant'")
    baudrate = int(match["baudrate"] or usual.baudrate)
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


def _axis(clock: Clock, name: str, given: dict[str, Any], history: int) -> StepperAxis:
    known = ("limits", "home", "encoder", "motor", "load")
    for option in given:
        if option not in known:
            raise UsageError(f"axis {name} has no option {option!r}: it takes {', '.join(known)}")
    for span in ("limits", "home"):
        _check_span(name, span, given.get(span))
    try:
        encoder = EncoderData(**given["encoder"]) if given.get("encoder") is not None else None
        motor = given.get("motor")
        if motor is not None:
            points = tuple((float(rate), float(torque)) for rate, torque in motor["torque"])
            motor = StepperMotor(**{**motor, "torque": points})
        load = Load(**given["load"]) if given.get("load") is not None else None
    except (TypeError, KeyError, ValueError) as error:
        raise UsageError(f"axis {name}: {error}") from None
    return StepperAxis(clock, name, motor=motor, load=load, encoder=encoder, history=history)


def _table(name: str, given: object) -> dict[str, Any]:
    """An axis's options as they were given."""
    if not isinstance(given, Mapping):
        raise UsageError(f'axis {name}={given!r}: give its options, such as {name}={{"limits": (-100, 5000)}}')
    return dict(given)


def _check_span(name: str, option: str, given: Any) -> None:
    """Two positions, the lower one first."""
    if given is None:
        return
    try:
        first, last = given
    except (TypeError, ValueError):
        first = last = None
    if not (type(first) is int and type(last) is int and first <= last):
        raise UsageError(f"axis {name}: {option}={given!r}: give two positions, such as (-100, 5000)")


def _fit_switches(
    made: Product, device: Device, axes: Mapping[str, StepperAxis], options: Mapping[str, Mapping[str, Any]]
) -> None:
    """Limit switches open beyond `limits`; the home input is high within `home`."""
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
