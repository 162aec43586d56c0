"""An axis with a stepper motor: pulses in, position out.

The controller knows an axis by `start`, `replace`, `halt`, `encoder_count` and `on_push`; everything else is the
machine's own truth.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from axistwin.errors import UsageError
from axistwin.motion.profile import Profile
from axistwin.motion.train import HISTORY, Train
from axistwin.plant.encoder import Encoder, EncoderData
from axistwin.plant.layers import Layers
from axistwin.plant.torque import Load, Slip, StepperMotor, lost_pulses, slips, whole_teeth
from axistwin.sim.by_hand import ByHand, check_counts, check_torque
from axistwin.sim.clock import Clock
from axistwin.sim.pins import SensedPin

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class EncoderView:
    """The encoder of an axis as a person at the bench has it."""

    def __init__(self, axis: "StepperAxis", encoder: Encoder) -> None:
        self._axis, self._encoder = axis, encoder

    @property
    def data(self) -> EncoderData:
        """Its resolution, and the play before it."""
        return self._encoder.data

    @property
    def count(self) -> int:
        """Counts after quadrature, from 0 when the bench is made."""
        return self._encoder.follow(self._axis.position)

    def displace(self, counts: int) -> None:
        """Somebody pushes the load by so many counts; it stays there until the motor moves it back."""
        check_counts(counts, "displace")
        self._axis.by_hand.tell("push", counts)
        self._encoder.displace(counts)
        self._moved()

    @property
    def at_index(self) -> bool:
        """True while its channel Z is active."""
        _ = self.count
        return self._encoder.at_index

    def watch_index(self, look: Callable[[], None]) -> Callable[[], None]:
        """Call `look()` whenever its channel Z may have begun or ended.  Returns what ends the calls."""

        def edges() -> Sequence[int]:
            _ = self.count
            return self._encoder.index_edges()

        watch = _EdgeWatch(self._axis, edges, look)
        self._axis.on_push.append(watch.look)

        def end() -> None:
            self._axis.on_push.remove(watch.look)
            watch.end()

        return end

    def begin(self) -> None:
        """A stroke begins: the play has followed the one that ends here."""
        _ = self.count
        self._encoder.begin()

    def counted(self, since: int) -> bool:
        """True if it has counted since the axis was at this position of the present stroke."""
        return self.count != self._encoder.count_at(since)

    @property
    def direction(self) -> int:
        """+1 or -1: where the load has moved last."""
        _ = self.count
        return self._encoder.direction

    def miscount(self, of: int, out_of: int) -> None:
        """From now on it counts `of` for each `out_of` counts; 1 of 1: as it should."""
        _ = self.count  # it has counted well so far
        self._encoder.miscount(of, out_of)
        self._moved()

    def slip(self, counts: int) -> None:
        """It turns on its shaft by so many counts, and nothing else moves."""
        _ = self.count
        self._encoder.slip(counts)
        self._moved()

    def _moved(self) -> None:
        for action in tuple(self._axis.on_push):
            action()


class StepperAxis:
    """Motor, load and encoder behind one step output.  Without a `motor` it is ideal and never stalls."""

    def __init__(
        self,
        clock: Clock,
        name: str,
        *,
        motor: StepperMotor | None = None,
        load: Load | None = None,
        encoder: EncoderData | None = None,
        limits: tuple[int, int] | None = None,
        home: tuple[int, int] | None = None,
        history: int = HISTORY,
    ) -> None:
        self.clock, self.name, self.train = clock, name, Train(history)
        self.limits, self.home = limits, home
        """The first and the last position within the limit switches, and of the home switch; None: there are none."""
        self.on_motion: list[Callable[[], None]] = []
        """Called when a stroke begins or takes another course."""
        self.on_push: list[Callable[[], None]] = []
        """Called when the load has been pushed."""
        self.by_hand = ByHand(clock)
        """Reports what a person does to it: `load`, `jam`, `push`."""
        self._motor, self._load = motor, load or Load()
        self._encoder = EncoderView(self, Encoder(encoder)) if encoder else None
        self._outside = Layers(0.0, self._reconsider)
        self._jams = Layers(False, self._reconsider)
        self._torque_left = Layers(1.0, self._reconsider)
        self._slips: list[Slip] = []
        self._lost = 0  # net pulses lost in strokes that are over
        self._was_held = False

    # What the controller does

    def start(self, profile: Profile, direction: int) -> None:
        """Give out a new stroke, from now on; `direction` +1 or -1."""
        self._lost += self.train.stroke.direction * self._lost_in_stroke(over=True)
        self._fall_in()
        if self._encoder:
            self._encoder.begin()
        self.train.start(self.clock.now, direction, profile)
        self._slips = self._find_slips(0, out_of_step=False)
        self._tell()

    def replace(self, profile: Profile) -> None:
        """The stroke takes another course from now on; `profile` tells it from the stroke's start."""
        self.train.replace(profile)
        self._reconsider()

    def halt(self) -> None:
        """No more pulses, at once."""
        self.replace(self.train.stroke.profile.cut(self.clock.now - self.train.stroke.start_ns))

    @property
    def encoder_count(self) -> int | None:
        """Encoder counts after quadrature; None: there is no encoder."""
        return self._encoder.count if self._encoder else None

    def wire_index(self, pin: SensedPin) -> None:
        """Connect the encoder's channel Z to a terminal, if there is an encoder."""
        if (encoder := self._encoder) is not None:
            pin.sense(lambda: encoder.at_index, encoder.watch_index)

    def encoder_counted(self, within_ns: int) -> bool:
        """True if the encoder has counted within so many ns until now, in the present stroke."""
        if self._encoder is None:
            return False
        stroke = self.train.stroke
        done = stroke.profile.pulses_by(max(0, self.clock.now - within_ns - stroke.start_ns))
        behind = lost_pulses(self._slips, done, False, self._per_tooth)
        return self._encoder.counted(stroke.origin - self._lost + stroke.direction * (done - behind))

    @property
    def encoder_direction(self) -> int:
        """+1 or -1: where the encoder has moved last; +1 without one."""
        return self._encoder.direction if self._encoder else +1

    @property
    def moving(self) -> bool:
        """Whether pulses are still to come."""
        return self.train.moving(self.clock.now)

    @property
    def resting(self) -> bool:
        """Whether it stays where it is until a stroke begins."""
        return not self.moving

    @property
    def foreseen(self) -> bool:
        """Whether its course is known up to the next stroke; a motor that loses steps is looked at instead."""
        return not self._slips

    @property
    def follows(self) -> None:
        """A stepper's controller takes no external encoder."""
        return

    def positions_at(self, times_ns: Sequence[int]) -> list[int]:
        """Where the motor stands at these times from the latest stroke on, in order, while no steps are lost."""
        import numpy as np

        stroke = self.train.stroke
        since_ns = np.maximum(np.asarray(times_ns, np.int64) - stroke.start_ns, 0)
        profile = stroke.profile
        first, last = profile.pulses_by(int(since_ns[0])), profile.pulses_by(int(since_ns[-1]))
        pulses_ns = np.empty(last - first, np.int64)
        profile.fill_pulse_times(first + 1, 0, pulses_ns)
        done = first + np.searchsorted(pulses_ns, since_ns, side="right")
        found: list[int] = (stroke.origin - self._lost + stroke.direction * done).tolist()
        return found

    # What a person sees and does

    @property
    def position(self) -> int:
        """Where the motor stands, in pulses from 0 when the bench is made."""
        return self.pulses - self._lost - self.train.stroke.direction * self._lost_in_stroke()

    @property
    def lost(self) -> int:
        """Net pulses that the motor has not followed: those issued, less where it stands."""
        return self.pulses - self.position

    @property
    def stalled(self) -> bool:
        """Whether pulses go out and the rotor, out of step, does not follow them."""
        stroke = self.train.stroke
        if not self._slips or not self.moving:
            return False
        pulses = stroke.profile.pulses_by(self.clock.now - stroke.start_ns)
        return any(slip.first < pulses and (slip.last is None or pulses < slip.last) for slip in self._slips)

    @property
    def per_rev(self) -> int | None:
        """Pulses for a turn of the motor, by its data sheet or its encoder's; None: nobody has said."""
        if self._motor is not None:
            return self._motor.pulses_per_rev
        return self._encoder.data.pulses_per_rev if self._encoder else None

    @property
    def pulses(self) -> int:
        """Net pulses issued: plus those in the positive, minus those in the negative direction."""
        return self.train.stroke.position_at(self.clock.now)

    @property
    def velocity(self) -> float:
        """Pulses per second that are being issued, negative in the negative direction."""
        stroke = self.train.stroke
        return stroke.direction * float(stroke.profile.rate_at(self.clock.now - stroke.start_ns))

    def pulse_times(self, start_ns: int = 0, stop_ns: int | None = None) -> "NDArray[np.int64]":
        """The nanoseconds at which pulses were issued, from `start_ns` to before `stop_ns` (None: up to now)."""
        return self.train.pulse_times(start_ns, self.clock.now + 1 if stop_ns is None else stop_ns)

    @property
    def encoder(self) -> EncoderView:
        """The encoder, if the axis was given one: `encoder={"counts_per_rev": ...}`."""
        if self._encoder is None:
            ways = f'{self.name}={{"encoder": {{}}}}, in a scene axes.{self.name}.encoder = {{}}'
            raise UsageError(f"axis {self.name} has no encoder: add one with {ways}")

        return self._encoder

    @property
    def outside_torque(self) -> float:
        """The torque on the shaft from outside, in N·m."""
        return sum(self._outside.values)

    @property
    def jammed(self) -> bool:
        """Whether the shaft cannot turn."""
        return any(self._jams.values)

    @property
    def strength(self) -> float:
        """What is left of the motor's torque, 0 to 1: of several defects the worst counts."""
        return min(self._torque_left.values)

    def weaken(self, left: float) -> Callable[[], None]:
        """So much is left of the motor's torque, 0 to 1: with 0 the rotor stands, an ideal motor knows only 0 and 1.

        Returns what ends it.
        """
        return self._torque_left.add(left)

    def load(self, newton_metres: float) -> None:
        """A torque on the shaft from outside; positive turns it in the positive direction."""
        check_torque(newton_metres)
        self.by_hand.tell("load", newton_metres)
        self._outside.set(newton_metres)

    def burden(self, newton_metres: float) -> Callable[[], None]:
        """A defect brings one more torque from outside.  Returns what ends it."""
        return self._outside.add(newton_metres)

    def jam(self, on: bool = True) -> None:
        """A shaft that cannot turn, while pulses go on."""
        self.by_hand.tell("jam", on)
        self._jams.set(on)

    def seize(self) -> Callable[[], None]:
        """A defect keeps the shaft from turning, whoever else does.  Returns what ends it."""
        return self._jams.add(True)

    # The machine

    def reaches_ns(self, position: int) -> int | None:
        """When the motor will next stand at `position`, as things are now; None: not in this stroke."""
        stroke, now_ns = self.train.stroke, self.clock.now
        n = (position + self._lost - stroke.origin) * stroke.direction
        per_tooth = self._motor.pulses_per_tooth if self._motor else 1
        for slip in self._slips:
            if n <= slip.first:
                break
            if slip.last is None:
                return None
            n += lost_pulses([slip], slip.last, False, per_tooth)
        at_ns = stroke.reaches_ns(stroke.origin + stroke.direction * n)
        return at_ns if at_ns is not None and at_ns > now_ns else None

    def watch_edges(self, edges: Sequence[int], look: Callable[[], None]) -> Callable[[], None]:
        """Call `look()` on the very pulse that crosses one of these edges; edge n lies between position n-1 and n.

        Returns what ends it.
        """
        return _EdgeWatch(self, lambda: edges, look).end

    def _lost_in_stroke(self, over: bool = False) -> int:
        return self._behind((over or not self.moving) and not self._held)

    def _behind(self, settled: bool) -> int:
        """The pulses of this stroke that are lost, with the rotor standing between teeth or settled in one."""
        if not self._slips:
            return 0
        stroke = self.train.stroke
        pulses = stroke.profile.pulses_by(self.clock.now - stroke.start_ns)
        return lost_pulses(self._slips, pulses, settled, self._per_tooth)

    @property
    def _per_tooth(self) -> int:
        return self._motor.pulses_per_tooth if self._motor else 1

    @property
    def _held(self) -> bool:
        """Whether the rotor stays where it is, in step with the field or not: jammed, or without torque."""
        return self.jammed or not self.strength

    def _fall_in(self) -> None:
        """A rotor that is free falls into the next tooth, so that it has lost whole ones."""
        if self._lost and not self._held:
            self._lost = (1 if self._lost > 0 else -1) * whole_teeth(abs(self._lost), self._per_tooth)

    def _settle(self) -> None:
        """Held from now on, it stays where it has fallen in after its last stroke; let go, it falls in."""
        if self._held and not self._was_held and not self.moving:
            self._lost, self._slips = self._lost + self.train.stroke.direction * self._behind(settled=True), []
        self._was_held = self._held
        self._fall_in()

    def _find_slips(self, elapsed_ns: int, out_of_step: bool) -> list[Slip]:
        motor = self._motor
        if motor is None:
            if not self.jammed and self.strength:
                return []
            motor = StepperMotor(torque=((0.0, 0.0),), pulses_per_rev=1, rotor_teeth=1)
        return slips(motor, self._torque_needed, self.train.stroke.profile, elapsed_ns, out_of_step)

    def _torque_needed(self, acceleration: float) -> float:
        if self._held:
            return float("inf")
        if self._motor is None:
            return 0.0
        inertia = self._motor.inertia + self._load.inertia
        outside = self.outside_torque * self.train.stroke.direction
        needed = abs(inertia * self._motor.to_radians(acceleration) + self._load.torque - outside)
        return needed / self.strength

    def _reconsider(self) -> None:
        """The course or the load has changed: what has happened stays, what will happen is found anew."""
        self._settle()
        elapsed_ns = self.clock.now - self.train.stroke.start_ns
        pulses = self.train.stroke.profile.pulses_by(elapsed_ns)
        past = [slip for slip in self._slips if slip.first < pulses]
        out_of_step = bool(past) and (past[-1].last is None or past[-1].last > pulses)
        future = self._find_slips(elapsed_ns, out_of_step)
        if out_of_step and future:
            past[-1].last = future.pop(0).last
        elif out_of_step:
            past[-1].last = pulses
        self._slips = past + future
        self._tell()

    def _tell(self) -> None:
        for action in tuple(self.on_motion):
            action()


class _EdgeWatch:
    """Comes back whenever the axis crosses an edge, as far as its present course tells; the edges may move."""

    def __init__(self, axis: StepperAxis, edges: Callable[[], Sequence[int]], look: Callable[[], None]) -> None:
        self._axis, self._edges, self._look_there = axis, edges, look
        self._plan, self._waiting = 0, False
        axis.on_motion.append(self.look)
        self._wait()

    def end(self) -> None:
        """Come back no more."""
        self._forget()
        self._axis.on_motion.remove(self.look)

    def look(self) -> None:
        """Look now, and come back at the next edge."""
        self._forget()
        plan = self._plan
        self._look_there()
        if plan == self._plan:
            self._wait()

    def _wait(self) -> None:
        """Come back at the next of them, if the axis gets there."""
        plan, axis = self._plan, self._axis
        positions = (position for edge in self._edges() for position in (edge - 1, edge))
        due = [at_ns for position in positions if (at_ns := axis.reaches_ns(position)) is not None]
        if due:
            self._waiting = True
            axis.clock.call_later(min(due) - axis.clock.now, lambda: self._come_back(plan))

    def _forget(self) -> None:
        """What was planned is void; nobody need wait for it."""
        self._plan += 1
        self._axis.clock.background += self._waiting
        self._waiting = False

    def _come_back(self, plan: int) -> None:
        if plan == self._plan:
            self._waiting = False
            self.look()
        else:
            self._axis.clock.background -= 1
