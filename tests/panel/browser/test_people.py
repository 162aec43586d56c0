"""Several users in browsers: the driver and other users."""

import re

from playwright.sync_api import expect

from .conftest import PHONE
from .using import Panel, click, on

NAME = "<img src=x onerror=window.wrong=1>"
SHOWN = NAME[:30]


def name_field(panel):
    return panel.field("your name", panel.open("more controls"))


@on("drill")
def test_one_drives_and_another_sees_who_and_takes_over_and_names_are_words(machine, panel, visiting):
    panel.begin()
    panel.say(name_field(panel), NAME)
    panel.page.get_by_text(f"{SHOWN} — drives").wait_for()
    panel.close()
    with visiting(machine[1], PHONE) as visit:
        second = Panel(machine[0], visit)
        expect(visit.page.locator(".more")).to_contain_text(f"{SHOWN} drives")
        click(second.button("Run"))
        second.message(f"{SHOWN} drives: press Drive to take over")
        second.paused()
        click(second.button("Drive", second.open("more controls")))
        expect(visit.page.get_by_text("you drive")).to_be_visible()
        second.close()
        panel.message("drives now")
        expect(panel.page.locator(".more")).to_contain_text(re.compile(r"visitor \d+ drives"))
        click(second.open("Step").get_by_role("menuitem", name="to the next event"))
        expect(panel.clock).not_to_have_text("0.000000 s")
        expect(second.clock).to_have_text(panel.clock.inner_text())
        click(panel.button("Drive", panel.open("more controls")))
        panel.close()
        second.message(f"{SHOWN} drives now")
        for page in (panel.page, visit.page):
            assert page.evaluate("window.wrong") is None
    panel.say(name_field(panel), "visitor 1")
    panel.close()
