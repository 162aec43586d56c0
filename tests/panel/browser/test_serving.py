"""`axistwin serve` while a page is open: its trace files and its messages."""

from playwright.sync_api import expect

from .conftest import PHONE, Visit
from .using import click, press


def test_what_it_tells_is_that_the_trace_ends_when_somebody_goes_back_and_nothing_with_a_page_at_its_end(
    shown, browser, tmp_path
):
    trace, recording, told = tmp_path / "first.csv", tmp_path / "first.talk", []
    options = ("--speed", "max", "--trace", str(trace), "--record", str(recording))
    with shown("if1", *options, told=told) as address:  # in real time, it may report delays
        visit = Visit(browser, address, PHONE)
        page = visit.page
        click(page.get_by_role("button", name="more controls"))
        clock = page.get_by_test_id("clock")
        expect(clock).to_have_text("1.000 s")  # the self-test has ended, and there are no further events
        page.get_by_role("textbox", name="go to this moment").fill("0.5")
        press(page.get_by_role("textbox", name="go to this moment"), "Enter")
        expect(clock).to_have_text("0.500000 s")
        after = trace.read_bytes()
        page.get_by_role("textbox", name="run until").fill("if1.led falls")
        press(page.get_by_role("textbox", name="run until"), "Enter")
        expect(clock).to_have_text("1.000000 s")
    visit.context.close()
    assert told == ["axistwin: trace and recording end here: the session has gone back in time\n"]
    assert trace.read_bytes() == after
    assert recording.read_text().startswith("; model: if1")
