"""Several users in browsers: the driver and other users."""

from playwright.sync_api import expect

from .conftest import PHONE
from .using import Panel, click, on, strike

NAME = "<img src=x onerror=window.wrong=1>"
SHOWN = NAME[:30]


def people(page):
    click(page.get_by_role("button", name="drive").first)
    return page.get_by_role("textbox", name="your name")


@on("drill")
def test_one_drives_and_another_sees_who_and_takes_over_and_names_are_words(machine, panel, visiting):
    panel.begin()
    panel.say(people(panel.page), NAME)
    panel.page.get_by_text(f"{SHOWN} — drives").wait_for()
    strike(panel.page, "Escape")
    with visiting(machine[1], PHONE) as visit:
        second = Panel(machine[0], visit)
        second.button(f"{SHOWN} drives").wait_for()
        click(second.button("Run"))
        second.message(f"{SHOWN} drives: press Drive to take over")
        expect(second.state).to_have_text("paused")
        click(second.button(f"{SHOWN} drives"))
        click(second.button("Drive", visit.page))
        strike(visit.page, "Escape")
        second.button("you drive").wait_for()
        panel.message("drives now")
        panel.button("you drive").wait_for(state="hidden")
        click(second.button("more controls"))
        click(second.button("event"))
        expect(panel.clock).not_to_have_text("0.000000 s")
        expect(second.clock).to_have_text(panel.clock.inner_text())
        people(panel.page)
        click(panel.button("Drive"))
        strike(panel.page, "Escape")
        second.message(f"{SHOWN} drives now")
        for page in (panel.page, visit.page):
            assert page.evaluate("window.wrong") is None
    panel.say(people(panel.page), "visitor 1")
    strike(panel.page, "Escape")
