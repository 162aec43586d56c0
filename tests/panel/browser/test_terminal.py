"""Terminals in a browser: messages of host and controller, and input by the user."""

import re

from playwright.sync_api import expect

from .using import click, on, press


def terminal(panel, who):
    tab = panel.tab(who, "Terminal")
    return tab, tab.get_by_test_id(f"terminal {who}")


def ready(panel):
    """Return the name and the terminal of a controller in motion."""
    who = panel.facts.terminal
    panel.begin()
    panel.run_until(panel.facts.moving)
    tab, said = terminal(panel, who)
    expect(tab).to_contain_text("no client is connected")
    return who, tab, said


def test_what_is_said_appears_and_a_line_is_typed_and_answered(panel):
    who, _, said = ready(panel)
    if panel.machine == "cut-to-length":
        _, heard = terminal(panel, "feeder")
        expect(heard).to_contain_text("U61<CR>")
    else:
        expect(said).to_contain_text("velocity-time data" if panel.machine == "winder" else "U61<CR>")
    panel.speed("5")
    panel.say(panel.field(f"say to {who}"), panel.facts.says)
    expect(said).to_contain_text(f"> {panel.facts.says}" if panel.machine != "winder" else "> 83")
    panel.run()
    expect(said).to_contain_text(re.compile(r"< .*" + re.escape(panel.facts.answer)))
    panel.pause()
    expect(panel.field(f"say to {who}")).to_have_value("")


@on("drill", "winder")
def test_keys_go_out_one_by_one_from_the_screen_itself(panel):
    _, _, said = ready(panel)
    click(said)
    panel.page.keyboard.type("R")
    if panel.machine == "winder":
        panel.message("a board accepts whole commands only")
        return
    panel.run()
    expect(said).to_contain_text("> R")
    panel.pause()


@on("drill")
def test_how_a_line_ends_break_lines_and_format(panel):
    who, tab, said = ready(panel)
    panel.choose("ended by", "LF", tab)
    panel.field(f"say to {who}").fill("Q")
    click(panel.button("Send", tab))
    panel.run()
    expect(said).to_contain_text("Q<LF>")
    panel.pause()
    panel.choose("ended by", "CR", tab)
    click(panel.button("Break", tab))
    panel.run()
    expect(said).to_contain_text("<BREAK 0.25 s>")
    panel.pause()
    panel.say(panel.field("format", tab), "2400 7E1")
    panel.say(panel.field("format", tab), "fast")
    panel.message("fast")
    for line in ("DTR", "RTS"):
        switch = tab.get_by_role("switch", name=line)
        click(switch)
        expect(switch).not_to_be_checked()
        click(switch)
        expect(switch).to_be_checked()


@on("drill")
def test_a_lesson_is_selected_by_keys(panel):
    panel.begin()
    tab, _ = terminal(panel, "table")
    press(panel.button("Lessons", tab), "Enter")
    first = panel.page.get_by_role("menuitem").first
    expect(first).to_have_text("1 The first command")
    press(first, "Enter")
    lesson = tab.get_by_role("group", name="lesson for table")
    expect(lesson.get_by_role("status")).to_contain_text(re.compile(r"^\d\. "))  # the scene's host does some steps
    expect(panel.state).to_contain_text("running")
    panel.pause()
    click(panel.button("Show solution", lesson))
    click(panel.button("End lesson", lesson))
    expect(lesson).to_be_hidden()
