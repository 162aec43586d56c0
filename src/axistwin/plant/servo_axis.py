"""The axis of a servo motor: a shaft with an encoder, powered or not.

A *source* (the motor's processor) calculates the shaft's motion sample by sample, ahead of the clock.  All reads and
changes therefore use the source.  The machine's own state survives a loss of power and is kept here: physics, external
torques, ambient temperature, switches.
"""

from collections.abc import Callable, Mapping, MutableSequence, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar

from axistwin.core.errors import UsageError
from axistwin.core.lazy import NDArray, np
from axistwin.plant.counts import SAMPLES, CountHistory, Listener, Samples
from axistwin.plant.master import Followed, Master
from axistwin.plant.overrides import Override, Shaft
from axistwin.sim.clock import Clock
from axistwin.sim.manual_actions import ManualAct, check_counts
from axistwin.sim.motion.train import HISTORY
from axistwin.sim.signal import Signal

if TYPE_CHECKING:
    from axistwin.plant.servo import ServoLoad, ServoMotor

FAR = 1 << 62  # A position that no shaft can reach.
AMBIENT = 25.0  # Default temperature around the motor, in degrees Celsius.
COLDEST, HOTTEST = -40.0, 150.0
IDEAL_COUNTS_PER_REV = 2000  # Encoder counts per revolution of a shaft without a data sheet.


class Source:
    """Source of the motion of a shaft: this one, without power, is at rest; a processor overrides all of it.

    All values are those of the latest sample.
    """

    def __init__(self, axis: "ServoAxis") -> None:
        self._axis = axis

    def refresh(self) -> None:
        """Publish all samples up to now; state and predictions stay the same."""

    def catch_up(self) -> None:
        """Publish all samples up to now, before a change of state."""

    def replan(self) -> None:
        """Discard all predicted positions of the shaft, e.g. after a change of the load."""

    def position(self) -> int:
        """Position of the shaft in encoder counts, initially 0.  The positive direction is that of the machine."""
        return self._axis.shaft

    def commanded(self) -> int:
        """Commanded position in counts, in the coordinates of the controller; 0 without power."""
        return 0

    def positions_ahead(self, _times_ns: range) -> Sequence[int]:
        """Return the positions now and at these times, up to the first time at which an input could matter."""
        return [self._axis.shaft]

    def setpoint(self) -> int:
        return self._axis.shaft

    def velocity(self) -> float:
        return 0.0

    def moving(self) -> bool:
        return False

    def next_sample_ns(self) -> int | None:
        return None

    def temperature(self) -> float:
        return self._axis.ambient

    def energy_nj(self) -> int:
        """Electrical energy in nJ supplied to the motor's windings since the start of the simulation."""
        return self._axis.energy_nj

    def push(self, counts: int) -> None:
        axis = self._axis
        axis.shaft += counts
        axis.publish(Samples(axis.clock.now, 0, (axis.shaft,), (0,)))

    def slip(self, counts: int) -> None:
        """Simulate an encoder that slips on its shaft by `counts`; without power the encoder is not used."""


class EncoderView:
    """The user's interface to the encoder of a servo axis: encoder count, and simulated encoder faults."""

    def __init__(self, axis: "ServoAxis") -> None:
        self._axis, self.miscount, self.slip = axis, axis.miscount, axis.slip

    @property
    def count(self) -> int:
        return self._axis.position

    def displace(self, counts: int) -> None:
        """Turn the shaft by `counts`, as by hand; it stays there until the motor moves it back."""
        check_counts(counts, "displace")
        self._axis.push(counts)


class ServoAxis(Shaft):
    """Motor, load and encoder of a SmartMotor; ideal without a `motor`: the shaft follows exactly."""

    unit: ClassVar[str] = "counts"  # Unit of positions.

    def __init__(
        self, clock: Clock, name: str, *, motor: "ServoMotor | None" = None, load: "ServoLoad | None" = None,
        limits: tuple[int, int] | None = None, history: int = HISTORY,
    ) -> None:  # fmt: skip
        super().__init__(clock, name, limits, self._replan, self._catch_up)
        self.motor, self.load_data = motor, load
        self.f: MutableSequence[float] = []  # State of the physics, which the source updates.
        self.energy_nj = 0  # Energy that the windings have taken up to the last loss of power, in nJ.
        self.shaft = 0  # Position of the shaft while it has no power.
        self.counts_of, self.counts_out_of = 1, 1  # Counted, out of true counts: 9 of 10, -1 of 1, 0 of 1.
        self._supply = Override(1.0, self._supply_changed, self._catch_up)
        self._ambient = Override(AMBIENT, self._replan, self._catch_up)
        self.on_supply: Signal[[]] = Signal()
        self.master = Master(clock, self)  # The device wired to pins A and B.
        self.encoder = EncoderView(self)
        self.window_low, self.window_high = -FAR, FAR  # No switch changes within; see `left_window`.
        self._edges: list[int] = []
        self._left_window: Signal[[]] = Signal()
        self._published: Signal[Samples] = Signal()
        self._history_option = history
        self._counts = CountHistory(history * SAMPLES)
        self._source = Source(self)

    # Interface to the motor's processor

    def connect(self, source: Source) -> None:
        """Connect a source, which continues from the present state in `shaft` and `f`."""
        self._source = source

    def disconnect(self) -> None:
        """Disconnect the axis from the emulated processor; the shaft then stays at its present position."""
        self.shaft = self._source.position()
        self._source = Source(self)

    def publish(self, samples: Samples) -> None:
        """Send final samples to subscribers, in order of time, up to the present time.

        Between published samples the position is constant, so long rests need no samples.
        """
        self._counts.add(samples)
        self._published.emit(samples)

    def left_window(self) -> None:
        """Update the switches and set a new window, after the shaft has left the window in the present sample."""
        self._find_window()
        self._left_window.emit()

    # State of the axis, and manual actions

    @property
    def position(self) -> int:
        """Position of the shaft in encoder counts, initially 0.  The positive direction is that of the machine."""
        return self._source.position()

    @property
    def commanded(self) -> int:
        """Commanded position in counts, in the program's coordinates (`O=` shifts them, F=2 turns them)."""
        return self._source.commanded()

    @property
    def setpoint(self) -> int:
        """Commanded position in counts, actual with the servo off; `setpoint - position`: following error."""
        return self._source.setpoint()

    @property
    def per_rev(self) -> int:
        return IDEAL_COUNTS_PER_REV if self.motor is None else self.motor.counts_per_rev

    @property
    def velocity(self) -> float:
        """Velocity of the shaft in encoder counts per second; negative in the negative direction."""
        return self._source.velocity()

    @property
    def moving(self) -> bool:
        """True if the shaft turns or a trajectory is in progress."""
        return self._source.moving()

    @property
    def resting(self) -> bool:
        """Always False, because a shaft can be turned by hand at any time, without `on_motion`."""
        return False

    @property
    def predictable(self) -> bool:
        return False

    @property
    def follows(self) -> Followed | None:
        """The axis on which this motor's master encoder is mounted."""
        return self.master.followed

    def positions_at(self, times_ns: Sequence[int]) -> list[int]:  # noqa: ARG002
        """Raise an error, because positions of a servo cannot be predicted."""
        raise AssertionError(
            f"cannot predict the positions of axis {self.name}, because its motor is a servo motor: "
            "expected an axis with a stepper motor"
        )

    def positions_ahead(self, times_ns: range) -> Sequence[int]:
        """Return the position now, and the certain ones at `times_ns`, which are valid until `on_replan`."""
        return self._source.positions_ahead(times_ns)

    def next_sample_ns(self) -> int | None:
        """Virtual time in ns of the next sample of the position; None while the motor is at rest."""
        return self._source.next_sample_ns()

    @property
    def temperature(self) -> float:
        """Temperature of the motor, in degrees Celsius."""
        return self._source.temperature()

    @property
    def energy(self) -> float:
        """Energy in J that the windings have received; it falls while braking into the supply; 0 if ideal."""
        return self._source.energy_nj() / 1e9

    @property
    def ambient(self) -> float:
        """Temperature around the motor, in degrees Celsius.  Defects override the setting; the latest defect wins."""
        return self._ambient.values[-1]

    @ambient.setter
    def ambient(self, celsius: float) -> None:
        if not COLDEST <= celsius <= HOTTEST:
            raise UsageError(f"invalid ambient temperature {celsius!r}: expected {COLDEST:g} to {HOTTEST:g} °C")
        self.manual_actions.report(ManualAct.AMBIENT, celsius)
        self._ambient.set(float(celsius))

    def heat(self, celsius: float) -> Callable[[], None]:
        """Inject a fault: set the ambient temperature to `celsius`.  Return a function that ends the fault."""
        return self._ambient.add(celsius)

    @property
    def supply(self) -> float:
        """Supply voltage as a fraction of the nominal voltage, 0 to 1."""
        return min(self._supply.values)

    def sag(self, left: float) -> Callable[[], None]:
        return self._supply.add(left)

    def _catch_up(self) -> None:
        self._source.catch_up()

    def _replan(self) -> None:
        self._source.replan()

    @property
    def supply_v(self) -> float:
        """The supply voltage in V; infinite for an ideal motor, which has no data sheet."""
        return inf if self.motor is None else self.supply * self.motor.supply_voltage_v

    def _supply_changed(self) -> None:
        self._replan()
        self.on_supply.emit()

    def miscount(self, of: int, out_of: int) -> None:
        """From now on count `of` for each `out_of` counts.  The motor uses the wrong count."""
        self._source.catch_up()
        self.counts_of, self.counts_out_of = of, out_of
        self._source.replan()

    def slip(self, counts: int) -> None:
        """Simulate an encoder that slips on its shaft by `counts`.  The motor then uses the wrong count."""
        self._source.catch_up()
        self._source.slip(counts)
        self._source.replan()

    def push(self, counts: int) -> None:
        """Turn the shaft by `counts`, as a person does by hand."""
        self.manual_actions.report(ManualAct.PUSH, counts)
        self._source.catch_up()
        self._source.push(counts)
        self.left_window()

    def pulse_times(self, start_ns: int = 0, stop_ns: int | None = None) -> "NDArray[np.int64]":
        """Return the ns times of encoder count changes, from `start_ns` to before `stop_ns` (None: up to now).

        The count is known at samples; changes between two samples are spread evenly.
        """
        self.catch_up()
        stop_ns = self.clock.now + 1 if stop_ns is None else stop_ns
        return self._counts.times(start_ns, stop_ns, 2 * self._history_option)

    def subscribe(self, callback: Listener) -> Callable[[], None]:
        """Call `callback(samples)` for each new block of samples, in order of time.  Return an unsubscribe function.

        Samples may come in blocks; `catch_up` publishes all samples up to now.
        """
        self.catch_up()
        return self._published.subscribe(callback)

    def catch_up(self) -> None:
        """Publish all samples up to now, without any change."""
        self._source.refresh()

    @property
    def forgotten(self) -> bool:
        """True if old samples have been discarded."""
        return self._counts.forgotten_ns is not None

    # Switches

    def subscribe_edges(self, edges: Sequence[int], callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` after each crossing of `edges`, n between n-1 and n; return an unsubscribe function."""
        self._source.catch_up()
        self._edges += edges
        unsubscribe = self._left_window.subscribe(callback)
        self._find_window()
        self._source.replan()

        def end() -> None:
            for edge in edges:
                self._edges.remove(edge)
            unsubscribe()

        return end

    def _find_window(self) -> None:
        position = self.position
        self.window_low = max((edge for edge in self._edges if edge <= position), default=-FAR)
        self.window_high = min((edge - 1 for edge in self._edges if edge > position), default=FAR)


def data_sheets(given: Mapping[str, Any]) -> "tuple[ServoMotor | None, ServoLoad | None]":
    """Return the options `motor` and `load` as data; None without a motor: ideal.  Raises UsageError."""
    motor, load = given.get("motor"), given.get("load")
    if motor is None and load is None:
        return None, None
    # The import is here because an axis without the options `motor` and `load` does not need the servo model.
    from axistwin.plant import servo

    return None if motor is None else servo.servo_motor(motor), None if load is None else servo.servo_load(load)
