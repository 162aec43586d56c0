"""Inputs from the machine: user pins, switches, the external encoder, the shaft and its load.

`Inputs` is also the source of the axis's position (`ServoAxis`).
"""

from array import array
from collections.abc import Callable, Sequence
from functools import partial

from axistwin.controllers.smartmotor.kernel import physics as machine
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.core import SAMPLE_NS
from axistwin.controllers.smartmotor.kernel.trajectory import quadrature
from axistwin.controllers.smartmotor.processor import Processor
from axistwin.controllers.smartmotor.terminals import EncoderPin
from axistwin.core.units import S
from axistwin.plant.counts import Samples
from axistwin.plant.servo_axis import Source
from axistwin.sim.pins import Pin, UserPin

QUADRATURE = (0, 1, 3, 2)  # Pins A (1) and B (2) in the order in which they change when the encoder turns forwards.


class Inputs(Source):
    """Passes changes of the input signals to the simulated processor of a SmartMotor."""

    def __init__(self, motor: Processor) -> None:
        super().__init__(motor.axis)
        self.motor, self.axis = motor, motor.axis
        self._undo: list[Callable[[], object]] = []
        for bit, name in enumerate(s.USER_PINS):
            pin = motor.pins[name]
            self._undo.append(pin.subscribe(partial(self._level, bit)))
            self._undo.append(pin.volts_changes.subscribe(partial(self._volts, bit)))
            motor.i[s.PINS] |= pin.level << bit
            motor.i[s.ANALOG + bit] = pin.analog
        self._encoder_pins = [pin for pin in motor.pins.values() if isinstance(pin, EncoderPin)]
        for encoder_pin in self._encoder_pins:
            encoder_pin.levels, encoder_pin.on_wiring = self._levels, self._wiring
            self._undo.append(encoder_pin.unplug)
            motor.on_pin_use.subscribe(encoder_pin.refresh)
        master = self.axis.master
        self._undo.append(master.before_change.subscribe(self.catch_up))
        self._undo.append(master.on_change.subscribe(self._master))
        self._undo.append(master.on_replan.subscribe(motor.core.keep_read_only))
        self._undo.append(motor.core.on_replan.subscribe(self.axis.on_replan.emit))
        motor.core.on_samples.subscribe(self._publish)
        self.replan()
        self._master()
        motor.i[s.MASTER_SEEN] = motor.i[s.MASTER]

    def close(self) -> None:
        """Unsubscribe from all inputs, because the power is off."""
        for undo in self._undo:
            undo()

    def _level(self, bit: int, pin: Pin) -> None:
        self.catch_up()
        i = self.motor.i
        before = i[s.PINS] & 3
        i[s.PINS] = i[s.PINS] & ~(1 << bit) | pin.level << bit
        if bit <= 1:
            self._count(bit, before)

    def _volts(self, bit: int, pin: UserPin) -> None:
        self.catch_up()
        self.motor.i[s.ANALOG + bit] = pin.analog

    def _count(self, bit: int, before: int) -> None:
        i = self.motor.i
        if i[s.STEPS]:
            step = (1 if i[s.PINS] & 2 else -1) if bit == 0 and i[s.PINS] & 1 else 0
        else:
            step = {0: 0, 1: 1, 3: -1}[(QUADRATURE.index(i[s.PINS] & 3) - QUADRATURE.index(before)) % 4]
        i[s.PIN_EDGES] += step
        i[s.MASTER] += step
        i[s.MASTER_END] += step
        i[s.PREDICTED] = 0  # Discard the predicted encoder counts, because they do not include the new encoder edge.

    def _wiring(self) -> None:
        self.catch_up()
        i = self.motor.i
        i[s.SHOWN] = sum(1 << bit for bit, pin in enumerate(self._encoder_pins) if pin.shows_encoder)
        for bit, pin in enumerate(self._encoder_pins):
            i[s.PINS] = i[s.PINS] & ~(1 << bit) | pin.level << bit
            i[s.ANALOG + bit] = pin.analog

    def _levels(self, count: int) -> int:
        """Return the external encoder's levels; for a step source, B is the direction and A is low between steps."""
        i, master = self.motor.i, self.axis.master
        if i[s.STEPS]:
            return 2 * (master.run.counts > 0 if master.run.counts else i[s.STEP_UP])
        return quadrature(count)

    def _master(self) -> None:
        """Start a run of the external encoder, which the kernel computes from the next sample on.

        For the kernel the run begins one sample earlier: each sample then adds equal counts and carries the remainder.
        """
        i, core, run = self.motor.i, self.motor.core, self.axis.master.run
        self._wiring()
        i[s.MASTER], i[s.MASTER_LEFT], i[s.PREDICTED] = self.motor.edges(), 0, 0
        follows = self._follows()
        core.predict = self._predict if follows and self.axis.master.predictable else None
        core.read_ahead = self._ask if follows and core.predict is None else None
        first_ns = core.time_ns(i[s.SAMPLE] + 1)
        if follows or run.counts == 0 or run.end_ns <= self.motor.clock.now:
            return
        edges, i[s.MASTER_DIV] = abs(run.counts), run.duration_ns
        i[s.MASTER_WAY] = 1 if run.counts > 0 else -1
        i[s.MASTER_STEP], i[s.MASTER_ADD] = divmod(edges * SAMPLE_NS, run.duration_ns)
        counted, i[s.MASTER_REM] = divmod(edges * (first_ns - SAMPLE_NS - run.start_ns), run.duration_ns)
        i[s.MASTER] = run.base + i[s.MASTER_WAY] * counted + self.motor.i[s.PIN_EDGES]
        i[s.MASTER_END] = run.base + run.counts + self.motor.i[s.PIN_EDGES]
        i[s.MASTER_LEFT] = max(1, -((first_ns - run.end_ns) // SAMPLE_NS) + 1)

    def _follows(self) -> bool:
        followed = self.axis.master.followed
        return followed is not None and not followed.resting

    def _ask(self, times_ns: range) -> Sequence[int]:
        """Return the external encoder's edges now and at these times, as long as they are certain."""
        if not self._follows():
            self.motor.core.read_ahead = None
        return self.axis.master.read_ahead(times_ns, self.motor.i[s.PIN_EDGES])

    def _predict(self, first: int, samples: int) -> Sequence[int]:
        """Return the external encoder's edges in these samples, as long as its axis continues unchanged."""
        core = self.motor.core
        if not self._follows():
            core.predict = None
        counts = self.axis.master.predict(core.time_ns(first), SAMPLE_NS, samples)
        return [count + self.motor.i[s.PIN_EDGES] for count in counts]

    def refresh(self) -> None:
        """Update the simulated motor to the present time, so that other code can read e.g. the position."""
        self.motor.core.catch_up(changing=False)

    def catch_up(self) -> None:
        """Advance the state of the motor to the present time."""
        self.motor.catch_up()

    def position(self) -> int:
        """Return the shaft's position in encoder counts.  The commands O= and F=2 do not affect this position."""
        return self.motor.core.position_now()

    def commanded(self) -> int:
        """Return the commanded position in counts, in the coordinates that the commands O= and F=2 define."""
        self.refresh()
        return self.motor.i[s.COMMANDED] >> 16

    def positions_ahead(self, times_ns: range) -> list[int]:
        """Return the shaft's positions now and at these times, as long as they are certain."""
        return self.motor.core.positions_ahead(times_ns)

    def setpoint(self) -> int:
        """Return the commanded position in counts, in the machine's coordinates."""
        return self.motor.core.commanded_now()

    def velocity(self) -> float:
        """Return the shaft's speed in counts per second."""
        return self.motor.core.speed() * S / SAMPLE_NS

    def moving(self) -> bool:
        """True if the shaft turns or a trajectory is in progress."""
        return bool(self.motor.i[s.BT]) or self.velocity() != 0

    def next_sample_ns(self) -> int | None:
        """Return the time of the next sample, or None if nothing changes."""
        core = self.motor.core
        return core.time_ns(core.due + 1) if core.moving else None

    def temperature(self) -> float:
        """Return the motor's temperature in °C."""
        self.refresh()
        return self.motor.f[machine.HOUSING_C]

    def energy_nj(self) -> int:
        """Return the electrical energy in nJ supplied to the motor's windings since the start of the simulation."""
        self.refresh()
        return self.motor.i[s.ENERGY]

    def push(self, counts: int) -> None:
        """Turn the shaft by `counts`, as when a person turns the shaft by hand."""
        machine.push(self.motor.i, counts)

    def slip(self, counts: int) -> None:
        """Shift the encoder relative to the motor shaft, by a number of counts."""
        machine.slip(self.motor.i, counts)

    def replan(self) -> None:
        """Update the physical model with the axis's present load, defects and ambient temperature."""
        motor, axis = self.motor, self.axis
        machine.set_torque(motor.f, axis.outside_torque)
        machine.set_jam(motor.f, axis.jammed)
        machine.set_ambient(motor.i, motor.f, axis.ambient)
        machine.set_encoder(motor.i, axis.counts_of, axis.counts_out_of)
        if axis.motor is not None:
            machine.set_windings(motor.i, motor.f, axis.motor, axis.strength, axis.supply)
        motor.i[s.WINDOW_LOW], motor.i[s.WINDOW_HIGH] = axis.window_low, axis.window_high

    def switches(self) -> None:
        """Handle a switch that the shaft has reached."""
        self.axis.left_window()
        self.motor.i[s.WINDOW_LOW], self.motor.i[s.WINDOW_HIGH] = self.axis.window_low, self.axis.window_high

    def _publish(self, first: int, shaft: "array[int]", commanded: "array[int]") -> None:
        self.axis.publish(Samples(self.motor.core.time_ns(first), SAMPLE_NS, shaft, commanded))
