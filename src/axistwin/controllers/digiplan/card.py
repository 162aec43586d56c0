"""The installed interface card: terminals, RS232 plug and power switch (chapter Installation)."""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module

from axistwin.controllers.digiplan.chapters.battery_backup import Retained
from axistwin.controllers.digiplan.chapters.faults import ALARMS, CLOSED, DRIVES, MotionFault
from axistwin.controllers.digiplan.chapters.motion import DIRECTIONS
from axistwin.controllers.digiplan.chapters.outputs import Outputs, awaited
from axistwin.controllers.digiplan.chapters.report import busy_letter, communication_bits, motion_bits, steps
from axistwin.controllers.digiplan.chapters.terminals import CABLES, Cable
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.interface import Interface
from axistwin.controllers.digiplan.language import MOST_STEPS
from axistwin.controllers.digiplan.listing import SEQUENCE, listed
from axistwin.controllers.digiplan.options import Options
from axistwin.controllers.digiplan.state import Hardware, Stage
from axistwin.controllers.product import (
    Abilities,
    Awaited,
    ControlLines,
    Handshake,
    Listing,
    Order,
    Product,
    Refusal,
    Register,
    Store,
)
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.clock import Clock, Process
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import CalculatedPin, Pin, connect
from axistwin.sim.progress import Progress
from axistwin.sim.serial import Uart
from axistwin.sim.signal import Alarms, Signal

OUTPUTS = tuple(f"output{number}" for number in range(1, 6))
INPUTS = ("input1", "input2", "input3")
ENDED_BY = {
    MotionFault.EMERGENCY_STOP: "the emergency stop",
    MotionFault.LIMIT: "a limit switch",
    MotionFault.DRIVE: "a drive fault",
}
"""Name of each fault that ends a sequence."""


class NoBattery:
    """Memory of an IF1, which has no battery and therefore loses all data at power-off."""

    def load(self) -> bytes | None:
        """Return None: nothing is stored."""
        return None

    def save(self, contents: bytes) -> None:
        """Store nothing."""


class Card:
    """An IF1 or IF2 with its pins, its serial line and its axes."""

    def __init__(self, clock: Clock, axes: Mapping[str, StepperAxis], options: Options, store: Store) -> None:
        self.clock, self.axes, self.options, self.store = clock, axes, options, store
        self.pins = {name: Pin(clock, name) for name in INPUTS}
        self.pins |= {name: Pin(clock, name, output=True) for name in (*OUTPUTS, "led")}
        self.pins |= {name: Pin(clock, name, level=True) for name in (*CLOSED, "supply")}
        self.pins |= {name: Pin(clock, name, level=True, output=True) for name in DIRECTIONS.values()}
        self.pins |= {f"{axis.lower()}_clock": self._clock_output(axis) for axis in DIRECTIONS}
        self.uart = Uart(clock, format=None)
        outward = (Pin(clock, name, output=True) for name in ("dtr", "rts"))
        self._plug = ControlLines(*outward, *(Pin(clock, name) for name in ("dsr", "cts")))
        inside = _wired(self._plug, CABLES[options.wiring])
        outputs = Outputs(self.pins, follow_led=options.fault_output)
        self._hardware = Hardware(clock, self.uart, inside, self.pins, outputs, axes, options, store)
        self.alarms = Alarms(*ALARMS)
        self._progress = Progress()
        self._hints: Signal[[str]] = Signal()
        self._refusals: Signal[[Refusal]] = Signal()
        self._interface: Interface | None = None
        self.abilities = Abilities(
            uart=self.uart, handshake=Handshake(self._plug, inside), alarms=self.alarms, registers=self.registers,
            programs=self.programs, subscribe_lines=self._progress.subscribe, hint=self.hint,
            awaited=self.awaited, subscribe_hint=self._hints.subscribe, subscribe_refusals=self._refusals.subscribe,
            busy=self._busy, procedures=self._procedures,
        )  # fmt: skip

    def _clock_output(self, axis: str) -> Pin:
        def level() -> bool:
            return self._interface is not None and self._interface.motion.clock_level(axis)

        return CalculatedPin(self.clock, f"{axis.lower()}_clock", level)

    def _busy(self) -> bool:
        return self._interface is not None and (self._interface.work.busy or self._interface.muted)

    def _procedures(self) -> Sequence[Process]:
        return () if self._interface is None else self._interface.procedures

    def power(self, on: bool) -> None:
        if on and self._interface is None:
            self._interface = Interface(self._hardware)
            self._interface.on_hint = self._hints.emit
            self._interface.on_refusal = self._refusals.emit
            self._interface.faults.on_fault = self.alarms.emit
            self._interface.on_step = lambda number: self._progress.report(SEQUENCE, number - 1)
        elif not on and self._interface is not None:
            self._interface.power_off()
            self._interface = None
            self.uart.format, self.uart.on_measure = None, lambda low_ns: None
            for pin in (self._plug.dtr, self._plug.rts, self.pins["led"]):
                pin.set(False)
            for name in DIRECTIONS.values():
                self.pins[name].set(True)
            self._hardware.outputs.reset()

    def hint(self) -> str:
        """Return why no move begins, e.g. that a step waits for an input; "" if there is no such reason."""
        if found := self.awaited():
            work, pin, level = found
            if self.pins[pin].held:
                act, why = "mend all", f", but an injected fault holds {pin}"
            else:
                act, why = f"{pin} {level}", ""
            return f"{work} waits for {pin} {level}{why}: ! {act} in a program, :drive {act} in a terminal"
        return "" if self._interface is None else self._interface.hint

    def awaited(self) -> Awaited | None:
        """Return the input for which a step waits, or None if no step waits for an input."""
        interface = self._interface
        if interface is None or interface.hint or interface.waiting is None:
            return None
        work = f"step {interface.step} of the sequence" if interface.step else "the move"
        return Awaited(work, *awaited(self.pins, interface.waiting))

    def programs(self) -> Mapping[str, Listing]:
        interface = self._interface
        if interface is None:
            return {SEQUENCE: Listing("stored sequence", listed(Retained.recall(self.store).sequence))}
        running = interface.step - 1 if interface.step else None
        ended_by = " and ".join(ENDED_BY[fault] for fault in ENDED_BY if fault in interface.ended_by)
        return {SEQUENCE: Listing("stored sequence", listed(interface.kept_sequence), running, ended_by=ended_by)}

    def registers(self) -> Mapping[str, Register]:
        """Return the status registers, each named after the command that reports it.

        K is without the motion bits, Q includes them.  E is empty until the data format is set, because the interface
        answers no command before that.  `step` is the step in progress, or 0 if no sequence runs; O keeps the number of
        the last step.
        """

        def figure(read: Callable[[Interface], int], *, restless: bool = False) -> Register:
            return Register(lambda: 0 if self._interface is None else read(self._interface), restless=restless)

        def text(read: Callable[[Interface], str]) -> Register:
            return Register(lambda: "off" if self._interface is None else read(self._interface), text=True)

        return {
            "state": text(lambda it: it.stage.value),
            "E": text(lambda it: busy_letter(it) if it.stage is Stage.READY else ""),
            "K": figure(lambda it: int(it.faults.status())),
            "F": figure(communication_bits),
            "I": figure(lambda it: it.faults.inputs()),
            "O": figure(lambda it: it.step_number),
            "Q": figure(motion_bits, restless=True),
            "N": figure(steps, restless=True),
            "step": figure(lambda it: it.step),
        }


def _wired(plug: ControlLines, cable: Cable) -> ControlLines:
    def line(pin: Pin, source: str) -> Pin:
        """Return DSR or CTS, connected to the host, to an output of the interface, or to nothing (then reset)."""
        if source == "host":
            return pin
        line = Pin(pin.clock, pin.name)
        if source:
            connect({"dtr": plug.dtr, "rts": plug.rts}[source], line)
        return line

    return plug._replace(dsr=line(plug.dsr, cable.dsr), cts=line(plug.cts, cable.cts))


ORDERS = (
    Order("start :$", b":$\r\n", "Carry out the stored sequence from its first step"),
    Order("cancel #", b"#\r\n", "Cancel: stop every axis with deceleration, end the sequence"),
)
"""CR LF ends a message in both data formats: U ignores LF; in V, LF ends the message and CR is optional."""


def _product(model: str, title: str, battery: bool) -> Product:
    return Product(
        model, title, COMMANDS, axes=("X", "Y", "Z"), options=Options, family="digiplan", suffix=".if1",
        build=lambda clock, axes, options, store: Card(clock, axes, options, store if battery else NoBattery()),
        check=lambda sessions: import_module(f"{__package__}.checker.program").check(sessions, battery),
        make_rules=lambda: import_module(f"{__package__}.rules").RULES,
        make_front=lambda: import_module(f"{__package__}.front").FRONT,
        line=UartFormat(9600, 8, "N", 2), limit_pins=dict.fromkeys("XYZ", ("limit_minus", "limit_plus")),
        drive_fault_pins={axis: pin for pin, axis in DRIVES.items()},
        programs=(SEQUENCE,), orders=lambda program: ORDERS, most_lines=MOST_STEPS,
    )  # fmt: skip


IF1 = _product("if1", "Digiplan IF1 stepper motor interface", battery=False)
IF2 = _product("if2", "Digiplan IF2 stepper motor interface with battery backup", battery=True)
