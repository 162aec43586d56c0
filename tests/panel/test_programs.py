"""Stored programs on the page: lines, the running line, breakpoints, loading, starting and stopping."""

import pytest
from nicegui import ui

from axistwin import Bench
from axistwin.bench import host_at
from axistwin.bench.programs import stored_programs
from axistwin.controllers.registry import OURS
from axistwin.ui.panel.views.program import program

from ..digiplan.talking import ready, send
from .showing import shown

SOURCE = b"a=1\nWAIT=4000\na=2\nC1\nWAIT=4000\nGOTO1\n"


def board():
    """Return a board with two sequences: one waits 1000 ms (29h), the other 3 s or 7 s (2Ah)."""
    bench = Bench()
    bench.add("1811", "board")
    bench.run(2)
    with host_at(bench, "board") as host:
        for number in (3, 7):
            for command in ((0xD9, number), (0x29, 0, 0, 0x03, 0xE8), (0x2A, 0, number), (0xD8,)):
                host.write(bytes(command))
        bench.run(1)
    return bench


def motor(source=SOURCE):
    """Return a function that builds a bench with a motor that contains this program."""

    def build():
        bench = Bench()
        stored_programs.store(source, "program.sms", bench.add("smartmotor", "motor"))
        return bench

    return build


stored = shown(program, "motor", build=motor())


def listing(visit, name="motor"):
    return visit.found(f"{name} listing")


@stored
def test_lines_are_listed_and_the_running_one_is_marked(visit):
    """The program starts 0.2 s after power-on, and waits for 4000 samples, almost a second, in line 2."""
    assert listing(visit).lines == ("a=1", "WAIT=4000", "a=2", "C1", "WAIT=4000", "GOTO1")
    assert listing(visit).running is None
    visit.run(0.5)
    assert listing(visit).running == 1 and visit.found("motor runs").text == "line 2 runs"
    visit.run(1)
    assert listing(visit).running == 4


@stored
def test_a_break_is_made_and_taken_away_by_its_line_number(visit):
    visit.trigger("motor listing", "toggle", {"line": 4})
    assert [each.sentence for each in visit.context.session.breaks] == ["motor runs 5"]
    assert listing(visit).on_breaks == (4,)
    visit.context.session.breaks[0].on = False
    visit.frame()
    assert (listing(visit).on_breaks, listing(visit).off_breaks) == ((), (4,))
    visit.trigger("motor listing", "toggle", {"line": 4})
    assert not visit.context.session.breaks and listing(visit).off_breaks == ()


@stored
def test_breaks_that_are_made_elsewhere_are_shown(visit):
    visit.context.session.add_break("motor runs 3")
    visit.context.session.add_break("motor.shaft passes 100")
    visit.frame()
    assert listing(visit).on_breaks == (2,)


@pytest.mark.parametrize("line", [-1, 6, 1.0, True, "1", None])
@stored
def test_what_is_no_line_makes_no_break(visit, line):
    visit.trigger("motor listing", "toggle", {"line": line})
    assert not visit.context.session.breaks


@stored
def test_at_a_line_that_never_runs_there_is_no_break_and_one_is_told_why(visit):
    visit.trigger("motor listing", "toggle", {"line": 3})
    assert not visit.context.session.breaks and "C1" in visit.messages[-1]


@stored
def test_whoever_does_not_drive_makes_no_break(visit):
    visit.context.people.take_over(visit.context.people["another"])
    visit.trigger("motor listing", "toggle", {"line": 4})
    assert not visit.context.session.breaks and "drives" in visit.messages[-1]


@stored
def test_a_program_is_stopped_and_started_by_what_a_host_says(visit):
    visit.run(0.5)
    assert listing(visit).running == 1
    visit.press("motor END")
    visit.run(0.1)
    assert listing(visit).running is None
    visit.press("motor RUN")
    visit.run(0.1)
    assert listing(visit).running == 1


@stored
def test_switched_off_and_on_it_begins_again(visit):
    visit.run(1.5)
    visit.press("motor power-cycle")
    assert listing(visit).running is None
    visit.run(0.5)
    assert listing(visit).running == 1


@shown(program, "board", build=board)
def test_a_board_that_is_switched_off_and_on_has_lost_its_sequences(visit):
    visit.press("board perform")
    visit.run(0.5)
    assert listing(visit, "board").running == 0
    visit.press("board power-cycle")
    assert visit.bench["board"].powered and not visit.bench["board"].programs
    assert visit.user.find("Nothing is stored.")


def interface():
    bench = Bench()
    send(bench, ready(bench), ":X400:P0,20:R1:$")
    return bench


@shown(program, "if1", build=interface)
def test_breaks_at_lines_of_an_interface(visit):
    for line in (0, 1):
        visit.trigger("if1 listing", "toggle", {"line": line})
    assert [each.sentence for each in visit.context.session.breaks] == ["if1 runs 1", "if1 runs 2"]
    assert listing(visit, "if1").on_breaks == (0, 1)
    for line in (0, 1):
        visit.trigger("if1 listing", "toggle", {"line": line})
    assert (visit.context.session.breaks, listing(visit, "if1").on_breaks) == ([], ())


@stored
def test_a_program_is_pasted_and_loaded(visit):
    visit.press("motor load")
    visit.choose("motor text", "b=1\nWAIT=4000\nEND\n")
    assert visit.found("motor called").value == "program.sms"
    visit.press("motor loading")
    assert listing(visit).lines == ("b=1", "WAIT=4000", "END")


@stored
def test_a_text_of_any_length_is_not_taken(visit):
    visit.press("motor load")
    visit.choose("motor text", "' x\n" * 70_000)
    visit.press("motor loading")
    assert visit.messages[-1].startswith("the text is too long: expected at most 262,144 characters")
    assert visit.found("motor text").value == "" and listing(visit).lines[0] == "a=1"


@pytest.mark.parametrize("model", OURS)
@shown(program)
def test_a_text_that_is_wrong_is_told_with_its_place_and_nothing_is_loaded(visit, model):
    before = [listing.lines for listing in visit.bench[model].programs.values()]
    visit.press(f"{model} load")
    visit.choose(f"{model} text", "§\n")
    visit.press(f"{model} loading")
    assert ":1:1: " in visit.messages[-1]
    assert [listing.lines for listing in visit.bench[model].programs.values()] == before


@stored
def test_a_name_that_says_no_family_is_told(visit):
    visit.press("motor load")
    visit.choose("motor called", "program.xyz")
    visit.choose("motor text", "b=1\n")
    visit.press("motor loading")
    assert "program.xyz" in visit.messages[-1] and listing(visit).lines[0] == "a=1"


@shown(program, "motor", build=motor(b"a=a+1\n" * 5000 + b"END\n"))
def test_thousands_of_lines_are_sent_once(visit):
    lines = listing(visit).props["lines"]
    assert len(lines) == 5001
    visit.run(0.5)
    assert listing(visit).props["lines"] is lines and listing(visit).running > 100


@shown(program, "if2")
def test_where_nothing_is_stored_that_is_said(visit):
    assert visit.user.find("Nothing is stored.")


@shown(program, "board", build=board)
def test_of_several_sequences_one_is_chosen_and_its_breaks_name_it(visit):
    which = visit.found("board which")
    assert (which.options, which.value) == (["sequence 3", "sequence 7"], "sequence 3")
    visit.choose("board which", "sequence 7")
    visit.frame()
    assert len(listing(visit, "board").lines) == 2
    visit.trigger("board listing", "toggle", {"line": 1})
    assert [each.sentence for each in visit.context.session.breaks] == ["board runs 7:2"]
    assert listing(visit, "board").on_breaks == (1,)
    visit.choose("board which", "sequence 3")
    visit.frame()
    assert listing(visit, "board").on_breaks == ()


@shown(program, "board", build=board)
def test_following_it_shows_the_sequence_that_runs_which_its_buttons_start_and_end(visit):
    visit.choose("board which", "sequence 7")
    visit.frame()
    visit.press("board perform")
    visit.run(0.5)
    assert (visit.found("board which").value, listing(visit, "board").running) == ("sequence 7", 0)
    visit.choose("board which", "sequence 3")
    visit.run(1)
    assert (visit.found("board which").value, listing(visit, "board").running) == ("sequence 7", 1)
    visit.choose("board follow", value=False)
    visit.choose("board which", "sequence 3")
    visit.run(0.1)
    assert (visit.found("board which").value, listing(visit, "board").running) == ("sequence 3", None)
    visit.choose("board follow", value=True)
    visit.frame()
    visit.press("board kill")
    visit.run(0.1)
    assert listing(visit, "board").running is None


@stored
def test_what_is_wished_is_kept_for_the_person(visit):
    visit.choose("motor follow", value=False)
    assert visit.context.person.settings["motor follow"] is False
    with visit.user.client, ui.row():
        program(visit.context, "motor")
    assert [box.value for box in visit.user.find(marker="motor follow").elements] == [False, False]
