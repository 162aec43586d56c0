"""The axis of a servo motor: a shaft with an encoder, which is there whether the motor has power or not.

Where the shaft is now is calculated by a *source*: the motor's processor with the physics, sample by sample and ahead
of the clock, so that nobody may look at or change anything without asking it.  What is the machine's own and stays
when the power goes (the physics, torques from outside, the temperature around it, switches) is kept here.
"""

from collections.abc import Callable, Mapping, MutableSequence, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, Protocol

from axistwin.errors import UsageError
from axistwin.motion.train import HISTORY
from axistwin.plant.counts import SAMPLES, CountHistory, Listener, Samples
from axistwin.plant.layers import Layers
from axistwin.plant.master import Followed, Master
from axistwin.sim.by_hand import ByHand, check_counts, check_torque
from axistwin.sim.clock import Clock

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from axistwin.plant.servo import ServoLoad, ServoMotor

FAR = 1 << 62
"""Further than any shaft can turn."""
AMBIENT = 25.0
"""Degrees Celsius around the motor, unless somebody says otherwise."""
COLDEST, HOTTEST = -40.0, 150.0
IDEAL_COUNTS_PER_REV = 2000
"""Encoder counts for a turn of a shaft without a data sheet."""


class Source(Protocol):
    """Who knows what the shaft does.  All values are those of the last sample by now."""

    def look(self) -> None:
        """`publish` what has become definitive by now.  Nothing is going to be changed, nor what is planned."""

    def catch_up(self) -> None:
        """The same, as something is about to be changed."""

    def replan(self) -> None:
        """The axis's load, jam or ambient temperature has changed, now; what was calculated ahead is void."""

    def position(self) -> int:
        """Encoder counts from 0 when the bench was made, in the machine's own direction."""

    def commanded(self) -> int:
        """Where the controller's own trajectory stands, in its own coordinates, in counts."""

    def setpoint(self) -> int:
        """Where the trajectory would have the shaft, in counts, in the machine's own direction."""

    def velocity(self) -> float:
        """Of the shaft, in counts per second, in the machine's own direction."""

    def moving(self) -> bool:
        """Whether the shaft turns or a trajectory is in progress."""

    def next_sample_ns(self) -> int | None:
        """When the shaft may be found somewhere else; None: not by itself."""

    def temperature(self) -> float:
        """Of the motor, in degrees Celsius."""

    def push(self, counts: int) -> None:
        """The shaft is displaced by so many counts, now."""

    def slip(self, counts: int) -> None:
        """The encoder turns on its shaft by so many counts, now."""


class AtRest:
    """A shaft that nothing turns: the source until there is another."""

    def __init__(self, axis: "ServoAxis") -> None:
        self._axis = axis

    def look(self) -> None:
        """Nothing happens by itself."""

    def catch_up(self) -> None:
        """Nothing happens by itself."""

    def replan(self) -> None:
        """Nothing to calculate."""

    def position(self) -> int:
        """Where it was left."""
        return self._axis.shaft

    def commanded(self) -> int:
        """Nobody commands it."""
        return 0

    def setpoint(self) -> int:
        """Where it is, as nobody commands it."""
        return self._axis.shaft

    def velocity(self) -> float:
        """None."""
        return 0.0

    def moving(self) -> bool:
        """No."""
        return False

    def next_sample_ns(self) -> int | None:
        """Never."""
        return None

    def temperature(self) -> float:
        """That of the air."""
        return self._axis.ambient

    def push(self, counts: int) -> None:
        """It stays there."""
        axis = self._axis
        axis.shaft += counts
        axis.publish(Samples(axis.clock.now, 0, (axis.shaft,), (0,)))

    def slip(self, counts: int) -> None:
        """Nobody counts."""


class EncoderView:
    """The encoder of a servo axis as a person at the bench has it."""

    def __init__(self, axis: "ServoAxis") -> None:
        self._axis = axis

    @property
    def count(self) -> int:
        """Counts after quadrature, from 0 when the bench is made."""
        return self._axis.position

    def displace(self, counts: int) -> None:
        """Somebody turns the shaft by so many counts; it stays there until the motor moves it back."""
        check_counts(counts, "displace")
        self._axis.push(counts)

    def miscount(self, of: int, out_of: int) -> None:
        """From now on it counts `of` for each `out_of` counts; 1 of 1: as it should."""
        self._axis.miscount(of, out_of)

    def slip(self, counts: int) -> None:
        """It turns on its shaft by so many counts, and nothing else moves."""
        self._axis.slip(counts)


class ServoAxis:
    """Motor, load and encoder of a SmartMotor.  Without a `motor` it is ideal: the shaft does what is commanded."""

    def __init__(
        self,
        clock: Clock,
        name: str,
        *,
        motor: "ServoMotor | None" = None,
        load: "ServoLoad | None" = None,
        limits: tuple[int, int] | None = None,
        history: int = HISTORY,
    ) -> None:
        self.clock, self.name = clock, name
        self.limits = limits
        """The first and the last position within the limit switches; None: there are none."""
        self.motor, self.load_data = motor, load
        self.f: MutableSequence[float] = []
        """The state of the physics, which belongs to the machine; whoever calculates it fills it."""
        self.shaft = 0
        """The position while there is no source but rest."""
        self.counts_of, self.counts_out_of = 1, 1
        """So many counts the encoder makes for so many: 9 of 10, -1 of 1, 0 of 1."""
        self._outside = Layers(0.0, self._replan, self._catch_up)
        self._jams = Layers(False, self._replan, self._catch_up)
        self._torque = Layers(1.0, self._replan, self._catch_up)
        self._supply = Layers(1.0, self._supply_changed, self._catch_up)
        self.on_supply: list[Callable[[], None]] = []
        """Called when the supply voltage has changed."""
        self._ambient = Layers(AMBIENT, self._replan, self._catch_up)
        self.by_hand = ByHand(clock)
        """Reports what a person does to it: `load`, `jam`, `push`, `ambient`."""
        self.master = Master(clock, self)
        """What is wired to pins A and B."""
        self.encoder = EncoderView(self)
        self.on_motion: list[Callable[[], None]] = []
        """Of those who sit on this shaft; they look at it sample by sample, so that nothing is told here."""
        self.window_low, self.window_high = -FAR, FAR
        """Positions, both included, between which no switch changes; see `left_window`."""
        self._edges: list[int] = []
        self._looks: list[Callable[[], None]] = []
        self._listeners: list[Listener] = []
        self._history_option = history
        self._counts = CountHistory(history * SAMPLES)
        self._source: Source = AtRest(self)

    # What the motor's processor does

    def connect(self, source: Source) -> None:
        """From now on this one knows what the shaft does; it goes on from `shaft` and `f`."""
        self._source = source

    def disconnect(self) -> None:
        """Nobody calculates any more: the shaft rests where it is."""
        self.shaft = self._source.position()
        self._source = AtRest(self)

    def publish(self, samples: Samples) -> None:
        """Tell those who listen what has been, for good: in order, and nothing that lies ahead of the clock.

        Between what is published the position stays as it was, so that long rests need not be told.
        """
        self._counts.add(samples)
        for listener in tuple(self._listeners):
            listener(samples)

    def left_window(self) -> None:
        """The shaft has, in the sample that is now, left the window: the switches look, and there is another window."""
        self._find_window()
        for look in tuple(self._looks):
            look()

    # What a person sees and does

    @property
    def position(self) -> int:
        """Where the shaft stands, in encoder counts from 0 when the bench is made, whatever the motor calls it."""
        return self._source.position()

    @property
    def commanded(self) -> int:
        """Where the motor's own trajectory stands, in the motor's coordinates (`O=` shifts them, F=2 turns them)."""
        return self._source.commanded()

    @property
    def setpoint(self) -> int:
        """Where the trajectory would have the shaft, in the coordinates of `position`; with the servo off, where it is.

        `setpoint - position` is the following error.
        """
        return self._source.setpoint()

    @property
    def per_rev(self) -> int:
        """Encoder counts for a turn of the shaft."""
        return IDEAL_COUNTS_PER_REV if self.motor is None else self.motor.counts_per_rev

    @property
    def velocity(self) -> float:
        """Counts per second, negative in the negative direction."""
        return self._source.velocity()

    @property
    def moving(self) -> bool:
        """Whether the shaft turns or a trajectory is in progress."""
        return self._source.moving()

    @property
    def resting(self) -> bool:
        """Whether it stays where it is until somebody tells; a shaft can be turned by hand at any time."""
        return False

    @property
    def foreseen(self) -> bool:
        """Its course is that of its own samples, which nobody knows in advance."""
        return False

    @property
    def follows(self) -> Followed | None:
        """The axis that its master sits on."""
        return self.master.followed

    def positions_at(self, times_ns: Sequence[int]) -> list[int]:
        """Nobody can tell."""
        raise AssertionError(f"the course of a servo is not foreseen, not at {times_ns}")

    def next_sample_ns(self) -> int | None:
        """When the shaft may be found somewhere else; None: not by itself."""
        return self._source.next_sample_ns()

    @property
    def temperature(self) -> float:
        """Of the motor, in degrees Celsius."""
        return self._source.temperature()

    @property
    def ambient(self) -> float:
        """Around the motor, in degrees Celsius; of what is set and what defects bring, the latest defect counts."""
        return self._ambient.values[-1]

    @ambient.setter
    def ambient(self, celsius: float) -> None:
        if not COLDEST <= celsius <= HOTTEST:
            raise UsageError(f"ambient={celsius!r}: give a temperature from {COLDEST:g} to {HOTTEST:g} °C")
        self.by_hand.tell("ambient", celsius)
        self._ambient.set(float(celsius))

    def heat(self, celsius: float) -> Callable[[], None]:
        """A defect makes it so hot, or cold, around the motor.  Returns what ends it."""
        return self._ambient.add(celsius)

    @property
    def outside_torque(self) -> float:
        """The torque on the shaft from outside, in N·m."""
        return sum(self._outside.values)

    @property
    def jammed(self) -> bool:
        """Whether the shaft cannot turn."""
        return any(self._jams.values)

    def load(self, newton_metres: float) -> None:
        """A torque on the shaft from outside; positive turns it in the positive direction."""
        check_torque(newton_metres)
        self.by_hand.tell("load", newton_metres)
        self._outside.set(float(newton_metres))

    def burden(self, newton_metres: float) -> Callable[[], None]:
        """A defect brings one more torque from outside.  Returns what ends it."""
        return self._outside.add(newton_metres)

    def jam(self, on: bool = True) -> None:
        """A shaft that cannot turn, while the trajectory goes on."""
        self.by_hand.tell("jam", bool(on))
        self._jams.set(bool(on))

    def seize(self) -> Callable[[], None]:
        """A defect keeps the shaft from turning, whoever else does.  Returns what ends it."""
        return self._jams.add(True)

    @property
    def strength(self) -> float:
        """What is left of the motor's torque, 0 to 1."""
        return min(self._torque.values)

    def weaken(self, left: float) -> Callable[[], None]:
        """So much is left of the motor's torque, 0 to 1.  Returns what ends it."""
        return self._torque.add(left)

    @property
    def supply(self) -> float:
        """What is left of the supply voltage, 0 to 1."""
        return min(self._supply.values)

    def sag(self, left: float) -> Callable[[], None]:
        """So much is left of the supply voltage, 0 to 1.  Returns what ends it."""
        return self._supply.add(left)

    def _catch_up(self) -> None:
        self._source.catch_up()

    def _replan(self) -> None:
        self._source.replan()

    @property
    def supply_v(self) -> float:
        """The supply voltage in V; of an ideal motor, which has no data sheet, without end."""
        return inf if self.motor is None else self.supply * self.motor.supply_voltage_v

    def _supply_changed(self) -> None:
        self._replan()
        for action in tuple(self.on_supply):
            action()

    def miscount(self, of: int, out_of: int) -> None:
        """From now on the encoder counts `of` for each `out_of` counts.  The motor believes it."""
        self._source.catch_up()
        self.counts_of, self.counts_out_of = of, out_of
        self._source.replan()

    def slip(self, counts: int) -> None:
        """The encoder turns on its shaft by so many counts.  The motor believes it."""
        self._source.catch_up()
        self._source.slip(counts)
        self._source.replan()

    def push(self, counts: int) -> None:
        """Somebody turns the shaft by so many counts."""
        self.by_hand.tell("push", counts)
        self._source.catch_up()
        self._source.push(counts)
        self.left_window()

    def pulse_times(self, start_ns: int = 0, stop_ns: int | None = None) -> "NDArray[np.int64]":
        """When the encoder count changed, from `start_ns` to before `stop_ns` (None: up to now), in nanoseconds.

        The count is known at samples; changes within one are spread evenly from the sample before it to its end.
        """
        self.catch_up()
        stop_ns = self.clock.now + 1 if stop_ns is None else stop_ns
        return self._counts.times(start_ns, stop_ns, 2 * self._history_option)

    def watch(self, listener: Listener) -> Callable[[], None]:
        """Call `listener(samples)` with what has been, in order of time.  Returns what ends the watching.

        It is told when the motor has got so far; `catch_up` makes it now.
        """
        self.catch_up()
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def catch_up(self) -> None:
        """Have everything published that has been by now; it disturbs nothing."""
        self._source.look()

    @property
    def forgotten(self) -> bool:
        """Whether some of its past is no longer remembered."""
        return self._counts.forgotten_ns is not None

    # Switches

    def watch_edges(self, edges: Sequence[int], look: Callable[[], None]) -> Callable[[], None]:
        """Call `look()` when the shaft has crossed one of these; edge n lies between position n-1 and n.

        Returns what ends it.
        """
        self._source.catch_up()
        self._edges += edges
        self._looks.append(look)
        self._find_window()
        self._source.replan()

        def end() -> None:
            for edge in edges:
                self._edges.remove(edge)
            self._looks.remove(look)

        return end

    def _find_window(self) -> None:
        position = self.position
        self.window_low = max((edge for edge in self._edges if edge <= position), default=-FAR)
        self.window_high = min((edge - 1 for edge in self._edges if edge > position), default=FAR)


def data_sheets(given: Mapping[str, Any]) -> "tuple[ServoMotor | None, ServoLoad | None]":
    """The options `motor` (a data sheet's name, or its values) and `load` as data; without a motor it is ideal.

    Raises UsageError.
    """
    motor, load = given.get("motor"), given.get("load")
    if motor is None and load is None:
        return None, None
    from axistwin.plant import servo  # late: an ideal axis needs none of it

    return None if motor is None else servo.servo_motor(motor), None if load is None else servo.servo_load(load)
