"""The card itself: its terminals and its plug, which are there with and without power (chapter Installation)."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from axistwin.controllers.digiplan.chapters.battery_backup import Retained
from axistwin.controllers.digiplan.chapters.faults import ALARMS, CLOSED, DRIVES
from axistwin.controllers.digiplan.chapters.initialise import State
from axistwin.controllers.digiplan.chapters.motion import DIRECTIONS
from axistwin.controllers.digiplan.chapters.outputs import Outputs
from axistwin.controllers.digiplan.chapters.report import busy_letter, communication_bits, motion_bits, steps
from axistwin.controllers.digiplan.chapters.terminals import CABLES
from axistwin.controllers.digiplan.checker.program import check
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.front import FRONT
from axistwin.controllers.digiplan.interface import Interface
from axistwin.controllers.digiplan.language import MOST_STEPS
from axistwin.controllers.digiplan.listing import SEQUENCE, listed
from axistwin.controllers.digiplan.options import Options
from axistwin.controllers.digiplan.rules import RULES
from axistwin.controllers.product import Abilities, Handshake, Listing, Order, Product, PulseAxis, Register, Store
from axistwin.sim.alarms import Alarms
from axistwin.sim.clock import Clock, Process
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import CalculatedPin, Pin, connect
from axistwin.sim.progress import Progress
from axistwin.sim.serial import Uart

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
        self.pins = {name: Pin(clock, name) for name in INPUTS}
        self.pins |= {name: Pin(clock, name, output=True) for name in (*OUTPUTS, "led")}
        self.pins |= {name: Pin(clock, name, level=True) for name in (*CLOSED, "supply")}
        self.pins |= {name: Pin(clock, name, level=True, output=True) for name in DIRECTIONS.values()}
        self.pins |= {f"{axis.lower()}_clock": self._clock_output(axis) for axis in DIRECTIONS}
        self._outputs = Outputs(self.pins, follow_led=options.fault_output)
        self.uart = Uart(clock, format=None)
        self.dtr, self.rts = (Pin(clock, name, output=True) for name in ("dtr", "rts"))
        self.dsr, self.cts = (Pin(clock, name) for name in ("dsr", "cts"))
        self.lines = _Wiring(self, options.wiring)
        self.alarms = Alarms(*ALARMS)
        self._progress = Progress()
        self._trouble_watchers: list[Callable[[str], None]] = []
        self._interface: Interface | None = None
        self.abilities = Abilities(
            uart=self.uart, handshake=Handshake(self, self.lines), alarms=self.alarms, registers=self.registers,
            programs=self.programs, subscribe_lines=self._progress.subscribe, hint=self.hint,
            subscribe_hint=self.subscribe_hint, busy=self._busy, procedures=self._procedures,
        )  # fmt: skip

    def _clock_output(self, axis: str) -> Pin:
        return CalculatedPin(
            self.clock,
            f"{axis.lower()}_clock",
            lambda: self._interface is not None and self._interface.motion.clock_level(axis),
        )

    def _busy(self) -> bool:
        """Moving, waiting for an input, pulsing an output, or calculating a ramp."""
        return self._interface is not None and (self._interface.busy or self._interface.deaf)

    def _procedures(self) -> Sequence[Process]:
        """Those of the interface."""
        return () if self._interface is None else self._interface.procedures

    def power(self, on: bool) -> None:
        """Switch it on or off."""
        if on and self._interface is None:
            self._interface = Interface(
                self.clock, self.uart, self.lines, self.pins, self._outputs, self.axes, self.options, self.store
            )
            self._interface.on_trouble = self._tell_trouble
            self._interface.faults.on_fault = self.alarms.report
            self._interface.on_step = lambda number: self._progress.report(SEQUENCE, number - 1)
        elif not on and self._interface is not None:
            self._interface.power_off()
            self._interface = None
            self.uart.format, self.uart.on_measure = None, lambda low_ns: None
            for pin in (self.dtr, self.rts, self.pins["led"]):
                pin.set(False)
            for name in DIRECTIONS.values():
                self.pins[name].set(True)
            self._outputs.reset()

    def hint(self) -> str:
        """Why it takes no commands, while it waits for the baud rate or the data format and drops what comes."""
        return "" if self._interface is None else self._interface.trouble

    def subscribe_hint(self, watcher: Callable[[str], None]) -> Callable[[], None]:
        """Call `watcher(line)` when there is something to tell.  Returns what ends it."""
        self._trouble_watchers.append(watcher)
        return lambda: self._trouble_watchers.remove(watcher)

    def _tell_trouble(self, line: str) -> None:
        for watcher in tuple(self._trouble_watchers):
            watcher(line)

    def programs(self) -> Mapping[str, Listing]:
        """The one sequence, steps 1 to 63; none of them runs before it has begun and when it has ended."""
        interface = self._interface
        if interface is None:
            return {SEQUENCE: Listing("stored sequence", listed(Retained.recall(self.store).sequence))}
        running = interface.step - 1 if interface.step else None
        return {SEQUENCE: Listing("stored sequence", listed(interface.kept_sequence), running)}

    def registers(self) -> Mapping[str, Register]:
        """Faults and status, named after the commands that report them; K without what follows from the motion.

        Q is K with it.  E is empty until there is a data format, since the command is not answered before.
        `step` is the step of the sequence that is being carried out; 0: none is, where O stays at the last one.
        """

        def kept(read: Callable[[Interface], int | str]) -> Callable[[], int | str]:
            return lambda: 0 if self._interface is None else read(self._interface)

        def told(read: Callable[[Interface], str]) -> Callable[[], str]:
            return lambda: "off" if self._interface is None else read(self._interface)

        return {
            "state": Register(told(lambda interface: interface.state.value), text=True),
            "E": Register(told(_busy_status), text=True),
            "K": Register(kept(lambda interface: int(interface.faults.status()))),
            "F": Register(kept(communication_bits)),
            "I": Register(kept(lambda interface: interface.faults.inputs())),
            "O": Register(kept(lambda interface: interface.step_number)),
            "Q": Register(kept(motion_bits), restless=True),
            "N": Register(kept(steps), restless=True),
            "step": Register(kept(lambda interface: interface.step)),
        }


def _busy_status(interface: Interface) -> str:
    """The letter of E, once the interface answers."""
    return busy_letter(interface) if interface.state is State.READY else ""


class _Wiring:
    """What the interface finds at its control lines."""

    def __init__(self, card: Card, wiring: str) -> None:
        self.dtr, self.rts = card.dtr, card.rts
        self._own = {"dtr": card.dtr, "rts": card.rts}
        self.dsr = self._input(card.dsr, CABLES[wiring].dsr)
        self.cts = self._input(card.cts, CABLES[wiring].cts)

    def _input(self, plug: Pin, source: str) -> Pin:
        """DSR or CTS, connected to the plug, to an output of its own, or to nothing, which leaves it reset."""
        if source == "host":
            return plug
        found = Pin(plug.clock, plug.name)
        if source:
            connect(self._own[source], found)
        return found


ORDERS = (
    Order("start :$", b":$\r\n", "Carry out the stored sequence from its first step"),
    Order("cancel #", b"#\r\n", "Cancel: stop every axis with deceleration, end the sequence"),
)
"""Ended for both data formats: in V it is LF that ends them and CR is optional, in U a LF means nothing."""


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
        drive_fault_pins={axis: pin for pin, axis in DRIVES.items()},
        front=FRONT,
        programs=(SEQUENCE,),
        orders=lambda program: ORDERS,
        most_lines=MOST_STEPS,
    )


PRODUCTS = {
    "if1": _product("if1", "Digiplan IF1 stepper motor interface", _without_battery, battery=False),
    "if2": _product("if2", "Digiplan IF2 stepper motor interface with battery backup", Card, battery=True),
}
