"""Compute the samples of a motor in blocks ahead of the clock; a block ends at the next event of the motor.

    base ────────────── block ──────────────▶ end: an event for Python to handle, at exactly this sample
     ↑ the committed state: i, v, f       ↑ computed on copies; the positions can be read meanwhile

When an input changes in the middle of a block, the block is discarded and computed again from its base up to the last
sample before the change.  Blocks are long while nothing changes, and short while a host sends.  The division of a run
into blocks does not change the behaviour of the motor.  A motor at rest takes no computing time.
"""

from array import array
from collections.abc import Callable, Sequence
from enum import Enum, auto
from operator import sub
from typing import Any, ClassVar, NamedTuple

from axistwin.controllers.smartmotor.kernel import jit, log
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.kernel import ALL_DONE, BEFORE_SAMPLE, advance
from axistwin.controllers.smartmotor.kernel.physics import FLOATS
from axistwin.controllers.smartmotor.kernel.position import commanded_shaft
from axistwin.controllers.smartmotor.kernel.servo import rest, resting
from axistwin.sim.clock import Clock
from axistwin.sim.signal import Signal

SAMPLE_NS = 245_760  # Duration of a sample in ns; the command RSP reports it as 24576, in units of 10 ns.
SHORTEST, LONGEST, LONGEST_PLAIN = 16, 1 << 12, 1 << 7
"""Numbers of samples in a block; computing a block takes less than 2 ms, the time slice of a served bench."""
AT_ONCE = 4  # Number of blocks of the longest size that are computed as one while no host can wait for them.
PLAIN_SAMPLES = 20_000  # Number of samples, of all motors, that plain Python computes before the compiler is loaded.
PLAIN_MOTORS = 8  # Number of motors that plain Python runs in real time on any computer.
STACK = 64
PID_MOST = 8  # Longest period of the trajectory in samples, set by PID8.

Follower = Callable[[Sequence[int], Sequence[int], Sequence[int]], None]
"""Function that is called with the changes of traced values: times in ns, indexes and new values."""


class Phase(Enum):
    """State of the simulation of one motor, e.g. `ASLEEP` while the motor rests."""

    BETWEEN = auto()  # No block is computed or planned.
    PLANNED = auto()  # The next block will be computed at the end of this nanosecond.
    AHEAD = auto()  # A block is computed ahead.
    WAITING = auto()  # The motor rests until a WAIT of the program ends.
    ASLEEP = auto()  # The motor rests until its state is changed.
    ACTING = auto()  # The event at which a block has ended is being handled.
    STOPPED = auto()  # No more samples are computed, because the motor is about to be switched on again.


class _Block(NamedTuple):
    first: int
    samples: int
    why: int = ALL_DONE

    @property
    def end(self) -> int:
        return self.first + self.samples + (1 if self.why & BEFORE_SAMPLE else 0)


class Core:
    """The committed state of a motor, and the block computed ahead.  `act(why)` handles the end of a block."""

    def __init__(self, clock: Clock, act: Callable[[int], None], ring: int) -> None:
        self.clock, self._act = clock, act
        self.zero_ns = clock.now
        self.i, self.v = array("q", bytes(8 * s.INTS)), array("q", bytes(8 * s.VARIABLES))
        self.f = array("d", bytes(8 * FLOATS))
        self.ring, self.code = array("q", bytes(16 * ring)), array("q", [0, 0])
        self.i[s.HOST_SIZE] = len(self.ring)
        self.log = log.empty()
        self._snapshot = log.Snapshot(self.log)
        self.on_samples: Signal[[int, array[int], array[int]]] = Signal()
        """Event: samples are final.  Its data: number of the first sample, positions of shaft and trajectory."""
        self.read_ahead: Callable[[range], Sequence[int]] | None = None
        """Function that returns the external encoder's present edge count, followed by the known counts at later times.

        The sample after each of these times uses the count at this time.  None if the encoder can be predicted.
        """
        self.on_replan: Signal[[]] = Signal()  # Event: samples that were computed ahead have been discarded.
        self._keeps_read = False
        self.predict: Callable[[int, int], Sequence[int]] | None = None
        """Function that predicts the external encoder's edges for the next samples."""
        self._follower: Follower | None = None
        self._restless = False
        self._engine = Engine(self)
        self._phase = Phase.BETWEEN
        self._block: _Block | None = None
        self._most, self._plan = SHORTEST, 0
        self._moves = [0] * PID_MOST

    @property
    def due(self) -> int:
        """Index of the latest servo sample; the servo takes a sample every 245.76 µs of virtual time."""
        return (self.clock.now - self.zero_ns) // SAMPLE_NS

    def time_ns(self, sample: int) -> int:
        """Return the virtual time of a servo sample in ns.  `sample`: index of the servo sample."""
        return self.zero_ns + sample * SAMPLE_NS

    def position_now(self) -> int:
        """Return the present position of the shaft.  The block that is computed ahead stays valid."""
        past = self._past()
        return self._engine.shaft[past - 1] if past else self.i[s.SHAFT] + self.i[s.SLIPPED]

    def commanded_now(self) -> int:
        """Return the present commanded position of the shaft.  The block that is computed ahead stays valid."""
        past = self._past()
        return self._engine.commanded[past - 1] if past else commanded_shaft(self.i)

    def positions_ahead(self, times_ns: range) -> list[int]:
        """Return the shaft's positions now and at `times_ns`, one sample apart, as long as they are certain.

        They are certain before the end of the block, and always while the motor sleeps.
        """
        block, first, here = self._block, self.i[s.SAMPLE], self.position_now()
        if self._phase is Phase.ASLEEP:
            return [here] * (1 + len(times_ns))
        if block is None or self._phase is not Phase.AHEAD:
            return [here]
        due = (times_ns.start - self.zero_ns) // SAMPLE_NS
        following = max(due, min(due + len(times_ns), block.end))
        if due == first < following:
            # Until the time `times_ns[0]`, the shaft does not move.
            return [here, here, *self._engine.shaft[: following - first - 1]]
        return [here, *self._engine.shaft[due - first - 1 : following - first - 1]]

    def keep_read_only(self) -> None:
        """Discard the samples that use edges read ahead, because these edges are no longer certain.

        The next sample is kept, because its edges were read before now.
        """
        block = self._block
        if self.read_ahead is not None and self._phase is Phase.AHEAD and block and block.end - self.due > 1:
            self.catch_up()
            self.i[s.PREDICTED] = min(self.i[s.PREDICTED], 1)
            self._keeps_read = True

    def _past(self) -> int:
        if self._block is None or self._phase is not Phase.AHEAD:
            return 0
        return max(0, min(self.due - self.i[s.SAMPLE], self._block.samples))

    @property
    def moving(self) -> bool:
        """True if the shaft's position may change in the next sample."""
        return self._phase not in (Phase.ASLEEP, Phase.STOPPED)

    @property
    def _running(self) -> bool:
        return self._phase is not Phase.STOPPED

    def catch_up(self, *, changing: bool = True) -> None:
        """Advance the state of the motor to the present time, and handle all events up to now.

        Without `changing` the state is only read, and a motor at rest stays at rest.
        """
        if self._phase in (Phase.ACTING, Phase.STOPPED) or (not changing and self._up_to_date()):
            return
        while self._running and (self._block is None or self._block.end <= self.due):
            missing = self.due - self.i[s.SAMPLE]
            if self._block is not None:
                self._finish(self._block)
            elif self._phase is Phase.ASLEEP:
                self._rest(max(0, missing))
                break
            elif missing <= 0:
                break
            else:
                self._compute_block(missing)
        self._commit_part()
        self._keeps_read = not changing
        self.replan()

    def _up_to_date(self) -> bool:
        missing = self.due - self.i[s.SAMPLE]
        if self._phase is Phase.ASLEEP:
            self._rest(missing)
            return True
        return missing == 0 and (self._block is None or self._block.end > self.due)

    def replan(self) -> None:
        """Schedule the next block for the end of this nanosecond, after all other changes."""
        if self._phase not in (Phase.PLANNED, Phase.STOPPED):
            self._phase = Phase.PLANNED
            self._plan += 1
            self.clock.call_later(0, self._compute_ahead)
            self.on_replan.emit()

    def speed(self) -> float:
        """Return the shaft's mean speed over the last n samples, in counts/sample; n of PIDn: 1, 2, 4 or 8."""
        rate = self.i[s.PID_RATE]
        return sum(self._moves_by(self._past())[-rate:]) / rate

    def _moves_by(self, computed: int) -> list[int]:
        """Return the shaft's movement in counts in each of the eight samples up to `computed` of the block."""
        shaft, first = self._engine.shaft, max(computed - PID_MOST, 0)
        before = shaft[first - 1] if first else self.i[s.SHAFT] + self.i[s.SLIPPED]
        places = [before, *shaft[first:computed]]
        return [*self._moves, *map(sub, places[1:], places)][-PID_MOST:]

    def stop(self) -> None:
        """Stop computing samples, before the motor is switched on again: until then the shaft may still turn."""
        self.catch_up()
        self._report_changes()
        self._phase, self._block = Phase.STOPPED, None
        self._plan += 1

    def follow(self, numbers: Sequence[tuple[int, int]], follower: Follower, *, restless: bool = False) -> None:
        """Report each change of these numbers to `follower`; a number is given by an operation and a place.  No
        change of a number that was followed before is lost.  `restless`: some of the numbers change while the motor
        rests, so that the samples must be computed.
        """
        self.catch_up()
        self.log = log.following(numbers, self.i, self.v, log.last_values(self.log))
        self._snapshot = log.Snapshot(self.log)
        self._follower, self._restless = follower, restless

    def unfollow(self) -> None:
        """Stop calling the follower, i.e. the function that receives changes of traced values."""
        self.catch_up()
        self.log, self._follower, self._restless = log.empty(), None, False

    def _report_changes(self) -> None:
        if self._follower is not None:
            which, values = self._snapshot.changed(self.i, self.v, self.log)
            if which:
                self._follower([self.clock.now] * len(which), which, values)

    def report(self, done: "array[int]") -> None:
        """Report changes of traced values during a block.  `done`: the log in which the kernel has stored them."""
        if self._follower is not None:
            self.log[log.head(done)] = done[log.head(done)]
            samples, which, values = log.changes(done)
            if samples:
                import numpy as np  # lazy import: NumPy is needed only while values are traced

                times = self.zero_ns + SAMPLE_NS * np.frombuffer(samples, np.int64)
                self._follower(array("q", times.tobytes()), which, values)

    def _compute_ahead(self) -> None:
        if self._phase is Phase.STOPPED:
            return
        self._phase = Phase.BETWEEN
        self._report_changes()
        self._plan += 1
        most = self._length()
        if self.read_ahead is not None:
            most = self._read(self.read_ahead, most)
        self._schedule_end(self._compute_block(most))

    def _length(self) -> int:
        """Return the number of servo samples to compute in the next block.

        An event, e.g. a fault, may end the block earlier.  During a trajectory several blocks may be computed as one,
        because the end of the trajectory ends the block anyway. One long block saves a fifth of the computing time of a
        hundred motors, because each change to another motor replaces the contents of the processor's cache.
        """
        most = min(self._most, self._engine.longest)
        as_one = most == LONGEST and self.i[s.BT] and self.clock.patient
        return AT_ONCE * most if as_one else most

    def _read(self, read_ahead: Callable[[range], Sequence[int]], most: int) -> int:
        kept, self._keeps_read = self._keeps_read and self.i[s.PREDICTED] > 0, False
        if not kept:
            sample = self.i[s.SAMPLE]
            edges = read_ahead(range(self.time_ns(sample + 1), self.time_ns(sample + most), SAMPLE_NS))
            self._engine.predicted = array("q", edges)
            self.i[s.PREDICTED], self.i[s.PREDICTED_AT] = len(edges), 0
        return min(most, self.i[s.PREDICTED])

    def _schedule_end(self, block: _Block) -> None:
        """Schedule the end of a block; joined ones keep an event each, as an endless run ends with the last."""
        plan, end = self._plan, block.end
        if self._phase is Phase.AHEAD:
            end = min(end, block.first + LONGEST * (1 + (self.due - block.first) // LONGEST))
        background = self.i[s.PROGRAM] != s.RUNNING and not self.i[s.BT] and block.why == ALL_DONE
        self.clock.background += background

        def at_its_end() -> None:
            self.clock.background -= background
            if plan != self._plan:
                return
            if end < block.end:
                self._schedule_end(block)
            else:
                self._finish(block)
                self._continue(block)

        self.clock.call_later(self.time_ns(end) - self.clock.now, at_its_end)

    def _continue(self, block: _Block) -> None:
        if self._phase is Phase.STOPPED:
            return
        self._plan += 1
        self._report_changes()
        if self._phase is Phase.PLANNED:
            return
        follows = self.read_ahead is not None
        if follows or block.why != ALL_DONE or block.samples <= self.i[s.DEBOUNCE] or not self._rests():
            self._compute_ahead()
            return
        waits = self.i[s.WAIT_UNTIL] - 1 - self.i[s.SAMPLE] if self.i[s.PROGRAM] == s.RUNNING else 0
        if waits > 0:
            self._phase, self._block = Phase.WAITING, _Block(self.i[s.SAMPLE], waits)
            self._schedule_end(self._block)
        else:
            self._phase = Phase.ASLEEP
            self._engine.forget()

    def _rests(self) -> bool:
        if self._restless:
            return False
        i = self.i
        program = i[s.PROGRAM] != s.RUNNING or i[s.SAMPLE] + 1 < i[s.WAIT_UNTIL]
        quiet = not i[s.BT] and not i[s.PENDING] and not i[s.MASTER_LEFT] and i[s.MODE] < s.M_FOLLOW
        return program and quiet and bool(resting(i, self.f))

    def _compute_block(self, most: int) -> _Block:
        self._block = self._compute(most)
        self._phase = Phase.AHEAD
        return self._block

    def _compute(self, most: int) -> _Block:
        first = self.i[s.SAMPLE]
        if self.predict is not None and self.i[s.PREDICTED] < most:
            self._engine.predicted = array("q", self.predict(first + 1, most))
            self.i[s.PREDICTED], self.i[s.PREDICTED_AT] = most, 0
        why, samples = self._engine.run(most)
        return _Block(first, samples, why)

    def _finish(self, block: _Block) -> None:
        waiting = self._phase is Phase.WAITING
        self._phase, self._block = Phase.BETWEEN, None
        if waiting:
            self._rest(block.samples)
            return
        self._commit(block)
        self._most = min(2 * self._most, LONGEST)
        if block.why:
            before, self._phase = self._phase, Phase.ACTING
            self._act(block.why)
            if self._phase is Phase.ACTING:
                self._phase = before

    def _commit_part(self) -> None:
        """Advance the motor's state to the present time.  Samples that were computed for later times are discarded."""
        phase, block = self._phase, self._block
        if phase not in (Phase.AHEAD, Phase.WAITING, Phase.ASLEEP) or block is None:
            self._phase = Phase.BETWEEN if phase is Phase.ASLEEP else phase
            return
        self._phase, self._block = Phase.BETWEEN, None
        samples = self.due - block.first
        if phase is Phase.WAITING:
            self._rest(samples)
            return
        in_last = samples % LONGEST
        # After a command from the host, the servo samples that were computed in advance are discarded.
        # Compute fewer servo samples in advance if commands from the host are frequent.
        self._most = min(max(in_last + in_last // 4, SHORTEST), LONGEST)
        if samples > 0:
            self._commit(self._compute(samples))

    def _commit(self, block: _Block) -> None:
        self._moves = self._moves_by(block.samples)
        self._engine.commit(block)

    def _rest(self, samples: int) -> None:
        self._moves = [*self._moves, *[0] * min(samples, PID_MOST)][-PID_MOST:]
        rest(self.i, self.f, samples)


class Engine:
    """Computes the servo cycles in a copy of the motor's state, which replaces the state by `commit`.

    Plain Python executes the kernel; for long simulations, the kernel is compiled.  The shaft's positions in each
    sample of a block are kept in arrays that grow with the blocks.
    """

    plain_samples: ClassVar[int] = 0
    """Number of samples, of all motors, that plain Python has computed; it affects only the speed."""
    compiled: ClassVar[Callable[..., int] | None] = None

    def __init__(self, core: Core) -> None:
        self._core = core
        self.shaft, self.commanded = array("q"), array("q")
        self._stack = array("q", bytes(8 * STACK))
        self._code, self._log, self._followed = core.code, core.log, core.log
        self._copies: tuple[Any, ...] = ()
        self._views: tuple[Any, ...] = ()
        self.predicted = array("q", [0])  # Known edges of the external encoder in the next samples.
        self._viewed = self.predicted

    @property
    def longest(self) -> int:
        """Most samples that one call of `run` may compute; more would delay an answer to the host noticeably."""
        return LONGEST if self._compiled() else LONGEST_PLAIN

    def run(self, most: int) -> tuple[int, int]:
        """Compute up to `most` samples, or until an event.  Return the event and the number of samples."""
        core = self._core
        self._make_room(most)
        if compiled := self._compiled():
            self._renew_views()
            i, v, f, ring = self._copies
            i[:], v[:], f[:], ring[:] = core.i, core.v, core.f, core.ring
            why = compiled(*self._views, most)
        else:
            i, v, f, ring = self._copies = core.i[:], core.v[:], core.f[:], core.ring[:]
            outputs = self.shaft, self.commanded, self._log
            why = advance(i, v, f, self._stack, core.code, ring, self.predicted, *outputs, most)
            Engine.plain_samples += i[s.SAMPLE] - core.i[s.SAMPLE]
        return why, i[s.SAMPLE] - core.i[s.SAMPLE]

    def _compiled(self) -> Callable[..., int] | None:
        """Return the machine code if a long run justifies loading it; None: plain Python computes the samples."""
        if Engine.compiled is None:
            enough = Engine.plain_samples >= PLAIN_SAMPLES and self._core.clock.patient
            if (enough or jit.setting() == "on") and jit.available():
                Engine.compiled = jit.best(advance)
        return Engine.compiled

    def commit(self, block: _Block) -> None:
        """Replace the motor's state by the computed one, at the end of `block`, and report the changes in it."""
        core = self._core
        i, v, f, ring = self._copies
        core.i[:], core.v[:], core.f[:], core.ring[:] = i, v, f, ring
        core.report(self._log)
        if block.samples:
            core.on_samples.emit(block.first + 1, self.shaft[: block.samples], self.commanded[: block.samples])

    def forget(self) -> None:
        """Release the memory for computed shaft positions when the motor comes to rest."""
        self.shaft, self.commanded, self._copies, self._views = array("q"), array("q"), (), ()

    def _make_room(self, most: int) -> None:
        log_of = self._core.log
        if most > len(self.shaft):
            room = 8 * max(SHORTEST, 1 << (most - 1).bit_length())
            self.shaft, self.commanded, self._views = array("q", bytes(room)), array("q", bytes(room)), ()
        if self._followed is not log_of:
            self._followed, self._log, self._views = log_of, log_of[:], ()
        self._log[log.head(log_of)] = log_of[log.head(log_of)]

    def _renew_views(self) -> None:
        """Renew the NumPy views, by which compiled code uses the motor's arrays, after one was replaced."""
        core = self._core
        if self._views and self._code is core.code and self._viewed is self.predicted:
            return
        self._code, self._viewed = core.code, self.predicted
        self._copies = core.i[:], core.v[:], core.f[:], core.ring[:]
        i, v, f, ring = (jit.view(numbers) for numbers in self._copies)
        others = self._stack, self._code, self.predicted, self.shaft, self.commanded, self._log
        stack, code, predicted, shaft, commanded, noted = (jit.view(numbers) for numbers in others)
        self._views = i, v, f, stack, code, ring, predicted, shaft, commanded, noted


def prepare(speed: float | None, motors: int) -> None:
    """Load, or first compile, the kernel, if plain Python is too slow for this speed and number of motors.

    Motors may run in another thread meanwhile; they use the compiled kernel as soon as it is ready.
    """
    if Engine.compiled is None and needs_kernel(speed, motors):
        core = Core(Clock(), lambda why: None, 1)
        kernel: Callable[..., int] = jit.best(advance)
        state = core.i, core.v, core.f, array("q", bytes(8 * STACK)), core.code, core.ring
        nothing = array("q", [0]), array("q", [0]), array("q", [0]), core.log
        kernel(*(jit.view(numbers) for numbers in (*state, *nothing)), 0)
        Engine.compiled = kernel


def needs_kernel(speed: float | None, motors: int) -> bool:
    """True if plain Python is too slow for this number of motors, and Numba is installed."""
    return (speed is None or speed * motors > PLAIN_MOTORS) and jit.available()


def prepared(speed: float | None, motors: int) -> bool:
    """True if no compilation is needed, because the machine code is cached or plain Python is fast enough."""
    return Engine.compiled is not None or not needs_kernel(speed, motors) or jit.is_cached()
