"""Stored programs in a browser: loading, start, stop, the running line, and breakpoints at lines."""

from playwright.sync_api import expect

from .using import click, on, press


def loaded(panel):
    """Load a program, and return the contents of the Program tab."""
    panel.begin()
    if panel.machine == "winder":  # until the host of the winder has sent all its moves
        panel.run()
        panel.later_than(19.0)
        panel.pause()
    else:
        click(panel.button("event"))
        expect(panel.clock).not_to_have_text("0.000000 s")
        panel.paused()
    program = panel.tab(panel.facts.who, "Program")
    click(panel.button("Load…", program))
    dialog = panel.page.get_by_role("dialog")
    name, text = panel.facts.program
    file = {"name": name, "mimeType": "text/plain", "buffer": text.encode()}
    dialog.locator("input[type=file]").set_input_files(file)
    expect(panel.field("called", dialog)).to_have_value(name)
    expect(panel.field("or its text", dialog)).to_have_value(text)
    click(panel.button("Load", dialog))
    dialog.wait_for(state="hidden")
    return program


def lines(panel):
    return panel.page.get_by_test_id(f"listing {panel.facts.who}").get_by_role("listitem")


def test_a_program_is_loaded_started_and_stopped_and_the_running_line_is_marked(panel):
    if panel.machine == "drill":  # the host of the drill has stored a program, and locked it
        panel.begin()
        program = panel.tab("table", "Program")
    else:
        program = loaded(panel)
    sentence = f"{panel.facts.who} runs {panel.facts.line}"
    if panel.machine == "winder":
        panel.run()
        expect(lines(panel)).to_have_count(2)
        panel.say(panel.field("run until"), sentence)
        click(panel.button(panel.facts.start, program))
        panel.paused(f": {sentence}")
    else:  # the program starts automatically
        panel.run_until(sentence)
    running = panel.page.get_by_test_id(f"listing {panel.facts.who}").locator("li.running")
    expect(running).to_have_attribute("aria-current", "step")
    expect(running.get_by_role("button")).to_have_text(panel.facts.line.rpartition(":")[2])
    click(panel.button(panel.facts.stop, program))
    if panel.machine == "drill":
        click(panel.button(panel.facts.start, program))
        panel.run()
        expect(panel.tab("table", "Terminal").get_by_test_id("terminal table")).to_contain_text("#<CR>")
    else:
        panel.run()
        expect(running).to_have_count(0)
    panel.pause()


@on("cut-to-length")
def test_a_break_at_a_line_by_mouse_and_by_keyboard(panel):
    loaded(panel)
    panel.run()
    first, second = (lines(panel).nth(n).get_by_role("button") for n in (0, 1))
    second.wait_for()
    panel.pause()
    click(first)
    expect(first).to_have_attribute("aria-pressed", "true")
    panel.button("Breaks (1)").wait_for()
    press(first, "ArrowDown")
    expect(second).to_be_focused()
    press(second, "Enter")
    expect(second).to_have_attribute("aria-pressed", "true")
    for number in (first, second):
        click(number)
        expect(number).to_have_attribute("aria-pressed", "false")
    panel.button("Breaks").wait_for()


@on("drill")
def test_what_is_wrong_in_a_program_is_told_with_its_place_and_nothing_is_loaded(panel):
    panel.begin()
    program = panel.tab(panel.facts.who, "Program")
    click(panel.button("Load…", program))
    dialog = panel.page.get_by_role("dialog")
    panel.field("or its text", dialog).fill("§\n")
    click(panel.button("Load", dialog))
    panel.message(":1:1")
    click(panel.button("Cancel", dialog))
    dialog.wait_for(state="hidden")


@on("drill")
def test_off_and_on(panel):
    panel.begin()
    panel.run_until(panel.facts.moving)
    program = panel.tab(panel.facts.who, "Program")
    follow = program.get_by_role("checkbox", name="follow")
    click(follow)
    expect(follow).not_to_be_checked()
    click(follow)
    click(panel.button("Off and on", program))
    expect(panel.button(f"power of {panel.facts.who}")).to_have_text("power: on")


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
