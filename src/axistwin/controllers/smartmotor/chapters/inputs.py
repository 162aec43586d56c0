"""What reaches the motor from its machine: user pins, switches, the external encoder, the shaft and its load.

It is also what the axis asks where the shaft is (`ServoAxis`'s source).
"""

from array import array
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from axistwin.controllers.smartmotor.kernel import machine
from axistwin.controllers.smartmotor.kernel.core import SAMPLE_NS
from axistwin.controllers.smartmotor.kernel.state import (
    ANALOG,
    BT,
    BY_HAND,
    COMMANDED,
    MASTER,
    MASTER_ADD,
    MASTER_DIV,
    MASTER_END,
    MASTER_LEFT,
    MASTER_REM,
    MASTER_SEEN,
    MASTER_STEP,
    MASTER_WAY,
    PINS,
    SAMPLE,
    SHOWN,
    STEP_UP,
    STEPS,
    TOLD,
    USER_PINS,
    WINDOW_HIGH,
    WINDOW_LOW,
)
from axistwin.controllers.smartmotor.kernel.trajectory import quadrature
from axistwin.plant.counts import Samples
from axistwin.plant.master import Master
from axistwin.sim.clock import Clock
from axistwin.sim.pins import PULLED_UP_VOLTS, Pin, UserPin
from axistwin.units import S

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

QUADRATURE = (0, 1, 3, 2)
"""Pins A (1) and B (2) in the order in which they change when the encoder turns forwards."""


class EncoderPin(UserPin):
    """Pin A or B: it shows the edges of the external encoder, unless something stronger gives it its level.

    With an encoder its level is looked up; those who watch the pin are not told of each edge.
    """

    def __init__(self, clock: Clock, name: str, master: Master) -> None:
        super().__init__(clock, name)
        self._bit, self._master = USER_PINS.index(name), master
        self.levels: Callable[[], int] = lambda: quadrature(master.count)
        """Returns the levels that the external encoder gives pins A (1) and B (2) now."""
        self.on_wiring: Callable[[], None] = lambda: None
        """Called when something begins to give the pin its level, or ceases to."""

    @property
    def shows_encoder(self) -> bool:
        """True if the level is the external encoder's."""
        free = not self._holds and self._lead is None and self._stage is None and self._wired is None
        return free and self._master.plugged

    @property
    def restless(self) -> bool:  # type: ignore[override]  # it depends on what is wired to the pin
        """True if the level is looked up."""
        return self.shows_encoder

    @property
    def level(self) -> bool:
        """The level at the terminal."""
        return bool(self.levels() >> self._bit & 1) if self.shows_encoder else super().level

    @property
    def volts(self) -> float:
        """The voltage at the terminal: 5 V or 0 V from an encoder."""
        return PULLED_UP_VOLTS * self.level if self.shows_encoder else super().volts

    def unplug(self) -> None:
        """Forget the motor, whose power is gone; the encoder stays where it is."""
        self.levels, self.on_wiring = (lambda: quadrature(self._master.count)), lambda: None

    def _find_volts(self, level: bool, before: float) -> None:
        super()._find_volts(level, before)
        self.on_wiring()


class IndexLine(Pin):
    """The encoder's index mark, high while the shaft stands on it.  It is looked up, unless somebody watches it."""

    restless = True

    def __init__(self, clock: Clock) -> None:
        super().__init__(clock, "index")
        self.motor: Motor | None = None
        self.watched = False

    @property
    def level(self) -> bool:
        """Whether the shaft stands on the mark; a test lead has the last word."""
        return super().level if self.driven or self._holds or self.motor is None else self.motor.at_index

    def drive(self, level: bool) -> None:
        """Force the line; a rising edge captures the position as the mark does."""
        before = self.level
        super().drive(level)
        if self.motor is not None:
            self.motor.force_index(bool(level), rising=bool(level) and not before)

    def release(self) -> None:
        """Take the test lead away."""
        super().release()
        if self.motor is not None:
            self.motor.force_index(False, rising=False)

    def subscribe(self, watcher: Callable[[Pin], None]) -> Callable[[], None]:
        """Call `watcher(pin)` at every change."""
        self.watched = True
        if self.motor is not None:
            self.motor.watch_index()
        return super().subscribe(watcher)

    def show(self) -> None:
        """The shaft has come to the mark, or has left it."""
        if not self.driven:
            self._announce()


class Inputs:
    """Keeps the motor's numbers for its inputs true."""

    def __init__(self, motor: "Motor") -> None:
        self.motor, self.axis = motor, motor.axis
        self._undo: list[Callable[[], object]] = []
        for bit, name in enumerate(USER_PINS):
            pin = motor.pins[name]
            self._undo.append(pin.subscribe(partial(self._level, bit)))
            self._undo.append(pin.subscribe_volts(partial(self._volts, bit)))
            motor.i[PINS] |= pin.level << bit
            motor.i[ANALOG + bit] = pin.analog
        self._encoder_pins = [pin for pin in motor.pins.values() if isinstance(pin, EncoderPin)]
        for encoder_pin in self._encoder_pins:
            encoder_pin.levels, encoder_pin.on_wiring = self._levels, self._wiring
            self._undo.append(encoder_pin.unplug)
        master = self.axis.master
        self._undo.append(master.before_change.subscribe(self.catch_up))
        self._undo.append(master.on_change.subscribe(self._master))
        motor.core.listeners.append(self._publish)
        self._by_hand = 0
        """Edges that have come through the pins themselves."""
        self._take_axis()
        self._master()
        motor.i[MASTER_SEEN] = motor.i[MASTER]

    def close(self) -> None:
        """The power is gone."""
        for undo in self._undo:
            undo()

    # Pins

    def _level(self, bit: int, pin: Pin) -> None:
        self.catch_up()
        i = self.motor.i
        before = i[PINS] & 3
        i[PINS] = i[PINS] & ~(1 << bit) | pin.level << bit
        if bit <= 1:
            self._count(bit, before)

    def _volts(self, bit: int, pin: UserPin) -> None:
        self.catch_up()
        self.motor.i[ANALOG + bit] = pin.analog

    def _count(self, bit: int, before: int) -> None:
        """An edge on pin A or B: a quarter of an encoder's period, or a step on A in the direction of B."""
        i = self.motor.i
        if i[STEPS]:
            step = (1 if i[PINS] & 2 else -1) if bit == 0 and i[PINS] & 1 else 0
        else:
            step = {0: 0, 1: 1, 3: -1}[(QUADRATURE.index(i[PINS] & 3) - QUADRATURE.index(before)) % 4]
        self._by_hand += step
        i[BY_HAND] = self._by_hand
        i[MASTER] += step
        i[MASTER_END] += step
        i[TOLD] = 0  # that is to be told anew

    def _wiring(self) -> None:
        """Pin A or B shows the external encoder from now on, or does no longer."""
        self.catch_up()
        i = self.motor.i
        i[SHOWN] = sum(1 << bit for bit, pin in enumerate(self._encoder_pins) if pin.shows_encoder)
        for bit, pin in enumerate(self._encoder_pins):
            i[PINS] = i[PINS] & ~(1 << bit) | pin.level << bit
            i[ANALOG + bit] = pin.analog

    def _levels(self) -> int:
        """The external encoder's levels now; of a step source B is the direction, and A low between steps."""
        i, master = self.motor.i, self.axis.master
        if i[STEPS]:
            return 2 * (master.run.counts > 0 if master.run.counts else i[STEP_UP])
        return quadrature(master.count)

    # External encoder

    def edges(self) -> int:
        """Edges on pins A and B so far, exactly now."""
        return self.axis.master.count + self._by_hand

    def _master(self) -> None:
        """The external encoder begins another run: the kernel counts along from the next sample on.

        It is given the run as it was one sample before that, so that each sample adds the same and carries the rest.
        """
        i, core, run = self.motor.i, self.motor.core, self.axis.master.run
        self._wiring()
        i[MASTER], i[MASTER_LEFT], i[TOLD] = self.edges(), 0, 0
        follows = self._follows()
        core.foretell = self._foretell if follows and self.axis.master.predictable else None
        core.one_by_one = self._ask if follows and core.foretell is None else None
        first_ns = core.time_ns(i[SAMPLE] + 1)
        if follows or run.counts == 0 or run.end_ns <= self.motor.clock.now:
            return
        edges, i[MASTER_DIV] = abs(run.counts), run.duration_ns
        i[MASTER_WAY] = 1 if run.counts > 0 else -1
        i[MASTER_STEP], i[MASTER_ADD] = divmod(edges * SAMPLE_NS, run.duration_ns)
        counted, i[MASTER_REM] = divmod(edges * (first_ns - SAMPLE_NS - run.start_ns), run.duration_ns)
        i[MASTER] = run.base + i[MASTER_WAY] * counted + self._by_hand
        i[MASTER_END] = run.base + run.counts + self._by_hand
        i[MASTER_LEFT] = max(1, -((first_ns - run.end_ns) // SAMPLE_NS) + 1)

    def _follows(self) -> bool:
        """Whether the external encoder sits on an axis that moves."""
        followed = self.axis.master.followed
        return followed is not None and not followed.resting

    def _ask(self) -> None:
        """The external encoder sits on an axis that cannot be told in advance: ask it before each sample."""
        self.motor.i[MASTER] = self.edges()
        if not self._follows():
            self.motor.core.one_by_one = None

    def _foretell(self, first: int, samples: int) -> Sequence[int]:
        """The edges in these samples, as long as the axis that it sits on takes no other course."""
        core = self.motor.core
        if not self._follows():
            core.foretell = None
        counts = self.axis.master.predict(core.time_ns(first), SAMPLE_NS, samples)
        return [count + self._by_hand for count in counts]

    # The axis's source

    def look(self) -> None:
        """Publish what has been by now; nothing is changed."""
        self.motor.core.catch_up(changing=False)

    def catch_up(self) -> None:
        """Bring the state to now."""
        self.motor.catch_up()

    def replan(self) -> None:
        """Load, jam or ambient temperature have changed."""
        self._take_axis()

    def position(self) -> int:
        """Encoder counts, in the machine's own direction."""
        return self.motor.core.look()

    def commanded(self) -> int:
        """The trajectory's counts, in the controller's coordinates."""
        self.look()
        return self.motor.i[COMMANDED] >> 16

    def setpoint(self) -> int:
        """The trajectory's counts, in the machine's coordinates.  Nothing is disturbed that has been computed."""
        return self.motor.core.look_commanded()

    def velocity(self) -> float:
        """Counts per second."""
        return self.motor.core.speed() * S / SAMPLE_NS

    def moving(self) -> bool:
        """Whether the shaft turns or a trajectory is in progress.  Bt holds for a block, which a change of it ends."""
        return bool(self.motor.i[BT]) or self.velocity() != 0

    def next_sample_ns(self) -> int | None:
        """When the next sample is done, while something changes."""
        core = self.motor.core
        return core.time_ns(core.due + 1) if core.moving else None

    def temperature(self) -> float:
        """Of the motor, °C."""
        self.look()
        return self.motor.f[machine.HOUSING_C]

    def push(self, counts: int) -> None:
        """Somebody turns the shaft."""
        machine.push(self.motor.i, counts)

    def slip(self, counts: int) -> None:
        """The encoder turns on its shaft."""
        machine.slip(self.motor.i, counts)

    def _take_axis(self) -> None:
        motor, axis = self.motor, self.axis
        machine.set_torque(motor.f, axis.outside_torque)
        machine.set_jam(motor.f, axis.jammed)
        machine.set_ambient(motor.i, motor.f, axis.ambient)
        machine.set_encoder(motor.i, axis.counts_of, axis.counts_out_of)
        if axis.motor is not None:
            machine.set_windings(motor.i, motor.f, axis.motor, axis.strength, axis.supply)
        motor.i[WINDOW_LOW], motor.i[WINDOW_HIGH] = axis.window_low, axis.window_high

    def switches(self) -> None:
        """The shaft has reached a switch."""
        self.axis.left_window()
        self.motor.i[WINDOW_LOW], self.motor.i[WINDOW_HIGH] = self.axis.window_low, self.axis.window_high

    def _publish(self, first: int, shaft: "array[int]", commanded: "array[int]") -> None:
        self.axis.publish(Samples(self.motor.core.time_ns(first), SAMPLE_NS, shaft, commanded))
