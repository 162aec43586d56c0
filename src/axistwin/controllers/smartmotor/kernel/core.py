"""Runs the motor's samples in virtual time: ahead of the clock, in blocks, until something happens.

    base ────────────── block ──────────────▶ end: something for Python to do, at exactly this sample
     ↑ the truth: i, v, f                 ↑ computed on copies; positions are kept for whoever looks meanwhile

When an input arrives in the middle of a block, the block is forgotten and computed again from its base up to the last
sample before the input.  A block is long while nothing comes, and short while a host is talking.  How a run is cut into
blocks makes no difference to what the motor does.  A motor that rests costs nothing at all.
"""

from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

from axistwin.controllers.smartmotor.kernel import jit, log
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.kernel import ALL_DONE, BEFORE_SAMPLE, advance
from axistwin.controllers.smartmotor.kernel.machine import FLOATS
from axistwin.controllers.smartmotor.kernel.position import commanded_shaft
from axistwin.controllers.smartmotor.kernel.servo import rest, resting
from axistwin.sim.clock import Clock

SAMPLE_NS = 245_760
"""RSP says 24576, in units of 10 ns."""
SHORTEST, LONGEST, LONGEST_PLAIN = 16, 1 << 12, 1 << 7
"""Samples in a block.  It takes less than the slice in which a served bench is advanced, 2 ms."""
PLAIN_SAMPLES = 20_000
"""So many samples, of all motors, are done in plain Python before it is worth while to load the compiler."""
PLAIN_MOTORS = 8
"""So many are certainly done in real time by plain Python."""
STACK = 64
PID_MOST = 8
"""PID8: the trajectory moves the shaft once in so many samples at most."""

Listener = Callable[[int, "array[int]", "array[int]"], None]
"""Told the number of the first sample, and where the shaft was and should have been in it and in those that follow."""
Follower = Callable[[Sequence[int], Sequence[int], Sequence[int]], None]
"""Told the times in ns at which numbers have changed that it follows, which of them, and to what."""


@dataclass(frozen=True)
class _Block:
    """Samples that have been computed ahead, or (`resting`) need not be; `why` it ended, as the kernel has it."""

    first: int
    samples: int
    why: int = ALL_DONE
    resting: bool = False

    @property
    def end(self) -> int:
        """The sample at whose time it is over; what comes before a sample comes at that sample's time."""
        return self.first + self.samples + (1 if self.why & BEFORE_SAMPLE else 0)


class Core:
    """The arrays, and what has been computed ahead.  `act(why)` is called when the kernel has stopped."""

    def __init__(self, clock: Clock, act: Callable[[int], None], ring: int) -> None:
        self.clock, self._act = clock, act
        self.zero_ns = clock.now
        self.i, self.v = array("q", bytes(8 * s.INTS)), array("q", bytes(8 * s.VARIABLES))
        self.f = array("d", bytes(8 * FLOATS))
        self.ring, self.code = array("q", bytes(16 * ring)), array("q", [0, 0])
        self.i[s.HOST_SIZE] = len(self.ring)
        self.log = log.empty()
        self._look_at = log.Look(self.log)
        self.listeners: list[Listener] = []
        self.running = True
        self.one_by_one: Callable[[], None] | None = None
        """If somebody has to be asked before each sample: ask him."""
        self.foretell: Callable[[int, int], Sequence[int]] | None = None
        """Tells the external encoder's edges for so many samples from this one on, as things are now."""
        self._follower: Follower | None = None
        self._restless = False
        self._engine = _Engine(self)
        self._block: _Block | None = None
        self._most, self._plan = SHORTEST, 0
        self._moves = [0] * PID_MOST
        self._asleep = self._acting = self._deferred = False

    @property
    def due(self) -> int:
        """The number of the last sample by now."""
        return (self.clock.now - self.zero_ns) // SAMPLE_NS

    def time_ns(self, sample: int) -> int:
        """When a sample is done."""
        return self.zero_ns + sample * SAMPLE_NS

    def look(self) -> int:
        """Where the shaft is now, without disturbing what has been computed."""
        done = self.due - self.i[s.SAMPLE]
        block = self._block
        if block is None or block.resting or done <= 0 or block.samples == 0:
            return self.i[s.SHAFT] + self.i[s.SLIPPED]
        return self._engine.shaft[min(done, block.samples) - 1]

    def look_commanded(self) -> int:
        """Where the trajectory would have the shaft now, in the machine's coordinates; nothing is disturbed either."""
        done = self.due - self.i[s.SAMPLE]
        block = self._block
        if block is None or block.resting or done <= 0 or block.samples == 0:
            return commanded_shaft(self.i)
        return self._engine.commanded[min(done, block.samples) - 1]

    @property
    def moving(self) -> bool:
        """Whether the next sample may find the shaft somewhere else."""
        return self.running and not self._asleep

    def catch_up(self, *, changing: bool = True) -> None:
        """Bring the state to the last sample by now, and do what has to be done on the way.  Then it may be changed.

        Not `changing`: it is only looked at, so that a motor that rests goes on resting.
        """
        if self._acting or not self.running:
            return
        if not changing and self._up_to_date():
            return
        while self._block is None or self._block.end <= self.due:
            if self._block is not None:
                self._finish()
            elif self._asleep:
                self._rest(max(0, self.due - self.i[s.SAMPLE]))
                break
            elif self.due <= self.i[s.SAMPLE]:
                break
            else:
                self._block = self._compute(self.due - self.i[s.SAMPLE])
        self._take_part()
        self.replan()

    def _up_to_date(self) -> bool:
        """Whether the state is that of the last sample, without giving up what is planned."""
        missing = self.due - self.i[s.SAMPLE]
        if self._asleep:
            self._rest(missing)
            return True
        return missing == 0 and (self._block is None or self._block.end > self.due)

    def replan(self) -> None:
        """Something has been changed: what comes next is worked out when everything is done that happens now."""
        if not self._deferred and self.running:
            self._deferred = True
            self._plan += 1
            self.clock.call_later(0, self._look_ahead)

    def speed(self) -> float:
        """Return the shaft's speed in counts per sample, over the last sample; with PIDn, over the last n."""
        done, block, rate = self.due - self.i[s.SAMPLE], self._block, self.i[s.PID_RATE]
        ahead = block is not None and not block.resting and done > 0
        computed = min(done, block.samples) if block is not None and ahead else 0
        return sum(self._moves_by(computed)[-rate:]) / rate

    def _moves_by(self, computed: int) -> list[int]:
        """Return the counts moved in each of the last samples, by this one of those computed ahead."""
        shaft, first = self._engine.shaft, max(computed - PID_MOST, 0)
        before = shaft[first - 1] if first else self.i[s.SHAFT] + self.i[s.SLIPPED]
        places = [before, *shaft[first:computed]]
        return [*self._moves, *(after - before for before, after in pairwise(places))][-PID_MOST:]

    def stop(self) -> None:
        """No more samples."""
        self.catch_up()
        self._tell_changes()
        self.running = False
        self._plan += 1

    # Who follows what

    def follow(self, numbers: Sequence[tuple[int, int]], follower: Follower, *, restless: bool = False) -> None:
        """From now on tell one follower of each change of these numbers, an operation and a place each (`log.py`).

        Of those that were followed before, changes that have not been told yet will be.  `restless`: there are some
        among them that change while the motor rests, so it must not.
        """
        if self.running:
            self.catch_up()
        self.log = log.following(numbers, self.i, self.v, log.known(self.log))
        self._look_at = log.Look(self.log)
        self._follower, self._restless = follower, restless

    def unfollow(self) -> None:
        """Nobody follows anything any more."""
        if self.running:
            self.catch_up()
        self.log, self._follower, self._restless = log.empty(), None, False

    def _tell_changes(self) -> None:
        """Tell what Python has changed, at its time."""
        if self._follower is not None:
            which, values = self._look_at.changed(self.i, self.v, self.log)
            if which:
                self._follower([self.clock.now] * len(which), which, values)

    def tell(self, done: "array[int]") -> None:
        """A block with this log is the truth: tell what the kernel has changed."""
        if self._follower is not None:
            self.log[log.head(done)] = done[log.head(done)]
            samples, which, values = log.changes(done)
            if samples:
                import numpy as np  # late: only for who follows

                times = self.zero_ns + SAMPLE_NS * np.frombuffer(samples, np.int64)
                self._follower(array("q", times.tobytes()), which, values)

    # Blocks

    def _look_ahead(self) -> None:
        """Compute the next block and come back at its end."""
        self._deferred = False
        if not self.running:
            return
        self._take_part()
        self._tell_changes()
        self._plan += 1
        most = min(self._most, self._engine.longest)
        if self.one_by_one is not None:
            self.one_by_one()
            most = 1
        self._block = self._compute(most)
        self._come_back()

    def _come_back(self) -> None:
        plan, block = self._plan, self._block
        assert block is not None
        background = self.i[s.PROGRAM] != s.RUNNING and not self.i[s.BT] and block.why == ALL_DONE
        self.clock.background += background

        def at_its_end() -> None:
            self.clock.background -= background
            if plan == self._plan:
                self._finish()
                self._go_on(block)

        self.clock.call_later(self.time_ns(block.end) - self.clock.now, at_its_end)

    def _go_on(self, block: _Block) -> None:
        """A block is over; after a quiet one nothing may ever happen again by itself."""
        if not self.running:
            return
        self._plan += 1
        self._tell_changes()
        if block.why == ALL_DONE and block.samples > self.i[s.DEBOUNCE] and self._rests():
            waits = self.i[s.WAIT_UNTIL] - 1 - self.i[s.SAMPLE] if self.i[s.PROGRAM] == s.RUNNING else 0
            if waits > 0:
                self._block = _Block(self.i[s.SAMPLE], waits, resting=True)
                self._come_back()
            else:
                self._asleep = True
                self._engine.forget()
        elif not self._deferred:
            self._look_ahead()

    def _rests(self) -> bool:
        """Whether nothing happens any more but that a WAIT ends."""
        if self._restless:
            return False
        i = self.i
        program = i[s.PROGRAM] != s.RUNNING or i[s.SAMPLE] + 1 < i[s.WAIT_UNTIL]
        quiet = not i[s.BT] and not i[s.PENDING] and not i[s.MASTER_LEFT] and i[s.MODE] < s.M_FOLLOW
        return program and quiet and bool(resting(i, self.f))

    def _compute(self, most: int) -> _Block:
        first = self.i[s.SAMPLE]
        if self.foretell is not None and self.i[s.TOLD] < most:
            self._engine.told = array("q", self.foretell(first + 1, most))
            self.i[s.TOLD], self.i[s.TOLD_AT] = most, 0
        why, samples = self._engine.run(most)
        return _Block(first, samples, why)

    def _finish(self) -> None:
        """The block's end has come: its result is the truth, and Python does what the kernel has stopped for."""
        block, self._block = self._block, None
        assert block is not None
        if block.resting:
            self._rest(block.samples)
            return
        self._commit(block)
        self._most = min(2 * self._most, LONGEST)
        if block.why:
            self._acting = True
            self._act(block.why)
            self._acting = False

    def _take_part(self) -> None:
        """Of the block that has been computed, only what lies before now."""
        block, self._block = self._block, None
        self._asleep = False
        if block is None:
            return
        samples = self.due - block.first
        if block.resting:
            self._rest(samples)
            return
        self._most = min(max(2 * samples, SHORTEST), LONGEST)
        if samples > 0:
            self._commit(self._compute(samples))

    def _commit(self, block: _Block) -> None:
        self._moves = self._moves_by(block.samples)
        self._engine.commit(block)

    def _rest(self, samples: int) -> None:
        self._moves = [*self._moves, *[0] * min(samples, PID_MOST)][-PID_MOST:]
        rest(self.i, self.f, samples)


class _Engine:
    """Runs the kernel on copies of the truth: plain Python at first, compiled when that pays.

    Where the shaft is in each sample of a block is kept in arrays that grow with the blocks.
    """

    plain_samples: ClassVar[int] = 0
    """How many have been done in plain Python so far; nothing that a motor could notice."""
    compiled: ClassVar[Callable[..., int] | None] = None

    def __init__(self, core: Core) -> None:
        self._core = core
        self.shaft, self.commanded = array("q"), array("q")
        self._stack = array("q", bytes(8 * STACK))
        self._code, self._log, self._followed = core.code, core.log, core.log
        self._copies: tuple[Any, ...] = ()
        self._views: tuple[Any, ...] = ()
        self.told = array("q", [0])
        """The external encoder's edges in the samples to come, where they are known."""
        self._told = self.told

    @property
    def longest(self) -> int:
        """A block of more samples would keep a host waiting who interrupts it."""
        return LONGEST if self._compiled() else LONGEST_PLAIN

    def run(self, most: int) -> tuple[int, int]:
        """Do up to `most` samples from the truth on; returns why it stopped and how many were done."""
        core = self._core
        self._make_room(most)
        if compiled := self._compiled():
            self._renew_views()
            i, v, f, ring = self._copies
            i[:], v[:], f[:], ring[:] = core.i, core.v, core.f, core.ring
            why = compiled(*self._views, most)
        else:
            i, v, f, ring = self._copies = core.i[:], core.v[:], core.f[:], core.ring[:]
            why = advance(i, v, f, self._stack, core.code, ring, self.told, self.shaft, self.commanded, self._log, most)
            _Engine.plain_samples += i[s.SAMPLE] - core.i[s.SAMPLE]
        return why, i[s.SAMPLE] - core.i[s.SAMPLE]

    def _compiled(self) -> Callable[..., int] | None:
        """Compiled code if there is any, or if it pays to make it; not while somebody cannot wait for that."""
        if _Engine.compiled is None:
            enough = _Engine.plain_samples >= PLAIN_SAMPLES and self._core.clock.patient
            if (enough or jit.setting() == "on") and jit.available():
                _Engine.compiled = jit.best(advance)
        return _Engine.compiled

    def commit(self, block: _Block) -> None:
        """What was computed last is the truth."""
        core = self._core
        i, v, f, ring = self._copies
        core.i[:], core.v[:], core.f[:], core.ring[:] = i, v, f, ring
        core.tell(self._log)
        if block.samples:
            for listener in core.listeners:
                listener(block.first + 1, self.shaft[: block.samples], self.commanded[: block.samples])

    def forget(self) -> None:
        """Nothing is computed for the time being, so nothing is needed for it."""
        self.shaft, self.commanded, self._copies, self._views = array("q"), array("q"), (), ()

    def _make_room(self, most: int) -> None:
        """For so many samples, and for what somebody follows."""
        log_of = self._core.log
        if most > len(self.shaft):
            room = 8 * max(SHORTEST, 1 << (most - 1).bit_length())
            self.shaft, self.commanded, self._views = array("q", bytes(room)), array("q", bytes(room)), ()
        if self._followed is not log_of:
            self._followed, self._log, self._views = log_of, log_of[:], ()
        self._log[log.head(log_of)] = log_of[log.head(log_of)]

    def _renew_views(self) -> None:
        """NumPy's views of the arrays; new ones when a program has been loaded."""
        core = self._core
        if self._views and self._code is core.code and self._told is self.told:
            return
        import numpy as np  # late: only when something moves for long

        self._code, self._told = core.code, self.told
        self._copies = core.i[:], core.v[:], core.f[:], core.ring[:]
        i, v, f, ring = (np.frombuffer(copy, copy.typecode) for copy in self._copies)
        others = self._stack, self._code, self.told, self.shaft, self.commanded, self._log
        stack, code, told, shaft, commanded, noted = (np.frombuffer(numbers, "q") for numbers in others)
        self._views = i, v, f, stack, code, ring, told, shaft, commanded, noted


def prepare(speed: float | None, motors: int) -> None:
    """Compile now, or fetch what is kept, if plain Python could not keep pace with so many motors."""
    if (speed is None or speed * motors > PLAIN_MOTORS) and jit.available():
        _Engine.plain_samples = max(_Engine.plain_samples, PLAIN_SAMPLES)
        _Engine(Core(Clock(), lambda why: None, 1)).run(0)
