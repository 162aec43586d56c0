"""Stored programs in a browser: loading, start, stop, the running line, and breakpoints at lines."""

from playwright.sync_api import expect

from .using import click, on, press

TURN = "UCI UDI ZS\nMP A=500 V=400000\nWHILE 1\nWAIT=100\nLOOP\nEND\n"
LETTER_BY_LETTER = "(field, text) => { field.value = text; field.dispatchEvent(new Event('input', {bubbles: true})) }"


def lines(panel, who):
    return panel.page.get_by_test_id(f"listing {who}").get_by_role("listitem")


def running_line(panel, who, number):
    """Return the line that the program executes, which must have this number."""
    running = panel.page.get_by_test_id(f"listing {who}").locator("li.running")
    expect(running).to_have_attribute("aria-current", "step")
    expect(running.get_by_role("button")).to_have_text(number)
    return running


@on("drill")
def test_a_program_is_started_and_stopped_and_the_running_line_is_marked(panel):
    """The host of the drill has stored the program, and locked it."""
    panel.begin()
    program = panel.tab("table", "Program")
    panel.run_until("table runs 2")
    running_line(panel, "table", "2")
    click(panel.button("cancel #", program))
    click(panel.button("start :$", program))
    panel.run()
    expect(panel.tab("table", "Terminal").get_by_test_id("terminal table")).to_contain_text("#CR")
    panel.pause()


@on("cut-to-length")
def test_a_program_is_loaded_and_stopped_and_a_break_at_a_line_is_set_by_mouse_and_by_keyboard(panel):
    panel.begin()
    panel.step("event")  # what is done at time 0 is kept
    program = panel.tab("knife", "Program")
    click(panel.button("Load…", program))
    dialog = panel.page.get_by_role("dialog")
    file = {"name": "turn.sms", "mimeType": "text/plain", "buffer": TURN.encode()}
    dialog.locator("input[type=file]").set_input_files(file)
    expect(panel.field("called", dialog)).to_have_value("turn.sms")
    expect(panel.field("or its text", dialog)).to_have_value(TURN)
    click(panel.button("Load", dialog))
    dialog.wait_for(state="hidden")
    panel.run_until("knife runs 4")  # the program starts automatically
    running = running_line(panel, "knife", "4")
    first, second = (lines(panel, "knife").nth(n).get_by_role("button") for n in (0, 1))
    click(first)
    expect(first).to_have_attribute("aria-pressed", "true")
    press(first, "ArrowDown")
    expect(second).to_be_focused()
    press(second, "Enter")
    expect(second).to_have_attribute("aria-pressed", "true")
    for number in (first, second):
        click(number)
        expect(number).to_have_attribute("aria-pressed", "false")
    click(panel.button("END", program))
    panel.step("event")
    expect(running).to_have_count(0)


@on("drill")
def test_what_is_wrong_in_a_program_is_told_with_its_place_and_a_text_that_is_too_long_is_not_taken(panel):
    panel.moving()
    click(panel.button("Load…", panel.tab("table", "Program")))
    dialog = panel.page.get_by_role("dialog")
    panel.field("or its text", dialog).fill("§\n")
    click(panel.button("Load", dialog))
    panel.message(":1:1")
    panel.field("or its text", dialog).evaluate(LETTER_BY_LETTER, ("x" * 1000 + "\n") * 1200)
    click(panel.button("Load", dialog))
    panel.message("the text is too long: expected at most 262,144 characters")
    panel.visit.wrong.clear()  # NiceGUI has logged to the console that the text was too long to send
    click(panel.button("Cancel", dialog))
    dialog.wait_for(state="hidden")


@on("drill")
def test_off_and_on(panel):
    panel.moving()
    program = panel.tab("table", "Program")
    follow = program.get_by_role("checkbox", name="follow")
    click(follow)
    expect(follow).not_to_be_checked()
    click(follow)
    click(panel.button("Off and on", program))
    key = panel.page.get_by_role("button", name="power of table")
    expect(key).to_have_text("Power on")
    expect(key).to_have_attribute("aria-pressed", "true")
    click(key)
    expect(key).to_have_attribute("aria-pressed", "false")
    expect(key).to_have_text("Power off")
    press(key, "Enter")
    expect(key).to_have_attribute("aria-pressed", "true")
    panel.step("event")  # the next test of the motion begins again


@on("cut-to-length")
def test_the_running_line_is_in_view_also_when_one_comes_back_to_its_tab(panel):
    """Line 15 of the knife's program waits for the feeder; only a dozen lines are visible, so the view must scroll."""
    panel.begin()
    program = panel.tab("knife", "Program")
    panel.run_until("knife runs 15")
    for again in range(2):
        if again:
            panel.tab("knife", "Pins")
            panel.page.get_by_test_id("listing knife").wait_for(state="hidden")
            program = panel.tab("knife", "Program")
        expect(program.locator("li.running").get_by_role("button")).to_have_text("15")
        panel.page.wait_for_function("""() => {
            const line = document.querySelector('[data-test="listing knife"] .running').getBoundingClientRect();
            const box = document.querySelector('[data-test="listing knife"]').getBoundingClientRect();
            return line.top >= box.top && line.bottom <= box.bottom;
        }""")
