"""The tutor in a terminal of the panel."""

import re

from axistwin.ui.panel.drawings.entries import Entries
from axistwin.ui.panel.views.terminal import terminal

from .showing import shown


def say(visit, name, line):
    visit.choose(f"say-{name}", line)
    visit.trigger(f"say-{name}", "keydown.enter")


@shown(terminal, "smartmotor")
def test_a_refused_line_and_an_answer_are_explained_below_them(visit):
    visit.run(1)
    say(visit, "smartmotor", "RW")
    visit.run(0.5)
    asked, answer, *notes = visit.told("smartmotor", 2).splitlines()
    assert (asked, answer) == ("> RW<CR>", "< 1670<CR>") and "Bo motor off; Bp plus limit" in notes[0]
    say(visit, "smartmotor", "RXYZ")
    visit.run(0.1)
    line, refused, *_ = visit.told("smartmotor", 1).splitlines()
    assert line == "> RXYZ<CR>" and refused.startswith("refused: ")


@shown(terminal, "if1")
def test_the_tutor_is_switched_off_and_still_answers_questions(visit):
    visit.run(1.5)
    visit.choose("tutor-if1", False)
    say(visit, "if1", "X1000$")
    visit.run(0.5)
    assert visit.told("if1") == "> X1000$<CR>"
    visit.press("next-if1")
    assert visit.told("if1", 1).startswith("? What next?\nthe baud rate is not known yet: type")
    visit.press("why-if1")
    assert visit.told("if1", 1).startswith("? Why does nothing move?\nthe baud rate is not known yet: type")
    visit.choose("say-if1", "DP301")
    visit.press("explain-if1")
    assert visit.told("if1", 1).startswith("? Explain DP301\nDP301  ")


@shown(terminal, "1811")
async def test_a_board_explains_commands_by_name_and_after_going_back_in_time(visit):
    visit.run(1)
    visit.press("why-1811")
    assert "a move needs velocity and acceleration" in visit.told("1811", 1)
    await visit.context.session.go_to(0.5)
    visit.frame()
    assert visit.told("1811") == ""
    visit.press("next-1811")
    assert "type" in visit.told("1811", 1)


@shown(terminal, "smartmotor")
def test_a_motor_that_is_not_addressed_obeys_after_the_byte_that_the_tutor_names(visit):
    visit.run(0.5)
    for line in ("UCI UDI ZS A=100 V=100000 MP SADDR3", r"\x81", "P=50 G"):
        say(visit, "smartmotor", line)
        visit.run(0.1)
    visit.press("why-smartmotor")
    (address,) = re.findall(r"another motor: type  (\S+)", visit.told("smartmotor", 1))
    for line in (address, "P=70 G"):
        say(visit, "smartmotor", line)
        visit.run(0.5)
    assert visit.context.bench["smartmotor"].axes["shaft"].position == 70


@shown(terminal, "if1")
def test_before_the_first_message_the_first_steps_are_shown(visit):
    (entries,) = (each for each in visit.user.client.elements.values() if isinstance(each, Entries))
    assert visit.found("begin-if1").visible and not entries.visible
    visit.run(1.5)
    visit.press("why-if1")
    assert entries.visible


@shown(terminal, "if1")
def test_control_characters_are_told_by_an_icon_that_covers_nothing(visit):
    assert visit.found("signs-if1").text == r"\r \n \xNN are control characters"
    assert visit.found("say-if1").props["aria-description"] == r"\r \n \xNN are control characters"
