"""The SmartMotor as a device: its terminals and plugs exist with and without power."""

import re
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from axistwin.controllers.product import Abilities, Order, Product, Refusal, Store
from axistwin.controllers.smartmotor.chapters.faults import ALARMS, inhibition
from axistwin.controllers.smartmotor.commands import COMMANDS
from axistwin.controllers.smartmotor.kernel import jit
from axistwin.controllers.smartmotor.kernel.core import prepare, prepared
from axistwin.controllers.smartmotor.kernel.state import USER_PINS
from axistwin.controllers.smartmotor.language.language import command
from axistwin.controllers.smartmotor.listing import PROGRAM_NAME, Lines
from axistwin.controllers.smartmotor.motor import Fittings, Motor
from axistwin.controllers.smartmotor.options import Options
from axistwin.controllers.smartmotor.registers import Registers
from axistwin.controllers.smartmotor.terminals import EncoderPin, IndexLine
from axistwin.core.errors import UsageError
from axistwin.plant.axes import servo_axis
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim.clock import Clock
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin, UserPin
from axistwin.sim.serial import Uart
from axistwin.sim.signal import Alarms, Signal

ASLEEP = "asleep, so that it ignores all commands but WAKE"
NOT_ADDRESSED = "not addressed: the last address byte was that of another motor"
CLOSED = "its channel 0 is closed, or receives data, so that nothing is a command"


class SmartMotor:
    """A SmartMotor with its terminals, serial ports, shaft and power supply."""

    def __init__(self, clock: Clock, axes: Mapping[str, Any], options: Options, store: Store) -> None:
        axis: ServoAxis = axes["shaft"]
        user_pins: dict[str, UserPin] = {name: UserPin(clock, name) for name in USER_PINS}
        user_pins |= {name: EncoderPin(clock, name, axis.master) for name in "AB"}
        self.uart, self.rs485 = Uart(clock, format=UartFormat()), Uart(clock, format=UartFormat())
        self.options = options
        self._index = IndexLine(clock)
        self.pins: dict[str, Pin] = {**user_pins, "brake": Pin(clock, "brake", True, output=True), "index": self._index}
        brake, uarts = self.pins["brake"], (self.uart, self.rs485)
        self._fittings = Fittings(axis, self._index, brake, user_pins, uarts, store, [])
        self.alarms = Alarms(*ALARMS.values())
        self._hints: Signal[[str]] = Signal()
        self._refusals: Signal[[Refusal]] = Signal()
        self._motor: Motor | None = None
        # After power-off, the shaft of the motor may still turn.  `_before` simulates this movement of the shaft.
        self._before: Motor | None = None
        self._switched_on = False
        axis.on_supply.subscribe(self._update_power)
        self._lines = Lines()
        self._registers = Registers(clock, self._lines)
        self.abilities = Abilities(
            uart=self.uart, rs485=self.rs485, alarms=self.alarms, registers=self._registers.table,
            follow=self._registers.follow, programs=self._lines.listings,
            subscribe_lines=self._lines.progress.subscribe, hint=self.hint, assign=self.assign,
            subscribe_hint=self._hints.subscribe, subscribe_refusals=self._refusals.subscribe,
            ignoring=self.ignoring,
        )  # fmt: skip

    def power(self, on: bool) -> None:
        """Switch the motor on or off.  The processor runs only while the supply voltage is high enough."""
        self._switched_on = on
        self._update_power()

    def _update_power(self) -> None:
        on = self._switched_on and self._fittings.axis.supply_v >= self.options.reset_below_v
        if on and self._motor is None:
            if self._before is not None:
                self._before.leave()
            self._motor = Motor(self._fittings, self.options, self._restart)
            self._motor.on_fault = self.alarms.emit
            self._motor.on_refusal = self._hints.emit
            self._motor.on_refused_command = self._refusals.emit
            self._lines.connect(self._motor)
            self._registers.connect(self._motor)
            self._index.connect(self._motor)
        elif not on and self._motor is not None:
            self._motor.power_off()
            self._before, self._motor = self._motor, None
            self._index.connect(None)
            self._registers.connect(None)
            self._let_go()

    def hint(self) -> str:
        """Return the reason why the motor does not move, and the remedy.  The text is empty if a move is possible."""
        if self._motor is None:
            return f"{self.ignoring()}: raise it, or lower the option reset_below_v" if self._switched_on else ""
        self._motor.catch_up(changing=False)
        return f"{ASLEEP}: WAKE" if self._motor.channels[0].asleep else inhibition(self._motor)

    def ignoring(self) -> str:
        """Return why the motor ignores the commands on serial channel 0; "" if it obeys, or is off."""
        if self._motor is None:
            low = f"held in reset, as its supply is below {self.options.reset_below_v:g} V"
            return low if self._switched_on else ""
        channel = self._motor.channels[0]
        if not channel.obeys:
            return CLOSED
        if not channel.addressed:
            return NOT_ADDRESSED
        return ASLEEP if channel.asleep else ""

    def assign(self, name: str, value: int) -> None:
        """Set a variable, e.g. `a` or `al[3]`, a parameter, or a gain, with F.  Raises UsageError if there is none."""
        statement = command(f"{name}={value}")
        if self._motor is None or statement.problem is not None or not NAME.fullmatch(name):
            raise UsageError(
                f"invalid assignment {name}={value}: expected a variable, parameter or gain, e.g. KP=100 or a=3"
            )
        self._motor.execute(self._motor.channels[0], statement.text)
        if name in GAINS:
            self._motor.execute(self._motor.channels[0], "F")

    def _restart(self) -> None:
        self.power(False)
        self.power(True)

    def _let_go(self) -> None:
        for pin in self._fittings.user_pins.values():
            pin.input()
        self.pins["brake"].set(True)


NAME = re.compile(r"[A-Za-z]+|a[bwl]\[\d{1,3}\]", re.ASCII)  # A variable, parameter, gain or array element.
GAINS = ("KP", "KI", "KD", "KL", "KS", "KV", "KA", "KG")  # Coefficients of the PID filter, which F puts in force.
ORDERS = (
    Order("RUN", b"RUN\r", "Start the stored program from the top"),
    Order("END", b"END\r", "End the program; motion continues"),
)
SMARTMOTOR = Product(
    "smartmotor", "Animatics SmartMotor, firmware 4.76", COMMANDS, axes=("shaft",), options=Options,
    family="smartmotor", suffix=".sms", build=SmartMotor, make_axis=servo_axis, note=jit.note, prepare=prepare,
    prepared=prepared,
    check=lambda sessions: import_module(f"{__package__}.checker.program").check(sessions),
    make_rules=lambda: import_module(f"{__package__}.rules").RULES,
    make_front=lambda: import_module(f"{__package__}.front").FRONT,
    line=UartFormat(), limit_pins={"shaft": ("D", "C")}, brake_pin="brake", closed_level=False,
    programs=(PROGRAM_NAME,), orders=lambda program: ORDERS,
)  # fmt: skip
