"""Chapters Functional check and test switch: command FFh and switch S1."""

from fractions import Fraction
from typing import TYPE_CHECKING

from axistwin.controllers.compumotor.chapters.pulses import Phase, VelocityProfile
from axistwin.motion.profile import Segment
from axistwin.sim.clock import Procedure

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board

PULSES = 25_000
RATE = Fraction(5_000)
WIDTH = Fraction(3, 2_000_000)
"""Seconds that STEP is high: "a one to two microsecond, high going, pulse"."""
ONE_TURN = VelocityProfile(((Phase.CONSTANT, (Segment(RATE, PULSES / RATE),)),), 1 / (2 * WIDTH))


def test_switch(board: "Board") -> None:
    """Command FFh: drop everything and perform the test; the board must be reset after it."""
    board.begin_test()


def test(board: "Board") -> Procedure:
    """One revolution of 25,000 pulses CCW at 5,000 Hz without a ramp, one CW; then the board monitor alarm.

    A limit prevents the one in its direction: JU5 and JU6 must be installed if there are no switches.
    """
    board.pulses.kill()
    for cw in (False, True):
        sign = +1 if cw is board.pulses.cw_is_plus else -1
        if board.limits.blocks(sign):
            continue
        board.pulses.start(ONE_TURN, sign)
        while board.pulses.moving:
            yield board.pulses.changed()
    board.fail()
