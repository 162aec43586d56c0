"""An axis with a stepper motor: pulses in, position out.

A controller uses an axis through `start`, `replace`, `halt`, `encoder_count` and `on_push`; all other properties are
the machine's own state.
"""

from collections.abc import Callable, Sequence
from contextlib import ExitStack

from axistwin.core.errors import UsageError, installed
from axistwin.core.lazy import NDArray, np
from axistwin.plant.encoder import Encoder, EncoderData
from axistwin.plant.overrides import Shaft
from axistwin.plant.torque import Load, Slip, StepperMotor, lost_pulses, slips, whole_teeth
from axistwin.sim.clock import Clock
from axistwin.sim.manual_actions import ManualAct, check_counts
from axistwin.sim.motion.profile import Profile
from axistwin.sim.motion.train import HISTORY, Train
from axistwin.sim.pins import SensedPin
from axistwin.sim.signal import Signal


class EncoderView:
    """The user's interface to the encoder of a stepper axis: encoder count, and simulated encoder faults."""

    def __init__(self, axis: "StepperAxis", encoder: Encoder) -> None:
        self._axis, self._encoder = axis, encoder
        self.data = encoder.data  # Resolution, backlash and index mark.

    @property
    def count(self) -> int:
        return self._encoder.follow(self._axis.position)

    def displace(self, counts: int) -> None:
        """Move the load by `counts` without the motor; it stays there until the motor moves it back."""
        check_counts(counts, "displace")
        self._axis.manual_actions.report(ManualAct.PUSH, counts)
        self._encoder.displace(counts)
        self._axis.on_push.emit()

    @property
    def counts_per_pulses(self) -> tuple[int, int, int]:
        """Encoder ratio with tolerance, e.g. (4000, 400, 3): 400 motor pulses cause 4000 ± 3 encoder counts."""
        return self._encoder.counts_per_pulses

    @property
    def at_index(self) -> bool:
        _ = self.count
        return self._encoder.at_index

    def subscribe_index(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` whenever the level of channel Z may have changed.  Return an unsubscribe function."""

        def edges() -> Sequence[int]:
            _ = self.count
            return self._encoder.index_edges()

        edge_subscription = _EdgeSubscription(self._axis, edges, callback)
        stack = ExitStack()
        stack.callback(edge_subscription.end)
        stack.callback(self._axis.on_push.subscribe(edge_subscription.update))
        return stack.close

    def begin(self) -> None:
        _ = self.count
        self._encoder.begin()

    def counted(self, since: int) -> bool:
        """True if the count has changed since the motor was at position `since` in the present move."""
        return self.count != self._encoder.count_at(since)

    @property
    def direction(self) -> int:
        _ = self.count
        return self._encoder.direction

    def miscount(self, of: int, out_of: int) -> None:
        """Let the encoder show `of` counts for each `out_of` true ones; 1 for 1 is correct."""
        _ = self.count  # Update the encoder count before the fault begins.
        self._encoder.miscount(of, out_of)
        self._axis.on_push.emit()

    def slip(self, counts: int) -> None:
        _ = self.count
        self._encoder.slip(counts)
        self._axis.on_push.emit()


class StepperAxis(Shaft):
    """A stepper motor with load and encoder; without a `motor` it is ideal and never stalls."""

    unit = "pulses"  # Unit of positions; "counts" for a motor that is driven by the counts of its encoder.

    def __init__(
        self, clock: Clock, name: str, *, motor: StepperMotor | None = None, load: Load | None = None,
        encoder: EncoderData | None = None, limits: tuple[int, int] | None = None, home: tuple[int, int] | None = None,
        history: int = HISTORY,
    ) -> None:  # fmt: skip
        super().__init__(clock, name, limits, self._replan)
        self.train, self.home = Train(history), home  # `home`: first and last position of the home switch, or None.
        self.on_push: Signal[[]] = Signal()
        self.motor, self._load = motor, load or Load()  # `motor`: the data sheet; None for an ideal motor.
        self._encoder = EncoderView(self, Encoder(encoder)) if encoder else None
        self._slips: list[Slip] = []
        # Steps lost in finished moves; a lost step in the negative direction counts as -1.
        self._lost = 0
        # Step pulses that the method `hold` suppressed in the past; a pulse in the negative direction counts as -1.
        self._unmade = 0
        # Pulse count at which the method `hold` stopped the step output; None if the output is not held.
        self._made: int | None = None
        self._was_held = False

    # Interface to the controller

    def start(self, profile: Profile, direction: int) -> None:
        """Begin a new move with the velocity profile `profile`; `direction` is +1 or -1."""
        if self._made is None:
            self._lost += self.train.move.direction * self._lost_in_move(over=True)
        self._fall_in()
        if self._encoder:
            self._encoder.begin()
        self.train.start(self.clock.now, direction, profile)
        self._slips = self._find_slips(0, out_of_step=False)
        self.on_motion.emit()

    def replace(self, profile: Profile) -> None:
        """Replace the velocity profile of the present move.  `profile` begins at the start of the move."""
        self.train.replace(profile)
        if self._loses_no_steps:
            self.on_motion.emit()
        else:
            self._replan()

    def halt(self) -> None:
        """Stop the pulses at once."""
        self.replace(self.train.move.profile.cut_whole(self.clock.now - self.train.move.start_ns))

    @property
    def encoder_count(self) -> int | None:
        return self._encoder.count if self._encoder else None

    def counts_per_pulses(self) -> tuple[int, int, int] | None:
        """Return counts, motor pulses and largest deviation in counts; None while losing steps or with held output."""
        if not self.predictable:
            return None
        return self._encoder.counts_per_pulses if self._encoder else (0, 1, 0)

    def wire_index(self, pin: SensedPin) -> None:
        """Connect the encoder's channel Z to a terminal, if there is an encoder."""
        if (encoder := self._encoder) is not None:
            pin.sense(lambda: encoder.at_index, encoder.subscribe_index)

    def encoder_counted(self, within_ns: int) -> bool:
        """True if the count has changed in the last `within_ns` ns, and in the present move."""
        if self._encoder is None:
            return False
        move = self.train.move
        done = move.profile.pulses_by(max(0, self.clock.now - within_ns - move.start_ns))
        behind = lost_pulses(self._slips, done, False, self._per_tooth)
        return self._encoder.counted(move.origin - self._lost - self._unmade + move.direction * (done - behind))

    @property
    def encoder_direction(self) -> int:
        return self._encoder.direction if self._encoder else +1

    @property
    def moving(self) -> bool:
        """True while pulses of the present move remain."""
        return self.train.moving(self.clock.now)

    @property
    def resting(self) -> bool:
        return not self.moving

    @property
    def predictable(self) -> bool:
        """True if positions are predictable up to the next move; lost steps make positions unpredictable."""
        return not self._slips and self._made is None

    @property
    def free(self) -> bool:
        """True if the motor cannot lose steps and `on_motion` has no subscribers: then velocities can be planned."""
        return self._loses_no_steps and not self.on_motion

    @property
    def follows(self) -> None:
        """The axis that this axis follows.  Always None for a stepper axis."""
        return

    def positions_ahead(self, _times_ns: range) -> list[int]:
        return [self.position]

    def positions_at(self, times_ns: Sequence[int]) -> list[int]:
        """Return the motor's positions at these times in the latest move, in order; valid while no steps are lost."""
        move = self.train.move
        profile, at_start = move.profile, move.origin - self._lost - self._unmade
        if not installed("numpy"):
            past_ns = (max(time_ns - move.start_ns, 0) for time_ns in times_ns)
            return [at_start + move.direction * profile.pulses_by(passed) for passed in past_ns]
        since_ns = np.maximum(np.asarray(times_ns, np.int64) - move.start_ns, 0)
        first, last = profile.pulses_by(int(since_ns[0])), profile.pulses_by(int(since_ns[-1]))
        pulses_ns = np.empty(last - first, np.int64)
        profile.fill_pulse_times(first + 1, 0, pulses_ns)
        done = first + np.searchsorted(pulses_ns, since_ns, side="right")
        found: list[int] = (at_start + move.direction * done).tolist()
        return found

    # Functions that read the axis state or simulate a manual action, e.g. blocking the shaft

    @property
    def position(self) -> int:
        """Position of the motor in pulses, initially 0."""
        lost = 0 if self._made is not None else self.train.move.direction * self._lost_in_move()
        return self.pulses - self._lost - lost

    @property
    def lost(self) -> int:
        """Number of lost steps: pulses of the step output minus the motor position."""
        return self.pulses - self.position

    def losing(self) -> Callable[[int], int] | None:
        """Return f(n), the lost steps after n pulses of the move; None if the move loses none."""
        if not self._slips:
            return None
        before, direction, found, per_tooth = self._lost, self.train.move.direction, self._slips, self._per_tooth
        last = None if self._held else self.train.move.profile.pulses
        return lambda pulses: before + direction * lost_pulses(found, pulses, pulses == last, per_tooth)

    @property
    def stalled(self) -> bool:
        """True if the controller issues pulses that the rotor does not follow."""
        move = self.train.move
        if not self._slips or not self.moving:
            return False
        pulses = move.profile.pulses_by(self.clock.now - move.start_ns)
        return any(slip.first < pulses and (slip.last is None or pulses < slip.last) for slip in self._slips)

    @property
    def per_rev(self) -> int | None:
        """Pulses per revolution from the data sheet of motor or encoder; None: unknown."""
        if self.motor is not None:
            return self.motor.pulses_per_rev
        return self._encoder.data.pulses_per_rev if self._encoder else None

    @property
    def pulses(self) -> int:
        """Net pulse count of the step output: positive pulses minus negative pulses."""
        return self._issued - self._unmade if self._made is None else self._made

    @property
    def _issued(self) -> int:
        return self.train.move.position_at(self.clock.now)

    @property
    def unmade(self) -> int:
        """Net count of the pulses that `hold` has suppressed, until `let_go`."""
        return self._unmade if self._made is None else self._issued - self._made

    def hold(self, made: int) -> None:
        """Suppress all pulses after the count `made`, until `let_go`: a board has stopped the real motor."""
        self._lost += self.train.move.direction * self._lost_in_move()
        self._slips, self._made = [], made
        self.on_motion.emit()

    def let_go(self) -> None:
        if self._made is not None:
            self._unmade, self._made = self._issued - self._made, None
            self._replan()

    @property
    def velocity(self) -> float:
        """Rate of the issued pulses in pulses per second; negative in the negative direction."""
        move = self.train.move
        return move.direction * float(move.profile.rate_at(self.clock.now - move.start_ns))

    def pulse_times(self, start_ns: int = 0, stop_ns: int | None = None) -> "NDArray[np.int64]":
        """Return the times of issued pulses in ns, from `start_ns` to before `stop_ns` (None: up to now)."""
        return self.train.pulse_times(start_ns, self.clock.now + 1 if stop_ns is None else stop_ns)

    @property
    def encoder(self) -> EncoderView:
        """The encoder of the axis.  Raises UsageError for an axis without the option `encoder`."""
        if self._encoder is None:
            raise UsageError(
                f"axis {self.name} has no encoder: add the option `encoder` to the axis, "
                "e.g. encoder = { counts_per_rev = 4000 }"
            )

        return self._encoder

    # Functions that predict the time at which the motor reaches a position or loses steps

    def reaches_ns(self, position: int) -> int | None:
        """Return the time in ns at which the present move next reaches `position`; None if never."""
        move, now_ns = self.train.move, self.clock.now
        if self._made is not None:
            return None
        n = (position + self._lost + self._unmade - move.origin) * move.direction
        for slip in self._slips:
            if n <= slip.first:
                break
            if slip.last is None:
                return None
            n += lost_pulses([slip], slip.last, False, self._per_tooth)
        at_ns = move.reaches_ns(move.origin + move.direction * n)
        return at_ns if at_ns is not None and at_ns > now_ns else None

    def subscribe_edges(self, edges: Sequence[int], callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` on the pulse that crosses an edge, n between n-1 and n; return an unsubscribe function."""
        return _EdgeSubscription(self, lambda: edges, callback).end

    def _lost_in_move(self, over: bool = False) -> int:
        return self._behind((over or not self.moving) and not self._held) if self._slips else 0

    def _behind(self, settled: bool) -> int:
        """Return the move's lost steps; `settled`: the rotor rests at a tooth, not between two."""
        if not self._slips or self._made is not None:
            return 0
        move = self.train.move
        pulses = move.profile.pulses_by(self.clock.now - move.start_ns)
        return lost_pulses(self._slips, pulses, settled, self._per_tooth)

    @property
    def _per_tooth(self) -> int:
        return self.motor.pulses_per_tooth if self.motor else 1

    @property
    def _held(self) -> bool:
        return self.jammed or not self.strength

    @property
    def _loses_no_steps(self) -> bool:
        """True if the motor cannot lose steps.  An ideal motor loses steps only if its rotor is blocked."""
        return self.motor is None and not (self._slips or self._was_held)

    def _fall_in(self) -> None:
        """Move a free rotor to the next tooth, so that the lost pulses are whole teeth."""
        if self._lost and not self._held:
            self._lost = (1 if self._lost > 0 else -1) * whole_teeth(abs(self._lost), self._per_tooth)

    def _update_held(self) -> None:
        if self._held and not self._was_held and not self.moving:
            self._lost, self._slips = self._lost + self.train.move.direction * self._behind(settled=True), []
        self._was_held = self._held
        self._fall_in()

    def _find_slips(self, elapsed_ns: int, out_of_step: bool) -> list[Slip]:
        if self._made is not None:
            return []
        motor = self.motor
        if motor is None:
            if not self._was_held:
                return []
            motor = StepperMotor(torque=((0.0, 0.0),), pulses_per_rev=1, rotor_teeth=1)
        return slips(motor, self._torque_needed, self.train.move.profile, elapsed_ns, out_of_step)

    def _torque_needed(self, acceleration: float) -> float:
        if self._held:
            return float("inf")
        if self.motor is None:
            return 0.0
        inertia = self.motor.inertia + self._load.inertia
        outside = self.outside_torque * self.train.move.direction
        return abs(inertia * self.motor.to_radians(acceleration) + self._load.torque - outside) / self.strength

    def _replan(self) -> None:
        if self._loses_no_steps and not self._held:
            self.on_motion.emit()
            return
        self._update_held()
        elapsed_ns = self.clock.now - self.train.move.start_ns
        pulses = self.train.move.profile.pulses_by(elapsed_ns)
        past = [slip for slip in self._slips if slip.first < pulses]
        out_of_step = bool(past) and (past[-1].last is None or past[-1].last > pulses)
        future = self._find_slips(elapsed_ns, out_of_step)
        if out_of_step and future:
            past[-1].last = future.pop(0).last
        elif out_of_step:
            past[-1].last = pulses
        self._slips = past + future
        self.on_motion.emit()


class _EdgeSubscription:
    def __init__(self, axis: StepperAxis, edges: Callable[[], Sequence[int]], callback: Callable[[], None]) -> None:
        self._axis, self._edges, self._callback = axis, edges, callback
        self._plan = 0
        self._drop: Callable[[], None] | None = None  # Drops the event of the next edge.
        self._unsubscribe = axis.on_motion.subscribe(self.update)
        self._wait()

    def end(self) -> None:
        self._forget()
        self._unsubscribe()

    def update(self) -> None:
        self._forget()
        plan = self._plan
        self._callback()
        if plan == self._plan:
            self._wait()

    def _wait(self) -> None:
        axis = self._axis
        positions = (position for edge in self._edges() for position in (edge - 1, edge))
        due = [at_ns for position in positions if (at_ns := axis.reaches_ns(position)) is not None]
        if due:
            self._drop = axis.clock.call_unless(min(due) - axis.clock.now, self._call)

    def _forget(self) -> None:
        self._plan += 1
        if self._drop is not None:
            self._drop()
        self._drop = None

    def _call(self) -> None:
        self._drop = None
        self.update()
