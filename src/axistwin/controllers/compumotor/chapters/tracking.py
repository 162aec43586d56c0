"""The position tracking addendum: an encoder's count, moves in its pulses, stalls, and a position that is maintained.

closed-loop move: encoder pulses x ratio (B0h) ──> a preset move in motor pulses
at rest:    every 2 ms, error = desired - count ──> K·e, K·√e or K·e² (B3h), while position maintenance (18h) is on
in motion:  every 2 ms, by how many rotor teeth do pulses and counts differ?  One or more: a stall

Nothing is looked at while there is neither motion to watch nor an error to correct.
"""

from dataclasses import dataclass
from math import isqrt
from typing import TYPE_CHECKING

from axistwin.controllers.compumotor.chapters import moves
from axistwin.controllers.compumotor.chapters.events import Happening
from axistwin.controllers.compumotor.chapters.moves import Kind, Move
from axistwin.controllers.compumotor.chapters.profiles import Speed, preset
from axistwin.controllers.compumotor.chapters.pulses import Phase, VelocityProfile
from axistwin.controllers.compumotor.chapters.ranges import VELOCITY_RANGES
from axistwin.controllers.compumotor.chapters.stop import kill_motion
from axistwin.controllers.product import PulseAxis
from axistwin.motion.profile import Segment
from axistwin.sim.clock import Procedure
from axistwin.units import MS

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board

UPDATE_NS = 2 * MS
FARTHEST = 0x7FFF_FFFF
"""Motor pulses of a closed-loop move."""
IN_DEADBAND = 0x80


def wrapped(count: int) -> int:
    """A count as a 32-bit up/down counter has it."""
    return (count + 0x8000_0000) % (1 << 32) - 0x8000_0000


@dataclass(frozen=True)
class Law:
    """How to correct an error: B3h.  `maximum` in units of the velocity range in the upper nibble of `ranges`."""

    algorithm: int
    gain: int
    ranges: int
    maximum: int

    @property
    def acts(self) -> bool:
        """Whether it ever asks for a velocity."""
        return bool(self.gain and self.maximum)

    def velocity_profile(self, error: int) -> VelocityProfile:
        """On and on at the velocity for an error; never below the lowest one there is, lest the error stay."""
        e = abs(error)
        wish = {1: self.gain * e, 2: isqrt(self.gain**2 * e), 3: self.gain * e**2}[self.algorithm]
        velocities = VELOCITY_RANGES[self.ranges >> 4]
        rate = velocities.rate(min(wish, self.maximum)) or velocities.resolution
        return VelocityProfile(((Phase.CONSTANT, (Segment(rate, None),)),), velocities.maximum, of_move=False)


class Encoder:
    """The counter of quadrature edges; 14h says which direction is + for it as well.

    Without an encoder, and on an 1810, it stays at 0.
    """

    def __init__(self, axis: PulseAxis | None, inverted: bool) -> None:
        self._axis, self._wired = axis, (-1 if inverted else +1)
        self._sense, self._origin = self._wired, 0
        self._origin = -self.count

    @property
    def count(self) -> int:
        """Encoder pulses since reset."""
        seen = self._axis.encoder_count if self._axis else None
        return self._origin + self._sense * (seen or 0)

    def face(self, sense: int) -> None:
        """+1: CW is +.  The count stays."""
        before, self._sense = self.count, sense * self._wired
        self._origin += before - self.count


class ClosedLoop:
    """What the board knows of the encoder, and does about it."""

    def __init__(self, board: "Board", axis: PulseAxis | None, *, moves: bool) -> None:
        """`axis` None: the board has no encoder.  `moves`: it performs closed-loop moves all the same."""
        self._board, self._axis, self._moves = board, axis, moves
        self.encoder = Encoder(axis, board.options.invert_encoder)
        # Parameters
        self.ratio: tuple[int, int] | None = None
        self.resolution: int | None = None
        self.sigma: int | None = None
        self.teeth: int | None = None
        self.law: Law | None = None
        self.deadband: int | None = None
        self.on = False
        """Position maintenance, 18h."""
        self.ends_stalled_moves = False
        """19h."""
        # Positions, in encoder pulses since reset
        self.zero = self.desired = 0
        self.commanded: tuple[Move, int] | None = None
        """The closed-loop move that was asked for last, and where it was to end."""
        # The present or most recent move
        self._began, self._ended = (0, 0), 0
        self._at_rest = True
        self._closed = self._stalled = self._lent = self._held = False
        self._correction: VelocityProfile | None = None
        self._ticking = False
        if axis is not None:
            self._unsubscribe = axis.on_push.subscribe(self._pushed)

    def close(self) -> None:
        """The power is gone."""
        if self._axis is not None:
            self._unsubscribe()

    # What is known

    @property
    def absolute(self) -> int:
        """Encoder pulses from absolute zero."""
        return wrapped(self.encoder.count - self.zero)

    @property
    def relative(self) -> int:
        """Encoder pulses since zero velocity was left, or of the last move."""
        return wrapped((self._ended if self._at_rest else self.encoder.count) - self._began[1])

    @property
    def error(self) -> int:
        """Encoder pulses from here to the desired position."""
        return wrapped(self.desired - self.encoder.count)

    @property
    def in_deadband(self) -> bool:
        """Whether the error is within the deadband, if there is one (B5h)."""
        return self.deadband is not None and abs(self.error) <= self.deadband

    def slipped(self, pulses: int, counts: int) -> int:
        """How many rotor teeth so many motor pulses and encoder pulses differ by, beyond the backlash."""
        if self.ratio is None or not (self.resolution and self.teeth):
            return 0
        motor, encoder = self.ratio
        beyond = abs(pulses * encoder - counts * motor) - (self.sigma or 0) * encoder
        return max(0, beyond * self.teeth // (self.resolution * encoder))

    @property
    def watches(self) -> bool:
        """Whether all is known that a stall is seen by."""
        return self.ratio is not None and self.sigma is not None and bool(self.resolution and self.teeth)

    @property
    def complete(self) -> bool:
        """Whether B0h to B4h have been given, all five."""
        given = (self.ratio, self.resolution, self.sigma, self.law, self.teeth)
        return None not in given

    # Motion, as the pulse generator tells of it

    @property
    def owns_course(self) -> bool:
        """Whether the present or most recent velocity profile is a correction."""
        return self._board.pulses.velocity_profile is self._correction

    @property
    def correcting(self) -> bool:
        """Whether the motor moves because of an error."""
        return self._board.pulses.moving and self.owns_course

    def phase_changed(self, phase: Phase) -> None:
        """The pulse generator has entered a phase."""
        if self.owns_course:
            return
        if phase is not Phase.REST:
            self.left_zero()
        elif not self._at_rest:
            self.came_to_rest()
        self.wake()

    def left_zero(self) -> None:
        """Zero velocity has been left, unless it had been before."""
        if self._at_rest:
            self._at_rest = self._stalled = False
            self._began = self._board.pulses.position, self.encoder.count

    def came_to_rest(self) -> None:
        """The place is the desired one now, unless a closed-loop move was to end elsewhere."""
        self._watch()
        self._ended, self._at_rest = self.encoder.count, True
        whole = self._board.pulses.position == self._board.motion.end
        if not (self._closed and (whole or (self._stalled and not self.on))):
            self.desired = self._ended
        self._closed = False

    def look(self) -> None:
        """Something may have changed: the joystick may have come or gone."""
        lent, self._lent = self._lent, self._board.joystick.enabled
        if lent and not self._lent:
            self._at_rest = False
            self.came_to_rest()
        self.wake()

    def _pushed(self) -> None:
        self._board.outputs.refresh()
        self.wake()

    # Every 2 ms, when there is something to do

    def wake(self) -> None:
        """Look again in 2 ms, if there is anything to look at."""
        if not self._ticking and self._board.alive and self._busy():
            self._ticking = True
            self._board.clock.call_later(UPDATE_NS, self._tick)

    def _busy(self) -> bool:
        board = self._board
        if self.ratio is None:  # then nothing can be tracked
            return board.outputs.shows(IN_DEADBAND) and board.moving
        if board.moving and not self.correcting:
            return self.watches or board.outputs.shows(IN_DEADBAND)
        return self.correcting or (self._wants_to_correct() and self.error != 0)

    def _tick(self) -> None:
        self._ticking = False
        if self._board.alive:
            self._watch()
            self._maintain()
            self._board.outputs.refresh()
            self.wake()

    def _watch(self) -> None:
        """A stall is seen once in a move."""
        if self._at_rest or self._stalled or not self.watches:
            return
        board, (pulses, counts) = self._board, self._began
        if self.slipped(board.pulses.position - pulses, self.encoder.count - counts):
            self._stalled = True
            board.events.happened(Happening.STALL, board.motion.begun)
            if self.ends_stalled_moves:
                kill_motion(board)

    # Position maintenance

    def _wants_to_correct(self) -> bool:
        return self.on and self.ratio is not None and self.law is not None and self.law.acts

    def _may_correct(self) -> bool:
        board = self._board
        occupied = self._held or (board.occupied and not self.correcting)
        return self._wants_to_correct() and not (occupied or board.shut_down or board.streaming)

    def _maintain(self) -> None:
        error, board = self.error, self._board
        sign = 1 if error > 0 else -1
        if not error or not self._may_correct() or board.limits.blocks(sign):
            self.give_way()
            return
        assert self.law is not None
        velocity_profile, pulses = self.law.velocity_profile(error), board.pulses
        if self.correcting and sign == pulses.sign and velocity_profile == pulses.velocity_profile:
            return
        if self.correcting and sign != pulses.sign:
            self.give_way()
        self._correction = velocity_profile
        pulses.run(velocity_profile, sign, further=True)

    def hold(self, on: bool) -> None:
        """No correction while a search is going on, even between its motions."""
        self._held = on
        self.give_way()

    def give_way(self) -> None:
        """No correction at this moment: all is well, or a move begins."""
        if self.correcting:
            self._board.pulses.kill()

    # Moves

    def perform(self, move: Move, speed: Speed) -> Procedure:
        """Perform a closed-loop move.  Ignored without ratio, if it is too far, or at a limit in that direction."""
        board = self._board
        if self.ratio is None or not self._moves:
            return
        relative = move.kind is Kind.RELATIVE_ENCODER
        counts = move.target if relative else move.target - self.absolute
        target = counts + (self.desired if relative else self.encoder.count)
        pulses = _to_pulses(counts, self.ratio, move.target)
        sign = 1 if pulses > 0 else -1
        if abs(pulses) > FARTHEST or (pulses and (not speed.rate or board.blocked(sign))):
            return
        self.desired, self.commanded = target, (move, target)
        if pulses:
            self._closed = True
            end = board.pulses.position + pulses
            yield from moves.excursion(board, move, speed, sign, preset(speed, abs(pulses)), end)
        self.wake()

    def define(self, position: int) -> None:
        """Here is this absolute position, and where the motor is to be."""
        self.desired = self.encoder.count
        self.zero = self.desired - position


def _to_pulses(counts: int, ratio: tuple[int, int], side: int) -> int:
    """Encoder pulses in motor pulses, to the nearest; a half goes to the + or - side, as the sign of `side` says.

    With the target of an absolute move as `side` it stops at the same place, from whichever side it comes.
    """
    motor, encoder = ratio
    upwards = +1 if side >= 0 else -1
    return upwards * ((2 * upwards * counts * motor + encoder) // (2 * encoder))
