"""The tutor in a terminal of the panel."""

import re

from axistwin.ui.panel.views.terminal import terminal

from .showing import shown


def say(visit, name, line):
    visit.choose(f"say-{name}", line)
    visit.trigger(f"say-{name}", "keydown.enter")


@shown(terminal, "smartmotor")
def test_a_refused_line_and_an_answer_are_explained(visit, written):
    visit.run(1)
    say(visit, "smartmotor", "RW")
    visit.run(0.5)
    assert "Bo motor off; Bp plus limit" in "".join(written)
    written.clear()
    say(visit, "smartmotor", "RXYZ")
    visit.run(0.1)
    assert "refused: " in "".join(written)


@shown(terminal, "if1")
def test_the_tutor_is_switched_off_and_still_answers_questions(visit, written):
    visit.run(1.5)
    visit.choose("tutor-if1", False)
    say(visit, "if1", "X1000$")
    visit.run(0.5)
    assert "".join(written) == ""
    visit.press("next-if1")
    visit.press("why-if1")
    assert "type" in "".join(written)
    written.clear()
    visit.choose("explain-if1", "DP301")
    visit.trigger("explain-if1", "keydown.enter")
    visit.frame()
    assert "DP301" in "".join(written)


@shown(terminal, "1811")
async def test_a_board_explains_commands_by_name_and_after_going_back_in_time(visit, written):
    visit.run(1)
    visit.press("why-1811")
    assert "".join(written) != ""
    await visit.context.session.go_to(0.5)
    written.clear()
    visit.press("next-1811")
    assert "type" in "".join(written)


@shown(terminal, "smartmotor")
def test_a_motor_that_is_not_addressed_obeys_after_the_byte_that_the_tutor_names(visit, written):
    visit.run(0.5)
    for line in ("UCI UDI ZS A=100 V=100000 MP SADDR3", r"\x81", "P=50 G"):
        say(visit, "smartmotor", line)
        visit.run(0.1)
    visit.press("why-smartmotor")
    visit.frame()
    (address,) = re.findall(r"another motor: type  (\S+?)\x1b", "".join(written))
    for line in (address, "P=70 G"):
        say(visit, "smartmotor", line)
        visit.run(0.5)
    assert visit.context.bench["smartmotor"].axes["shaft"].position == 70
