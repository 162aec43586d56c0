"""X-Y tables: the drawing from above with trail and tool, and the 3-D drawing."""

from fractions import Fraction

import pytest
from nicegui.elements.scene import Scene

from axistwin.sim.motion.profile import Profile, Segment
from axistwin.ui.drawings.table import PIECE, PIECES
from axistwin.ui.panel.views.machines import machines
from axistwin.ui.panel.views.table import tool_choice

from .showing import bench_of, show, shown

TRAVEL = {"limits": (0, 2000)}
TABLE = bench_of("if2", X=TRAVEL, Y=TRAVEL)


def at(context):
    tool_choice(context, "if2")
    return machines(context, "if2")


def top(visit):
    return visit.found("table if2").drawing.shown


def go(visit, **pulses):
    for axis, number in pulses.items():
        profile = Profile([Segment(Fraction(1000), Fraction(abs(number), 1000))])
        visit.bench["if2"].axes[axis].start(profile, 1 if number > 0 else -1)
    visit.run(2.5)


def pixels(shown, part):
    return [float(word.strip(" px)")) for word in shown[part, "move"].partition("(")[2].split(",")]


def corners(shown):
    """Return all points of the trail, from the elements of its drawing."""
    lines = [shown.get((f"trail{piece}", "points"), "") for piece in range(PIECES)]
    return [tuple(float(number) for number in corner.split(",")) for line in lines for corner in line.split()]


@shown(at, build=TABLE)
def test_the_tool_goes_right_with_x_and_up_with_y(visit):
    x, y = pixels(top(visit), "head")
    go(visit, X=2000)
    right, same = pixels(top(visit), "head")
    assert (right > x, same) == (True, y)
    go(visit, Y=1000)
    assert pixels(top(visit), "head")[1] == pytest.approx(y - (right - x) / 2, abs=0.02)
    assert pixels(top(visit), "bridge")[0] == right


@shown(at, build=TABLE)
def test_its_trail_has_the_corners_of_its_way(visit):
    x, y = pixels(top(visit), "head")
    go(visit, X=2000)
    go(visit, Y=2000)
    right, upper = pixels(top(visit), "head")
    expected = [(x, y), (right, y), (right, upper)]
    assert corners(top(visit)) == [pytest.approx(corner, abs=0.06) for corner in expected]


@shown(at, build=TABLE)
def test_a_long_trail_is_drawn_in_pieces_of_which_only_the_last_changes(visit):
    for number in range(PIECE + 10):
        go(visit, **{"XY"[number % 2]: 10})
    first = top(visit)["trail0", "points"]
    assert len(first.split()) == PIECE + 1 and top(visit)["trail1", "points"].split()[0] == first.split()[-1]
    go(visit, X=10)
    assert top(visit)["trail0", "points"] == first
    assert len(corners(top(visit))) == PIECE + 10 + 1 + 1 + 1  # adjacent elements share a corner


@shown(at, build=TABLE)
def test_the_tool_is_down_while_its_output_is_high_and_leaves_a_mark(visit):
    output = visit.bench["if2"].pins["output1"]
    assert (top(visit)["head", ".down"], top(visit)["tool", "text"]) == (False, "Output 1 off")
    output.set(True)
    visit.run(0.1)
    assert (top(visit)["head", ".down"], top(visit)["tool", "text"]) == (True, "Output 1 on")
    assert top(visit)["places", "d"].count("M") == 1
    output.set(False)
    go(visit, X=100)
    assert not top(visit)["head", ".down"] and top(visit)["places", "d"].count("M") == 1
    visit.bench["if2"].power(False)
    go(visit, Y=100)
    assert (top(visit)["places", "d"], top(visit)["earlier", "d"].count("M")) == ("", 1)


@shown(at, build=TABLE)
def test_another_output_may_be_the_tool_or_none_and_the_person_keeps_it(visit):
    visit.choose("if2 tool", "output3")
    visit.bench["if2"].pins["output3"].set(True)
    visit.run(0.1)
    assert top(visit)["tool", "text"] == "Output 3 on" and visit.context.person.settings["if2 tool"] == "output3"
    visit.choose("if2 tool", "")
    visit.frame()
    assert (top(visit)["head", ".down"], top(visit)["tool", "text"]) == (False, "")


def scenes(visit):
    return [element for element in visit.user.client.elements.values() if isinstance(element, Scene)]


@shown(at, build=TABLE)
def test_three_dimensions_are_there_while_one_wants_them(visit):
    assert not scenes(visit)
    visit.choose("if2 view", "solid")
    assert visit.context.person.settings["if2 view"] == "solid"
    (scene,) = scenes(visit)
    go(visit, X=1000)
    before = [(thing.x, thing.y, thing.z) for thing in scene.objects.values()]
    visit.bench["if2"].pins["output1"].set(True)
    visit.run(0.1)
    after = [(thing.x, thing.y, thing.z) for thing in scene.objects.values()]
    lower = [then for now, then in zip(before, after, strict=False) if now != then]
    assert lower == [(0, 0, pytest.approx(-0.35))]
    assert [thing.name for thing in scene.objects.values()].count("hole") == 1
    visit.press("turn left")
    visit.choose("if2 view", "top")
    assert not scenes(visit)


def test_whoever_wanted_three_dimensions_finds_them_again():
    def wanting(context):
        context.person.settings["if2 view"] = "solid"
        return at(context)

    show(TABLE, wanting, lambda visit: visit.user.find(kind=Scene))


@shown(at, "if2", X=TRAVEL)
def test_one_axis_with_travel_makes_no_table(visit):
    with pytest.raises(AssertionError, match="table"):
        visit.found("table if2")
