"""The panel of a shadow: a machine beside its twin, what differs, and that nothing can be acted on."""

from functools import partial

import pytest

from axistwin import Session
from axistwin.bench.acts import Say
from axistwin.ui.panel.comparison import Found
from axistwin.ui.panel.context import Common, Context, together
from axistwin.ui.panel.page import build_views
from axistwin.ui.panel.people import People

from .showing import bench_of, show_to

LATE, LIMIT = Found("12:04:08", "E is answered 40 ms later", "", False), Found("12:03:00", "limit, X+", "3 times", True)


class Compared:
    def __init__(self):
        self.state, self.differs, self.past, self.clock = "agrees since 12:00", False, False, "12:03:27"
        self.found, self.position, self.asked = [], None, []

    def beside(self, axis):
        return self.position if axis == "X" else None

    def go_back(self, found):
        self.asked.append(found)
        self.past = found is LATE
        return self.past

    def go_on(self):
        self.past = False


def shown(play, **options):
    """Show the whole page of a shadow to a visitor."""

    def run():
        compared, people = Compared(), People()
        session = Session(bench_of("if1", **options), None)
        context = Context(Common(session, compared), people, people["somebody"])
        show_to(context, lambda context: together(*build_views(context)), lambda visit: play(visit, compared))

    return run


@shown
def test_the_list_of_findings_follows_and_leads_to_their_moments(visit, compared):
    visit.frame()
    assert visit.found("state").text == "Shadow: agrees since 12:00"
    with pytest.raises(AssertionError):
        visit.found("now")  # it is hidden
    compared.found, compared.differs = [LATE, LIMIT], True
    visit.frame()
    assert [visit.found(f"found-{n}").text for n in (0, 1)] == [
        "12:04:08 E is answered 40 ms later",
        "12:03:00 limit, X+",
    ]
    compared.found[1] = LIMIT._replace(times="4 times")
    visit.frame()
    visit.user.find("4 times")
    visit.press("found-0")
    assert compared.asked == [LATE]
    visit.press("now")
    visit.press("found-1")
    assert not compared.past and visit.messages == ["what led to 12:03:00 is no longer kept"]


@shown
def test_the_machine_is_a_pale_copy_beside_its_twin(visit, compared):
    picture = visit.found("axis if1.X").drawing
    visit.frame()
    assert not picture.shown["pale", ".there"]
    compared.position = 100  # of 400 a turn
    visit.frame()
    assert picture.shown["pale", ".there"] and picture.shown["pale", "move"] == "rotate(90.0deg)"


@partial(shown, X={"limits": [0, 1000]}, Y={"limits": [0, 1000]})
def test_the_machines_head_is_a_pale_copy_on_an_x_y_table(visit, compared):
    head = visit.found("table if1").drawing
    compared.position = 1000
    visit.frame()
    assert head.shown["pale", ".there"] and head.shown["pale", "move"] != head.shown["head", "move"]


@shown
def test_nothing_can_be_acted_on(visit, compared):
    visit.frame()
    visit.choose("say-if1", "E")
    visit.trigger("say-if1", "keydown.enter")
    visit.context.touch(lambda: visit.context.session.do("if1", "estop", "low"))
    assert visit.messages == ["this page only shows: neither the twin nor the machine can be acted on"] * 2
    assert not [act for moment in visit.context.session.journal for act in moment.acts if isinstance(act, Say)]
    assert visit.bench["if1"].pins["estop"].level
