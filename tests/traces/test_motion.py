"""The motion of two machines, side by side: `axistwin diff --positions`."""

import json

import pytest

from axistwin.core.errors import UsageError
from axistwin.core.units import MS, S
from axistwin.records.traces.differences import Tolerance
from axistwin.records.traces.motion import compare_motion
from axistwin.records.traces.reading import read

from ..command import refused, run

RAMP = ((0, 1), (10, 2), (20, 3), (30, 4))  # Times in ms and positions of a move.
BACK = ((0, 3), (10, 2), (20, 1), (30, 0))


def written(path, *moves, axis="if1.X", end_ms=1000, units="", signal="pulses", also=""):
    """Write a trace of moves, each its begin in ms and its positions, and return its path."""
    lines = ["# axistwin: 0", f"# signal: {axis}.{signal} integer", *([f"# units {axis}: {units}"] if units else [])]
    lines += ["time_ns,signal,value", f"0,{axis}.{signal},0"]
    lines += [f"{(begin + ms) * MS},{axis}.{signal},{value}" for begin, move in moves for ms, value in move]
    path.write_text("\n".join([*lines, *filter(None, [also]), f"# end_ns: {end_ms * MS}", ""]), encoding="utf-8")
    return path


@pytest.fixture
def old(tmp_path):
    return written(tmp_path / "old.csv", (100, RAMP), (500, BACK))


def new(tmp_path, *moves, **options):
    return written(tmp_path / "new.csv", *moves, **{"axis": "module.0", **options})


def test_hosts_may_pause_differently_if_moves_are_aligned(tmp_path, old):
    other = new(tmp_path, (50, RAMP), (800, BACK))
    told = run("diff", old, other, "--positions", "--align", "move")
    assert (told.code, told.err) == (0, "")
    assert told.out == (
        "move  axes              begins at s          takes s              ends at  apart\n"
        "1     if1.X | module.0  0.100000 | 0.050000  0.030000 | 0.030000  4 | 4    0\n"
        "2     if1.X | module.0  0.500000 | 0.800000  0.030000 | 0.030000  0 | 0    0\n"
        "the same motion: paths at most 0 pulses apart, durations at most 0.000000 s, with 0 pulses and 0 s accepted\n"
    )
    told = run("diff", old, other, "--positions")
    assert told.code == 1
    assert told.out == (
        "axes              ends at  apart\n"
        "if1.X | module.0  0 | 0    4 differs\n"
        "not the same motion: paths at most 4 pulses apart, with 0 pulses and 0 s accepted; if the hosts pause "
        "differently, add --align move\n"
    )


@pytest.mark.parametrize(("move", "within", "late_ms", "code"), [
    (((0, 1), (10, 2), (20, 3), (30, 5)), 0, 0, 1),        # ends one pulse farther
    (((0, 1), (10, 2), (20, 3), (30, 5)), 1, 0, 0),
    (((0, 1), (10, 4), (20, 3), (30, 4)), 1, 0, 1),        # two pulses off its way
    (((0, 1), (10, 4), (20, 3), (30, 4)), 2, 0, 0),
    (((0, 1), (13, 2), (20, 3), (30, 4)), 0, 2, 1),        # a pulse 3 ms late
    (((0, 1), (13, 2), (20, 3), (30, 4)), 0, 3, 0),
    (((0, 1), (13, 2), (20, 3), (30, 4)), 1, 0, 0),        # or within one pulse at any time
    (((0, 1), (10, 2), (20, 3), (36, 4)), 1, 5, 1),        # takes 6 ms longer
    (((0, 1), (10, 2), (20, 3), (36, 4)), 1, 6, 0)])  # fmt: skip
def test_what_is_within_the_tolerances(tmp_path, old, move, within, late_ms, code):
    other = new(tmp_path, (200, move), (700, BACK))
    options = ("--within", within, "--time", late_ms / 1000, "--align", "move")
    assert run("diff", old, other, "--positions", *options).code == code


def test_the_largest_distance_is_found_with_its_time(tmp_path, old):
    other = new(tmp_path, (200, RAMP), (700, ((0, 3), (10, 2), (20, 9), (30, 0))))
    found = compare_motion(read(old), read(other), 0, by_move=True)
    (leg,) = found.broken(Tolerance(2.0))
    assert (leg.move, leg.apart, leg.apart_ns, leg.ends) == (2, 8.0, 520 * MS, (0.0, 0.0))
    assert not found.broken(Tolerance(8.0))


def test_a_move_more_is_a_difference(tmp_path, old):
    other = new(tmp_path, (200, RAMP), (500, BACK), (700, RAMP))
    code, out, _ = run("diff", old, other, "--positions", "--align", "move", "--within", 9)
    assert (code, out.splitlines()[-1]) == (1, "not the same motion: old.csv has 2 moves, new.csv 3")


def test_what_one_machine_does_after_the_end_of_the_other_trace_is_a_difference(tmp_path, old):
    other = new(tmp_path, (100, RAMP), (500, BACK), (1500, RAMP), end_ms=2000)
    assert run("diff", old, other, "--positions").out.splitlines()[1] == "if1.X | module.0  0 | 4    4 differs"


def test_positions_are_compared_in_the_units_of_the_scenes(tmp_path):
    old = written(tmp_path / "old.csv", (100, RAMP), units="80 per mm")
    fine = new(tmp_path, (100, [(ms, 10 * at) for ms, at in RAMP]), units="800 per mm")
    assert run("diff", old, fine, "--positions").out == (
        "axes              ends at        apart\n"
        "if1.X | module.0  0.050 | 0.050  0.000\n"
        "the same motion: paths at most 0.000 mm apart, with 0 mm and 0 s accepted\n"
    )
    coarse = new(tmp_path, (100, RAMP), units="40 per mm")  # twice as far
    assert run("diff", old, coarse, "--positions", "--within", 0.05).code == 0
    assert run("diff", old, coarse, "--positions", "--within", 0.04).code == 1
    assert refused("diff", old, new(tmp_path, (100, RAMP)), "--positions") == (2, (
        "axistwin: if1.X is in mm, module.0 in pulses: give both axes the same `units` in their scenes, or none\n"
    ))  # fmt: skip


def test_a_servo_that_rests_does_not_move(tmp_path):
    """It is off by a count now and then; a move is one of its commanded position, and lasts until 100 ms of rest."""
    commanded = "\n".join(f"{ms * MS},motor.shaft.commanded,{at}" for ms, at in ((0, 0), (100, 5), (190, 9), (400, 0)))
    servo = {"axis": "motor.shaft", "signal": "position", "also": commanded}
    move = ((0, 5), (90, 9), (150, 8), (160, 9), (300, 0), (350, -1), (360, 0))
    trace = read(written(tmp_path / "a.csv", (101, move), **servo))
    found = compare_motion(trace, trace, 0, by_move=True)
    assert found.moves[0] == [(100 * MS, 190 * MS), (400 * MS, 400 * MS)]
    assert found.axes[0][0].unit == "counts"


def test_the_signal_velocity_says_when_an_axis_moves(tmp_path):
    rates = "".join(f"{ms * MS},if1.X.velocity,{rate}\n" for ms, rate in ((0, 0.0), (40, 100.0), (60, 5.0), (900, 0.0)))
    trace = read(written(tmp_path / "a.csv", (50, ((0, 1), (800, 2))), also=rates.strip()))
    assert compare_motion(trace, trace, 0, by_move=True).moves[0] == [(40 * MS, 900 * MS)]


def two_axes(path, first, second, **moves):
    lines = ["time_ns,signal,value"]
    lines += [f"0,{axis}.pulses,0" for axis in (first, second)]
    lines += [f"{ms * MS},{axis}.pulses,{at}" for axis, ms, at in moves["steps"]]
    path.write_text("\n".join([*lines, f"# end_ns: {S}", ""]), encoding="utf-8")
    return path


def test_axes_are_paired_by_name_by_order_or_as_said(tmp_path):
    old = two_axes(tmp_path / "old.csv", "if1.X", "if1.Y", steps=[("if1.Y", 5, 1), ("if1.X", 7, 1)])
    crossed = two_axes(tmp_path / "new.csv", "a.Y", "a.X", steps=[("a.Y", 5, 1), ("a.X", 7, 1)])
    numbered = two_axes(tmp_path / "numbers.csv", "m.0", "m.1", steps=[("m.0", 5, 1), ("m.1", 7, 1)])
    half = two_axes(tmp_path / "half.csv", "a.X", "a.Y", steps=[("a.X", 7, 1)])
    alone = new(tmp_path.joinpath("x").mkdir() or tmp_path / "x", (7, ((0, 1),)))

    def pairs(other, names=""):
        found = compare_motion(read(old), read(other), 0, names=names)
        return {(one.name, two.name) for one, two in found.axes}, len(found.broken(Tolerance()))

    assert pairs(crossed) == ({("if1.X", "a.X"), ("if1.Y", "a.Y")}, 0)
    assert pairs(half) == ({("if1.X", "a.X"), ("if1.Y", "a.Y")}, 1)  # Y does not move
    assert pairs(numbered) == ({("if1.X", "m.0"), ("if1.Y", "m.1")}, 2)
    assert pairs(numbered, "X=1, Y=m.0") == ({("if1.X", "m.1"), ("if1.Y", "m.0")}, 0)
    assert pairs(alone, "X=0") == ({("if1.X", "module.0")}, 0)
    with pytest.raises(UsageError, match=(
        r"^cannot pair the axes that move: if1.X, if1.Y in old.csv and module.0 in new.csv; name the pairs, "
        "e.g. --axes X=0,Y=1$"
    )):  # fmt: skip
        pairs(alone)


@pytest.mark.parametrize(("options", "message"), [
    (("--align", "move"), "--align is for positions: add --positions, e.g. --positions --align move"),
    (("--axes", "X=0"), "--axes is for positions: add --positions, e.g. --positions --axes X=0"),
    (("--positions", "--signals", "*"), "--signals does not go with --positions: choose axes, e.g. --axes X=X"),
    (("--positions", "--axes", "X"), "invalid pair of axes 'X': expected names with =, e.g. --axes X=0,Y=1"),
    (("--positions", "--axes", "Q=X"), "no axis 'Q' in old.csv: expected one of if1.X"),
    (("--positions", "--axes", "if1.Y=X"), "no axis 'if1.Y' in old.csv: did you mean if1.X?")])  # fmt: skip
def test_wrong_options_are_refused(old, options, message):
    assert refused("diff", old, old, *options) == (2, f"axistwin: {message}\n")


def test_traces_without_motion_are_refused(tmp_path):
    still = written(tmp_path / "still.csv")
    assert refused("diff", still, still, "--positions") == (2, (
        "axistwin: cannot pair the axes that move: no axis in still.csv and no axis in still.csv; "
        "name the pairs, e.g. --axes X=0,Y=1\n"
    ))  # fmt: skip
    for align in ("time", "move"):
        assert refused("diff", still, still, "--positions", "--align", align, "--axes", "X=X") == (
            2, "axistwin: nothing to compare: if1.X never moves in both traces\n"
        )  # fmt: skip


def test_the_comparison_as_json(tmp_path, old):
    other = new(tmp_path, (50, RAMP), (800, ((0, 3), (10, 2), (25, 1), (35, 0))))
    code, out, _ = run("diff", old, other, "--positions", "--align", "move", "--json", "--within", 0.5)
    told = json.loads(out)
    assert (code, told["equal"], told["moves"], len(told["legs"])) == (1, False, [2, 2], 2)
    assert told["legs"][1] == {
        "move": 2, "axes": ["if1.X", "module.0"], "unit": "pulses", "begin_ns": [500 * MS, 800 * MS],
        "lasted_ns": [30 * MS, 35 * MS], "ends": [0.0, 0.0], "apart": 1.0, "apart_ns": 520 * MS,
    }  # fmt: skip


def test_the_motion_is_drawn(tmp_path, old):
    other = new(tmp_path, (200, RAMP), (700, ((0, 3), (10, 2), (20, 9), (30, 0))))
    picture = tmp_path / "motion.svg"
    run("diff", old, other, "--positions", "--align", "move", "--plot", picture)
    for text in ("old.csv", "new.csv", "if1.X, module.0", "difference", "if1.X differs"):
        assert f">{text}<" in picture.read_text(encoding="utf-8"), text
