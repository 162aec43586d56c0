"""Control of virtual time in a browser: run, pause, steps, speed, breakpoints, timeline, keys and saving."""

import io
import zipfile

from click.testing import CliRunner
from playwright.sync_api import expect

from axistwin.cli.program import axistwin

from .using import click, on, press, strike, thumb


@on("drill")
def test_a_session_is_saved_and_repeated_by_run(panel, tmp_path):
    panel.moving()
    with panel.page.expect_download() as download:
        click(panel.button("Save the session", panel.open("more controls")))
    with zipfile.ZipFile(io.BytesIO(download.value.path().read_bytes())) as archive:
        archive.extractall(tmp_path)
    result = CliRunner().invoke(axistwin, ["run", str(tmp_path / "scene.toml")])
    assert result.exit_code == 0, result.output
    assert "pulses/s" in result.output


@on("drill")
def test_it_is_marked_virtual_and_runs_and_steps(panel):
    panel.page.get_by_text("VIRTUAL", exact=True).wait_for()
    assert panel.page.title().startswith("VIRTUAL")
    panel.begin()
    panel.step("event")
    panel.field("run until", panel.open("more controls")).fill(panel.facts.moving)
    click(panel.button("Until"))
    panel.close()
    panel.paused(f": {panel.facts.moving}")
    panel.step("move")
    panel.step("statement")
    panel.speed("5")
    stood = panel.clock.inner_text()
    panel.run()
    expect(panel.clock).not_to_have_text(stood)
    click(panel.button("Pause", panel.driving))
    panel.paused()
    panel.rarely("run until", "nobody passes 1")
    panel.message("nobody")


@on("drill")
def test_speed_by_the_field_and_by_the_menu(panel):
    panel.begin()
    panel.speed("fast")
    panel.message("invalid speed 'fast'")
    panel.speed("20")
    click(panel.open("Speed \u00d720").get_by_role("button", name="\u00d710", exact=True))
    panel.button("Speed \u00d710").wait_for()


@on("drill")
def test_keys(panel):
    panel.begin()
    panel.speed("1")
    click(panel.page.get_by_text("VIRTUAL", exact=True))
    strike(panel.page, "+")
    panel.button("Speed \u00d72").wait_for()
    strike(panel.page, "-")
    panel.button("Speed \u00d71").wait_for()
    for key in ("e", "m"):
        stood = panel.clock.inner_text()
        strike(panel.page, key)
        expect(panel.clock).not_to_have_text(stood)
        panel.paused()
    strike(panel.page, " ")
    panel.button("Pause", panel.driving).wait_for()
    strike(panel.page, " ")
    panel.paused()
    strike(panel.page, "?")
    dialog = panel.page.locator(".q-dialog .q-card")
    expect(dialog).to_contain_text("step to the next event")
    click(panel.button("Close", dialog))
    dialog.wait_for(state="hidden")
    click(panel.button("Keys", panel.open("more controls")))
    dialog.wait_for()
    strike(panel.page, "Escape")
    dialog.wait_for(state="hidden")


@on("drill")
def test_keys_that_a_control_wants_itself_do_not_drive(panel):
    panel.begin()
    box = panel.field("run until", panel.open("more controls"))
    box.fill("")
    box.press_sequentially("e m")
    expect(box).to_have_value("e m")
    box.fill("")
    panel.close()
    press(panel.region("conversation").get_by_role("tab", name="Pins"), " ")
    panel.paused()
    expect(panel.clock).to_have_text("0.000000 s")


@on("drill")
def test_breaks(panel):
    panel.begin()
    panel.open("more controls")
    panel.say(panel.field("stop whenever"), panel.facts.moving)
    there = panel.page.get_by_role("checkbox", name=panel.facts.moving)
    expect(there).to_be_checked()
    panel.close()
    click(panel.button("Run", panel.driving))
    panel.paused(f": break: {panel.facts.moving}")
    panel.open("more controls")
    panel.page.get_by_text("once", exact=True).wait_for()
    click(there)
    expect(there).not_to_be_checked()
    click(panel.button("remove"))
    there.wait_for(state="hidden")
    panel.close()


@on("drill")
def test_back_in_time_and_on_from_there(panel):
    panel.begin()
    panel.run_until(panel.facts.moving)
    there = panel.seconds
    panel.go_to(1.0)
    expect(panel.state).to_have_text("Replay at 1.0 s")
    slider = panel.header.get_by_role("slider", name="moment, in seconds")
    expect(slider).to_have_attribute("aria-valuenow", "1")
    expect(slider).to_have_attribute("aria-valuemax", f"{round(there, 3):g}")
    slider.click()  # a click goes to the middle of the slider, once it has been laid out
    panel.near(there / 2, there / 4)
    panel.go_to(1.0)
    panel.live()
    panel.rarely("go to this moment", "1000000")
    panel.message("is not recorded")
    panel.rarely("go to this moment", "noon")
    panel.message("invalid time 'noon'")


@on("drill")
def test_the_header_does_not_move_and_planned_actions_are_gone_to(panel):
    panel.begin()
    names = ("Run", "Restart", "Step", "Speed max", "more controls")

    def places():
        return [panel.button(name, panel.header).bounding_box() for name in names]

    before = places()
    expect(panel.page.get_by_text("Script: power off at 6 s")).to_be_visible()
    click(panel.button("Go there"))
    panel.near(6, within=0)
    assert places() == before
    panel.go_to(2)
    assert places() == before, "with the button that ends the replay"
    panel.live()
    click(panel.page.get_by_role("button", name="Undo"))
    panel.near(2, within=0)
    expect(panel.button("Live from here")).to_be_visible()


@on("drill")
def test_the_trace_and_the_recording_end_when_somebody_goes_back(machine, panel):
    panel.moving()
    panel.begin()
    after = (machine[2] / "first.csv").read_bytes()
    panel.step("event")
    told = "axistwin: trace and recording end here: the session has gone back in time\n"
    assert (machine[2] / "stderr").read_text().count(told) == 1 and (machine[2] / "first.csv").read_bytes() == after
    assert (machine[2] / "first.talk").read_text().startswith("; model: if2")


@on("drill")
def test_arrow_keys_move_the_timeline_by_1_s_and_with_shift_by_10_s(panel):
    panel.moving()
    panel.go_to(2.5)
    slider = thumb(panel.page.locator(".q-header .timeline"))
    for key, clock in (("ArrowLeft", "1.500000 s"), ("ArrowRight", "2.500000 s"), ("Shift+ArrowLeft", "0.000000 s")):
        press(slider, key)
        expect(panel.clock).to_have_text(clock)
