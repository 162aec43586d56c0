"""`axistwin serve` while a page is open: its trace files and its messages."""

import re

from playwright.sync_api import expect

from .conftest import Visit
from .using import press


def test_trace_and_recording_are_of_the_first_run_and_end_told_when_somebody_goes_back(shown, visiting, tmp_path):
    trace, recording, told = tmp_path / "first.csv", tmp_path / "first.talk", []
    options = ("--speed", "max", "--trace", str(trace), "--record", str(recording))
    with shown("if1", *options, told=told) as address, visiting(address) as visit:
        page = visit.page
        clock = page.get_by_test_id("clock")
        expect(clock).to_have_text("1.000 s")  # the self-test has ended, and there are no further events
        page.get_by_role("textbox", name="go to this moment").fill("0.5")
        press(page.get_by_role("textbox", name="go to this moment"), "Enter")
        expect(clock).to_have_text("0.500000 s")
        after = trace.read_bytes()
        page.get_by_role("textbox", name="run until").fill("if1.led falls")
        press(page.get_by_role("textbox", name="run until"), "Enter")
        expect(clock).to_have_text("1.000000 s")
    assert told == ["axistwin: trace and recording end here: the session has gone back in time\n"]
    assert trace.read_bytes() == after
    assert recording.read_text().startswith("; model: if1")


def test_it_ends_without_a_word_also_while_somebody_looks_on(shown, browser):
    told = []
    with shown(
        "if1", "--speed", "max", told=told
    ) as address:  # at maximum speed, because in real time `serve` may report delays
        visit = Visit(browser, address)
        expect(visit.page.get_by_test_id("clock")).to_have_text(re.compile(r"^[1-9]"))
    visit.context.close()
    assert told == [""]
