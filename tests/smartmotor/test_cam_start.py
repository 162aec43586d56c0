"""Section 9.3 and 9.4: mode cam that starts in the middle of a cycle, where the external counter already stands."""

import pytest

from .scenarios import TABLE, turn_to
from .talking import advance, ready, send, value


@pytest.mark.parametrize(
    ("option", "mc", "counts", "times"),
    [("master", "MC", 6000, 1), ("master", "MC2", 3000, 1), ("table", "MC", 6000, 1), ("table", "MC2", 6000, 2)],
)
def test_the_counter_says_where_in_the_cycle_the_cam_starts(bench, option, mc, counts, times):
    """9.3: CX is "the current index … as controlled by the external encoder value"; 9.4: relative to where it is.

    BASE is 8000 with 8 intervals, so 6000 counts are entry 6; with MC2 the counts are doubled, or the table is.
    """
    motor = ready(bench, cam_multiplier=option)
    send(bench, motor, "MF4", 0)
    turn_to(bench, motor, counts)
    send(bench, motor, f"BASE=8000 SIZE=8 D=0 F=16 aw[0] {' '.join(map(str, TABLE))}. O=100 {mc} G", 0)
    advance(bench, 2)
    assert value(bench, motor, "CX") == 6
    assert value(bench, motor, "@P") == 100 + times * TABLE[6]
