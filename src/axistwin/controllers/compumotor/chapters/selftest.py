"""Chapters Functional check and test switch: command FFh and switch S1."""

from fractions import Fraction

from axistwin.controllers.compumotor.parts.pulses import Phase, VelocityProfile
from axistwin.controllers.compumotor.state import State
from axistwin.sim.clock import Procedure
from axistwin.sim.motion.profile import Segment

PULSES = 25_000
RATE = Fraction(5_000)
WIDTH = Fraction(3, 2_000_000)  # Width of a STEP pulse in seconds: "a one to two microsecond, high going, pulse".
ONE_TURN = VelocityProfile(((Phase.CONSTANT, (Segment(RATE, PULSES / RATE),)),), 1 / (2 * WIDTH))


def test_switch(board: State) -> None:
    """Command FFh: stop all commands and perform the test function; only a reset ends it."""
    board.begin_test()


def test(board: State) -> Procedure:
    """Turn the motor one revolution CCW, then CW, at 5,000 Hz without ramps; then raise the board monitor alarm.

    A limit prevents the revolution in its direction: JU5 and JU6 must be installed if there are no switches.
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
