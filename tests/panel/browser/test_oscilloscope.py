"""The oscilloscope in a browser: signals, time base, cursors, trigger and files."""

import re

import pytest
from playwright.sync_api import expect

from .using import click, on, press, strike, thumb

pytestmark = on("drill")


@pytest.fixture
def scope(panel):
    """Return the oscilloscope's card, which shows an axis and a pin of a machine in motion."""
    panel.moving()
    card = panel.region("oscilloscope")
    card.get_by_test_id("scope-plot").scroll_into_view_if_needed()
    panel.say(card.get_by_test_id("scope-signals"), signals(panel))
    expect(card.get_by_role("row")).to_have_count(3)
    return card


def signals(panel):
    return f"{panel.facts.moving.split()[0]}.velocity, {panel.facts.who}.{panel.facts.pin}"


def span(scope):
    return scope.locator(".scope-span")


def test_signals_are_chosen_from_a_list(panel, scope):
    click(panel.button("List", scope))
    panel.field("Search").fill(f"{panel.facts.who}.{panel.facts.pin}")
    box = panel.page.get_by_role("checkbox", name=f"{panel.facts.who}.{panel.facts.pin}", exact=True)
    expect(box).to_be_checked()
    click(box)
    strike(panel.page, "Escape")
    expect(scope.get_by_role("row")).to_have_count(2)
    scope.get_by_test_id("scope-signals").fill(signals(panel))
    click(panel.button("Show", scope))
    expect(scope.get_by_role("row")).to_have_count(3)
    panel.say(scope.get_by_test_id("scope-signals"), "nothing")
    panel.message("nothing")


def test_pause_zoom_and_pan(panel, scope):
    expect(span(scope)).to_have_text(re.compile("s$"))
    click(panel.button("Pause", scope))
    expect(scope.get_by_role("status")).to_contain_text("view paused")
    for control in ("shorter time", "longer time", "complete record"):
        before = span(scope).inner_text()
        click(panel.button(control, scope))
        expect(span(scope)).not_to_have_text(before)
    before = span(scope).inner_text()
    press(scope.get_by_role("slider", name="time base"), "ArrowRight")
    expect(span(scope)).not_to_have_text(before)
    plot = scope.get_by_test_id("scope-plot")
    plot.hover()
    before = span(scope).inner_text()
    panel.page.mouse.wheel(0, -300)
    expect(span(scope)).not_to_have_text(before)
    before = span(scope).inner_text()
    press(plot, "-")
    expect(span(scope)).not_to_have_text(before)
    press(plot, "ArrowLeft")
    box = plot.bounding_box()
    panel.page.mouse.move(box["x"] + 300, box["y"] + 50)
    panel.page.mouse.down()
    panel.page.mouse.move(box["x"] + 200, box["y"] + 50, steps=3)
    panel.page.mouse.up()
    click(panel.button("Live", scope))
    expect(scope.get_by_role("status")).not_to_contain_text("view paused")
    panel.paused()


def test_lanes_and_overlaid_and_what_cursors_measure(panel, scope):
    for word in ("Overlaid", "Lanes"):
        click(panel.button(word, scope))
        expect(panel.button(word, scope)).to_have_attribute("aria-pressed", "true")
    click(panel.button("complete record", scope))
    plot, times = scope.get_by_test_id("scope-plot"), scope.locator(".scope-times")
    click(panel.button("Clear", scope))
    expect(times).to_contain_text("no cursors")
    box = plot.bounding_box()
    for part in (0.3, 0.6):
        plot.click(position={"x": box["width"] * part, "y": 30})
    expect(times).to_contain_text("B − A")
    click(scope.get_by_role("switch", name="to edges"))
    for name in ("cursor A", "edge before", "next edge", "cursor B"):
        click(panel.button(name, scope))
    press(plot, "Shift+ArrowRight")
    expect(times).to_contain_text("B moves")
    click(scope.get_by_role("switch", name="to edges"))
    press(plot, "Escape")
    expect(times).to_contain_text("no cursors")
    panel.paused()


def test_saving(panel, scope):
    for contents, begins in (("visible window, .csv", b"#"), ("complete record, .parquet", b"PAR1")):
        click(panel.button("Save", scope))
        with panel.page.expect_download() as download:
            click(panel.page.get_by_role("menuitem", name=contents))
        assert download.value.suggested_filename == f"scope{contents.partition(', ')[2]}"
        assert download.value.path().read_bytes().startswith(begins)


def test_a_trigger(panel, scope):
    panel.choose("Trigger", "single", scope)
    panel.choose("on", f"{panel.facts.who}.{panel.facts.pin}", scope)
    panel.choose("edge", "either", scope)
    scope.get_by_role("spinbutton", name="at").fill("0.5")
    press(thumb(scope.get_by_role("slider", name="place of the edge")), "ArrowRight")
    click(panel.button("Arm", scope))
    expect(scope.get_by_role("status")).to_contain_text("waiting for an edge")
    panel.tab(panel.facts.who, "Pins")
    name = f"{panel.facts.who}.{panel.facts.pin}"
    click(panel.button(f"high {name}"))
    panel.run()
    expect(scope.get_by_role("status")).to_contain_text("view paused")
    panel.pause()
