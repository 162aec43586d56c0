"""The card itself: its terminals and its plug, which are there with and without power (chapter Installation)."""

from collections.abc import Callable, Mapping
from functools import partial

from axistwin.controllers.digiplan.check import check
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.faults import ALARMS, CLOSED, DRIVES
from axistwin.controllers.digiplan.interface import Interface
from axistwin.controllers.digiplan.options import Options
from axistwin.controllers.digiplan.report import busy_letter, communication_bits
from axistwin.controllers.digiplan.rules import RULES
from axistwin.controllers.product import Product, PulseAxis, Register, Store
from axistwin.sim.alarms import Alarms
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin, connect
from axistwin.sim.serial import Uart, UartFormat

OUTPUTS = tuple(f"output{number}" for number in range(1, 6))
INPUTS = ("input1", "input2", "input3")


class NoBattery:
    """The IF1's memory, which keeps nothing."""

    def load(self) -> bytes | None:
        """Nothing is ever there."""
        return None

    def save(self, contents: bytes) -> None:
        """Nothing is kept."""


class Card:
    """An IF1 or IF2 as it lies on the bench.

    `dtr rts` are its outputs, `dsr cts` the terminals where a host's lines arrive; what the interface sees at DSR and
    CTS depends on the `wiring`.
    """

    def __init__(self, clock: Clock, axes: Mapping[str, PulseAxis], options: Options, store: Store) -> None:
        self.clock, self.axes, self.options, self.store = clock, axes, options, store
        low = {name: Pin(clock, name) for name in (*INPUTS, *OUTPUTS, "led")}
        self.pins = {**low, **{name: Pin(clock, name, level=True) for name in CLOSED}}
        self.uart = Uart(clock, format=None)
        self.dtr, self.rts, self.dsr, self.cts = (Pin(clock, name) for name in ("dtr", "rts", "dsr", "cts"))
        self._seen = _Wiring(self, options.wiring)
        if options.fault_output:
            connect(self.pins["led"], self.pins["output5"])
        self.alarms = Alarms(*ALARMS)
        self._interface: Interface | None = None

    @property
    def busy(self) -> bool:
        """Moving, waiting for an input, pulsing an output, or calculating a ramp."""
        return self._interface is not None and (self._interface.busy or self._interface.deaf)

    def power(self, on: bool) -> None:
        """Switch it on or off."""
        if on and self._interface is None:
            self._interface = Interface(
                self.clock, self.uart, self._seen, self.pins, self.axes, self.options, self.store
            )
            self._interface.faults.on_fault = self.alarms.tell
        elif not on and self._interface is not None:
            self._interface.power_off()
            self._interface = None
            self.uart.format, self.uart.on_measure = None, lambda low_ns: None
            for pin in (self.dtr, self.rts, *(self.pins[name] for name in (*OUTPUTS, "led"))):
                pin.set(False)

    def registers(self) -> Mapping[str, Register]:
        """Faults and status, named after the commands that report them; K without what follows from the motion."""

        def kept(read: Callable[[Interface], int | str]) -> Callable[[], int | str]:
            return lambda: 0 if self._interface is None else read(self._interface)

        def told(read: Callable[[Interface], str]) -> Callable[[], str]:
            return lambda: "off" if self._interface is None else read(self._interface)

        return {
            "state": Register(told(lambda interface: interface.state.value), text=True),
            "E": Register(told(busy_letter), text=True),
            "K": Register(kept(lambda interface: int(interface.faults.status()))),
            "F": Register(kept(communication_bits)),
            "I": Register(kept(lambda interface: interface.faults.inputs())),
            "O": Register(kept(lambda interface: interface.step_number)),
        }


class _Wiring:
    """What the interface finds at its control lines."""

    def __init__(self, card: Card, wiring: str) -> None:
        self.dtr, self.rts, self.dsr, self.cts = card.dtr, card.rts, card.dsr, card.cts
        if wiring != "5-wire":
            self.dsr, self.cts = Pin(card.clock, "dsr"), Pin(card.clock, "cts")
            connect(card.dtr if wiring == "3-wire DSR-DTR" else card.rts, self.dsr)
            connect(card.rts, self.cts)


def _without_battery(clock: Clock, axes: Mapping[str, PulseAxis], options: Options, _: Store) -> Card:
    return Card(clock, axes, options, NoBattery())


def _product(
    model: str, title: str, build: Callable[[Clock, Mapping[str, PulseAxis], Options, Store], Card], battery: bool
) -> Product:
    return Product(
        model=model,
        title=title,
        commands=COMMANDS,
        axes=("X", "Y", "Z"),
        options=Options,
        build=build,
        check=partial(check, battery=battery),
        rules=RULES,
        line=UartFormat(9600, 8, "N", 2),
        limit_pins=("limit_minus", "limit_plus"),
        output_pins=(*OUTPUTS, "led"),
        drive_fault_pins={axis: pin for pin, axis in DRIVES.items()},
    )


PRODUCTS = {
    "if1": _product("if1", "Digiplan IF1 stepper motor interface", _without_battery, battery=False),
    "if2": _product("if2", "Digiplan IF2 stepper motor interface with battery backup", Card, battery=True),
}
