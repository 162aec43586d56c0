"""Running, standing, steps, speed, breaks, time, keys; a session that is saved and run again."""

import io
import re
import zipfile

from click.testing import CliRunner
from playwright.sync_api import expect

from axistwin.cli.main import axistwin

from .using import thumb


def test_it_is_marked_virtual(panel):
    expect(panel.page.get_by_text("VIRTUAL", exact=True)).to_be_visible()
    assert panel.page.title().startswith("VIRTUAL")


def test_it_runs_and_stands(panel):
    panel.begin()
    panel.speed("5")
    stood = panel.clock.inner_text()
    panel.button("Run").click()
    expect(panel.state).to_have_text("running")
    expect(panel.clock).not_to_have_text(stood)
    panel.button("Pause", panel.driving).click()
    panel.stands()


def test_steps(panel):
    panel.begin()
    panel.button("event").click()
    expect(panel.clock).not_to_have_text("0.000000 s")
    panel.stands()
    panel.run_until(panel.facts.moving)
    stood = panel.clock.inner_text()
    panel.button("move").click()
    expect(panel.clock).not_to_have_text(stood)
    panel.stands()


def test_a_step_to_the_next_line_of_a_program(panel):
    panel.begin()
    panel.run_until(panel.facts.moving)
    stood = panel.clock.inner_text()
    panel.button("statement").click()
    if panel.machine == "winder":  # whose host streams: there is no program
        panel.message("nothing like that happens soon")
    else:
        expect(panel.clock).not_to_have_text(stood)
        panel.stands()


def test_speed_by_the_field_and_by_the_slider(panel):
    panel.begin()
    panel.speed("fast")
    panel.message("invalid speed 'fast'")
    panel.speed("20")
    slider = panel.driving.get_by_role("slider", name="speed")
    expect(slider).to_have_attribute("aria-valuenow", "7")
    thumb(slider).press("ArrowRight")
    expect(panel.field("times real time")).to_have_value("50")


def test_keys(panel):
    panel.begin()
    panel.speed("1")
    panel.page.get_by_text("VIRTUAL", exact=True).click()
    keyboard = panel.page.keyboard
    keyboard.press("+")
    expect(panel.field("times real time")).to_have_value("2")
    keyboard.press("-")
    expect(panel.field("times real time")).to_have_value("1")
    for key in ("e", "m"):
        stood = panel.clock.inner_text()
        keyboard.press(key)
        expect(panel.clock).not_to_have_text(stood)
        panel.stands()
    keyboard.press(" ")
    expect(panel.state).to_have_text("running")
    keyboard.press(" ")
    expect(panel.state).to_have_text("stands")
    keyboard.press("?")
    dialog = panel.page.get_by_role("dialog")
    expect(dialog).to_contain_text("step to the next event")
    panel.button("Close", dialog).click()
    expect(dialog).to_be_hidden()
    panel.button("help").click()
    expect(dialog).to_be_visible()
    keyboard.press("Escape")
    expect(dialog).to_be_hidden()


def test_keys_that_a_control_wants_itself_do_not_drive(panel):
    panel.begin()
    box = panel.field("run until")
    box.fill("")
    box.press_sequentially("e m")
    expect(box).to_have_value("e m")
    box.fill("")
    panel.region(panel.facts.who).get_by_role("tab", name="Pins").press(" ")
    expect(panel.state).to_have_text("stands")
    expect(panel.clock).to_have_text("0.000000 s")


def test_run_until(panel):
    panel.begin()
    panel.field("run until").fill(panel.facts.moving)
    panel.button("Until").click()
    panel.stands(f": {panel.facts.moving}")
    panel.say(panel.field("run until"), "nobody passes 1")
    panel.message("nobody")


def test_breaks(panel):
    panel.begin()
    panel.button("Breaks").click()
    panel.say(panel.field("stop whenever"), panel.facts.moving)
    there = panel.page.get_by_role("checkbox", name=panel.facts.moving)
    expect(there).to_be_checked()
    panel.page.keyboard.press("Escape")
    panel.button("Run").click()
    panel.stands(f": break: {panel.facts.moving}")
    panel.button("Breaks (1)").click()
    expect(panel.page.get_by_text("once", exact=True)).to_be_visible()
    there.click()
    expect(there).not_to_be_checked()
    panel.button("remove").click()
    expect(there).to_be_hidden()
    panel.page.keyboard.press("Escape")
    expect(panel.button("Breaks")).to_be_visible()


def test_back_in_time_and_on_from_there(panel):
    panel.begin()
    panel.run_until(panel.facts.moving)
    there = panel.seconds
    panel.go_to(1.0)
    expect(panel.state).to_have_text("stands, repeating what was recorded")
    slider = panel.time.get_by_role("slider", name="moment, in seconds")
    expect(slider).to_have_attribute("aria-valuenow", "1")
    box = slider.bounding_box()
    panel.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    panel.near(there / 2, there / 20)
    panel.go_to(1.0)
    panel.button("Live from here").click()
    expect(panel.state).to_have_text("stands")
    panel.say(panel.field("go to this moment"), "1000000")
    panel.message("is not recorded")
    panel.say(panel.field("go to this moment"), "noon")
    panel.message("'noon' is no number of seconds")
    panel.field("go to this moment").fill("")


def test_a_session_is_saved_and_repeated_by_run(panel, tmp_path):
    panel.begin()
    panel.run_until(panel.facts.moving)
    with panel.page.expect_download() as download:
        panel.button("Save", panel.time).click()
    with zipfile.ZipFile(io.BytesIO(download.value.path().read_bytes())) as archive:
        archive.extractall(tmp_path)
    result = CliRunner().invoke(axistwin, ["run", str(tmp_path / "scene.toml")])
    assert result.exit_code == 0, result.output
    assert re.search(r"pulses/s|counts/s", result.output)
