"""The user's interface to a controller on a bench: ports, pins, axes, registers, programs and power."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from axistwin.bench.fitting import Plug, fit_second_port
from axistwin.controllers.product import Awaited, Device, Follower, Listing, Product, Register
from axistwin.core.errors import UsageError
from axistwin.core.storage import FileStore, MemoryStore
from axistwin.plant.axes import Axis
from axistwin.plant.joystick import Joystick
from axistwin.plant.master import Master
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim.clock import Clock
from axistwin.sim.frames import UartFormat
from axistwin.sim.manual_actions import ManualAct, ManualActions
from axistwin.sim.pins import Pin
from axistwin.sim.progress import Line, LineWatcher
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import SerialPort

if TYPE_CHECKING:
    from axistwin.bench.bench import Bench


class Controller:
    """A controller on a bench, with its ports, pins and axes."""

    def __init__(
        self, name: str, made: Product, device: Device, axes: Mapping[str, Axis], plug: Plug | None, clock: Clock
    ) -> None:
        self.name, self.product = name, made
        self.axes: Mapping[str, Axis] = axes
        self.pins: Mapping[str, Pin] = device.pins
        self.bench: Bench | None = None
        self._device, self._plug = device, plug
        self._clock = clock
        self.manual_actions = ManualActions(self._clock)  # Reports actions of a person, e.g. of the power switch.
        self.powered = False
        self._turns: deque[bool] = deque()  # Pending requests to switch the power on (True) or off (False).
        self.given: Mapping[str, Any] = {}  # Options that were given to `Bench.add`, but the directory for the state.
        self.store: MemoryStore | FileStore = MemoryStore()
        self._abilities = device.abilities
        self._second = fit_second_port(self._abilities, plug)
        self._asked_for_second = False
        # Key: channel of the motor, e.g. "rs485".  Value: name of the shared serial line at this channel.
        self._lines: dict[str, str] = {}
        self.subscribe_hint = device.abilities.subscribe_hint
        self.subscribe_refusals = device.abilities.subscribe_refusals
        self.alarms = self._abilities.alarms  # Fault flags, to subscribe to; None without.
        self._servo = next((axis for axis in axes.values() if isinstance(axis, ServoAxis)), None)

    def __repr__(self) -> str:
        return f"<Controller {self.name}: {self.product.model}>"

    @property
    def serial(self) -> SerialPort:
        """Serial port for the host.  Raises UsageError for a controller on a bus or in a daisy chain."""
        if self._plug is None:
            raise UsageError(f"controller {self.name} has no serial port: use its attribute `bus`")
        if "serial" in self._lines:
            chain = self._lines["serial"]
            raise UsageError(
                f"{self.name} has no serial port of its own in the daisy chain {chain!r}: use Bench.port({chain!r})"
            )
        return self._plug.port

    @property
    def line_format(self) -> UartFormat | None:
        """Format of the characters that the controller receives; None on a bus, or while the format is not known."""
        return None if self._abilities.uart is None else self._abilities.uart.format

    @property
    def rs485(self) -> SerialPort:
        """RS-485 port for the host.  Raises UsageError for a controller without an RS-485 channel."""
        if "rs485" in self._lines:
            line = self._lines["rs485"]
            raise UsageError(
                f"{self.name} is connected to the shared RS-485 line {line!r}: "
                f"use Bench.port({line!r}) instead of the attribute `rs485` of the motor"
            )
        if self._second is None:
            raise UsageError(f"{self.name} has no RS-485 channel: expected a SmartMotor")
        self._asked_for_second = True
        return self._second

    @property
    def bus(self) -> RegisterPort:
        """The host's port to the controller's registers.  Raises UsageError for a controller without a bus."""
        if self._abilities.bus is None:
            raise UsageError(f"controller {self.name} has no bus port: use its serial port (attribute `serial`)")
        return self._abilities.bus

    @property
    def ports(self) -> dict[str, SerialPort]:
        """The controller's own serial ports, by name; the second channel is included after its first use."""
        found = {} if self._plug is None or "serial" in self._lines else {self.name: self._plug.port}
        if self._second is not None and self._asked_for_second and "rs485" not in self._lines:
            found[f"{self.name}.rs485"] = self._second
        return found

    @cached_property
    def terminals(self) -> Mapping[str, Pin]:
        """All terminals of the controller: pins, control lines of the serial port, interrupt line of the bus."""
        if self._abilities.bus is not None:
            return {**self.pins, "interrupt": self._abilities.bus.interrupt_line}
        if self._abilities.handshake is None:
            return self.pins
        lines = self._abilities.handshake.inside
        return {**self.pins, "dtr": lines.dtr, "rts": lines.rts, "dsr": lines.dsr, "cts": lines.cts}

    @cached_property
    def joystick(self) -> Joystick:
        """Joystick at the inputs of the controller.  Raises UsageError if the controller has no joystick input."""
        if self.product.joystick is None:
            raise UsageError(f"{self.name} has no joystick input: expected an 1810 or an 1811")
        return Joystick(self._clock, self.pins, self.product.joystick)

    @cached_property
    def registers(self) -> Mapping[str, Register]:
        """Registers of the controller: numbers and texts that can be read and traced."""
        return self._abilities.registers()

    def follow(self, names: Sequence[str], follower: Follower) -> Callable[[], None] | None:
        """Call `follower` with each change of the named registers, perhaps with delay; return an unsubscribe function.

        None if the registers change only at events, so that the caller can read them there.
        """
        follow = self._abilities.follow
        return None if follow is None else follow(names, follower)

    @property
    def has_variables(self) -> bool:
        """True if the controller has variables or gains that `assign` can set."""
        return self._abilities.assign is not None

    def assign(self, name: str, value: int) -> None:
        """Set a variable or gain at once, e.g. `motor.assign("KP", 100)`.  Raises UsageError if there is none."""
        if self._abilities.assign is None:
            raise UsageError(f"{self.name} has no variables: expected a SmartMotor")
        self._abilities.assign(name, value)

    def read(self, source: str) -> int | str | None:
        """Return the level of the terminal or the value of the register `source`; None without power."""
        if not self.powered:
            return None
        return self.terminals[source].level if source in self.terminals else self.registers[source].read()

    @property
    def programs(self) -> Mapping[str, Listing]:
        """Stored programs or sequences by name, each with the line that is running now."""
        return self._abilities.programs()

    def subscribe_lines(self, watcher: LineWatcher, only: Line | None = None) -> Callable[[], None]:
        """Call `watcher(program, index)` when the execution of a program line begins.

        `index` is from 0.  `only`: report this program and index only, which may take much less computing time.  The
        callback may read the bench but must not change it.  Return an unsubscribe function.  A controller without
        programs never calls it.
        """
        return self._abilities.subscribe_lines(watcher, only)

    @property
    def ambient(self) -> float:
        """Temperature around the motor, in °C.  Raises UsageError unless the controller is a SmartMotor."""
        return self._motor("ambient").ambient

    @ambient.setter
    def ambient(self, celsius: float) -> None:
        self._motor("ambient").ambient = celsius

    @property
    def master(self) -> Master:
        """The external encoder at pins A and B of a SmartMotor.  Raises UsageError for other controllers."""
        return self._motor("master").master

    @property
    def hint(self) -> str:
        """Status hint: the reason why the controller does not move, and the remedy; "" if there is no problem."""
        return self._abilities.hint()

    @property
    def awaited(self) -> Awaited | None:
        """The input for which the controller waits, or None if the controller is not waiting for an input."""
        return self._abilities.awaited()

    @property
    def ignoring(self) -> str:
        """The reason why the controller ignores the host's commands, e.g. "asleep"; "" if it does not."""
        return self._abilities.ignoring()

    def port_name(self, channel: int) -> str:
        """Return the name of the port or shared line at a serial channel (0 or 1), or of the board on a bus."""
        own = f"{self.name}.rs485" if channel else self.name
        return self._lines.get("rs485" if channel else "serial", own)

    @property
    def busy(self) -> bool:
        """True while the controller processes a host's request; False for a device that does not report it."""
        return self._abilities.busy()

    def power(self, on: bool) -> None:
        """Switch the power on or off.

        The controller keeps the data that the real device keeps without power.  If one of the controller's own
        procedures switches the power (by an edge that has subscribers), the power changes when the procedure next
        yields, in the same nanosecond.
        """
        self.manual_actions.report(ManualAct.POWER, on)
        self._clock.call_outside(self._abilities.procedures(), partial(self._switch, on))

    def power_cycle(self) -> None:
        """Switch the power off and on again."""
        self.power(False)
        self.power(True)

    def _switch(self, on: bool) -> None:
        """Switch the power on or off.  A change that a subscriber requests during this call is made afterwards."""
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

    def _motor(self, attribute: str) -> ServoAxis:
        if self._servo is None:
            raise UsageError(f"{self.name} has no attribute `{attribute}`: only a SmartMotor has this attribute")
        return self._servo

    def _rs485_uart(self) -> Uart:
        if self._abilities.rs485 is None:
            raise UsageError(f"{self.name} has no RS-485 channel: expected a SmartMotor")
        return self._abilities.rs485

    def _serial_uart(self) -> Uart:
        if self._abilities.uart is None or self._abilities.handshake is not None:
            raise UsageError(f"{self.name} cannot be in a daisy chain: expected a SmartMotor")
        return self._abilities.uart


def on_a_bus(controller: Controller) -> bool:
    return controller.product.attend is not None
