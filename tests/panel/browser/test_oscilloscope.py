"""The oscilloscope in a browser: signals, time base, cursors, trigger and files."""

import re

import pytest
from playwright.sync_api import expect

from .using import click, on, press, thumb

pytestmark = on("drill")


@pytest.fixture
def scope(panel):
    """Return the oscilloscope's card, which shows an axis and a pin of a machine in motion."""
    panel.moving()
    card = panel.region("oscilloscope")
    panel.signals(signals(panel))
    expect(lanes(card)).to_have_count(2)
    return card


def lanes(scope):
    return scope.locator(".scope-names li")


def signals(panel):
    return f"{panel.facts.moving.split()[0]}.velocity, {panel.facts.who}.{panel.facts.pin}"


def span(scope):
    return scope.locator(".scope-span")


def test_signals_are_chosen_from_a_list(panel, scope):
    panel.open("Signals", scope)
    panel.field("Search").fill(f"{panel.facts.who}.{panel.facts.pin}")
    box = panel.page.get_by_role("checkbox", name=panel.facts.lane, exact=True)
    expect(box).to_be_checked()
    click(box)
    expect(lanes(scope)).to_have_count(1)
    panel.page.get_by_test_id("scope-signals").fill(signals(panel))
    click(panel.button("Show"))
    expect(lanes(scope)).to_have_count(2)
    panel.say(panel.page.get_by_test_id("scope-signals"), "nothing")
    panel.message("nothing")
    panel.close()


def test_pause_zoom_and_pan(panel, scope):
    expect(span(scope)).to_have_text(re.compile("s a division$"))
    click(panel.button("Freeze", scope))
    expect(scope.get_by_role("status")).to_contain_text("frozen")
    for control in ("shorter time", "longer time", "All"):
        before = span(scope).inner_text()
        click(panel.button(control, scope))
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
    expect(scope.get_by_role("status")).not_to_contain_text("frozen")
    panel.paused()


def test_lanes_and_overlaid_and_what_cursors_measure(panel, scope):
    for word in ("Overlaid", "Lanes"):
        panel.open("Lanes", scope)
        choice = panel.page.locator(".q-menu").get_by_role("button", name=word, exact=True)
        click(choice)
        expect(choice).to_have_attribute("aria-pressed", "true")
        panel.close()
    click(panel.button("All", scope))
    plot, times = scope.get_by_test_id("scope-plot"), scope.locator(".scope-times")
    press(plot, "Escape")
    expect(times).to_have_text("")
    box = plot.bounding_box()
    for part in (0.3, 0.6):
        plot.click(position={"x": 256 + (box["width"] - 256) * part, "y": 30})
    expect(times).to_contain_text("B − A")
    panel.open("Cursors", scope)
    click(panel.page.get_by_role("switch", name="to edges"))
    for name in ("cursor A", "edge before", "next edge", "cursor B"):
        click(panel.button(name))
    expect(panel.page.get_by_role("row")).to_have_count(3)
    click(panel.page.get_by_role("switch", name="to edges"))
    panel.close()
    press(plot, "Shift+ArrowRight")
    expect(times).to_contain_text("B moves")
    panel.open("Cursors", scope)
    click(panel.button("Clear"))
    panel.close()
    expect(times).to_have_text("")
    panel.paused()


def test_saving(panel, scope):
    for contents, begins in (("visible window, .csv", b"#"), ("complete record, .parquet", b"PAR1")):
        click(panel.button("Save", scope))
        with panel.page.expect_download() as download:
            click(panel.page.get_by_role("menuitem", name=contents))
        assert download.value.suggested_filename == f"scope{contents.partition(', ')[2]}"
        assert download.value.path().read_bytes().startswith(begins)


def test_a_trigger(panel, scope):
    panel.open("Trigger: off", scope)
    panel.choose("Trigger", "single")
    panel.choose("on", panel.facts.lane)
    panel.choose("edge", "either")
    panel.page.get_by_role("spinbutton", name="at").fill("0.5")
    press(thumb(panel.page.get_by_role("slider", name="place of the edge")), "ArrowRight")
    click(panel.button("Arm"))
    panel.close()
    expect(scope.get_by_role("status")).to_contain_text("waiting for an edge")
    panel.tab(panel.facts.who, "Pins")
    name = f"{panel.facts.who}.{panel.facts.pin}"
    click(panel.button(f"high {name}"))
    panel.run()
    expect(scope.get_by_role("status")).to_contain_text("frozen")
    panel.pause()
