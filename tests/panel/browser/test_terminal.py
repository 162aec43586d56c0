"""Terminals in a browser: messages of host and controller, and input by the user."""

import re

from playwright.sync_api import expect

from .using import click, on, press


def terminal(panel, who):
    tab = panel.tab(who, "Terminal")
    return tab, tab.get_by_test_id(f"terminal {who}")


@on("drill", "winder")
def test_what_is_said_appears_and_lines_and_keys_are_typed_and_answered(panel):
    who = panel.facts.who
    panel.moving()
    tab, said = terminal(panel, who)
    expect(tab).to_contain_text("No host is connected")
    expect(said).to_contain_text("velocity-time data" if panel.machine == "winder" else "U61CR")
    panel.speed("5")
    panel.say(panel.field(f"say to {who}"), panel.facts.says)
    expect(said).to_contain_text(f"> {panel.facts.says}" if panel.machine != "winder" else "> 83")
    expect(panel.field(f"say to {who}")).to_have_value("")
    click(said)
    panel.page.keyboard.type("R")
    panel.run()
    expect(said).to_contain_text(re.compile(r"< .*" + re.escape(panel.facts.answer)))
    if panel.machine == "winder":
        panel.message("a board accepts whole commands only")
    else:
        expect(said).to_contain_text("> R")
    panel.pause()


@on("drill")
def test_how_a_line_ends_break_lines_and_format(panel):
    panel.moving()
    tab, said = terminal(panel, "table")
    panel.choose("ended by", "LF", tab)
    panel.field("say to table").fill("Q")
    click(panel.button("Send", tab))
    panel.choose("ended by", "CR", tab)
    settings = tab.get_by_role("button", name="settings of table")
    click(settings)
    click(panel.button("Break"))
    panel.page.keyboard.press("Escape")
    panel.run()
    expect(said).to_contain_text("QLF")
    expect(said).to_contain_text("BREAK 0.25 s")
    panel.pause()
    click(settings)
    panel.say(panel.field("format"), "2400 7E1")
    panel.say(panel.field("format"), "fast")
    panel.message("fast")
    for line in ("DTR", "RTS"):
        switch = panel.page.get_by_role("switch", name=line)
        click(switch)
        expect(switch).not_to_be_checked()
        click(switch)
        expect(switch).to_be_checked()
    panel.page.keyboard.press("Escape")


@on("drill")
def test_a_lesson_is_selected_by_keys(panel):
    panel.moving()
    tab, _ = terminal(panel, "table")
    press(panel.button("Lessons", tab), "Enter")
    first = panel.page.get_by_role("menuitem").first
    expect(first).to_have_text("1 The first command")
    press(first, "Enter")
    lesson = tab.get_by_role("group", name="lesson for table")
    expect(lesson.get_by_role("status")).to_contain_text(re.compile(r"^\d\. "))  # the scene's host does some steps
    panel.button("Pause", panel.driving).wait_for()
    panel.pause()
    click(panel.button("Show solution", lesson))
    click(panel.button("End lesson", lesson))
    expect(lesson).to_be_hidden()
