"""Machines on the page: power, terminals, faults, the X-Y table in 2-D and 3-D, and front panels."""

import re
from functools import partial

from playwright.sync_api import expect

from .using import click, number, on, press, thumb


def test_what_moves_is_drawn_where_it_is(panel):
    panel.moving()
    who, axis = panel.facts.moving.split()[0].split(".")
    place = panel.region(who).locator(".axis", has=panel.page.get_by_role("heading", name=axis, exact=True))
    expect(place.locator('[data-part="position"]')).to_have_text("1\u2009000")
    if panel.machine == "cut-to-length":
        drawing = panel.region("feeder").locator(".shaft")
        expect(drawing.locator('[data-part="turns"]')).to_have_text("2 + 180.0°")
        assert number(drawing.locator('[data-part="rpm"]').inner_text().lstrip("+")) > 0


@on("drill")
def test_a_pin_is_driven_and_released(panel):
    panel.moving()
    panel.tab(panel.facts.who, "Pins")
    name = f"{panel.facts.who}.{panel.facts.pin}"
    row = panel.page.get_by_role("group", name=name, exact=True)
    lamp = row.get_by_role("img")
    for word, told in (("high", "on"), ("low", "off")):
        click(panel.button(f"{word} {name}"))
        expect(lamp).to_have_attribute("aria-label", f"{panel.facts.pin} high: {told}")
        expect(row).to_contain_text("driven")
        expect(panel.button(f"{word} {name}")).to_have_attribute("aria-pressed", "true")
    click(panel.button(f"release {name}"))
    expect(row).not_to_contain_text("driven")


@on("drill")
def test_the_host_lets_a_control_line_go(panel):
    panel.moving()
    panel.tab("table", "Pins")
    for line in ("dtr", "rts"):
        lamp = panel.page.get_by_role("group", name=f"table host's {line.upper()}").get_by_role("img")
        click(panel.button(f"low table.{line}"))
        expect(lamp).to_have_attribute("aria-label", re.compile("off$"))
        click(panel.button(f"high table.{line}"))
        expect(lamp).to_have_attribute("aria-label", re.compile("on$"))


@on("cut-to-length")
def test_an_analog_pin_is_a_slider(panel):
    panel.moving()
    panel.tab("knife", "Pins")
    row = panel.page.get_by_role("group", name="knife.E", exact=True)
    slider = row.get_by_role("slider", name="knife.E volts")
    press(thumb(slider), "ArrowLeft")
    expect(row).to_contain_text("4.95 V = 1013")
    box = slider.bounding_box()
    panel.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    expect(row).to_contain_text(re.compile(r"2\.\d\d V = 5\d\d"))
    click(panel.button("release knife.E"))
    expect(row).to_contain_text("5.00 V = 1023")


@on("cut-to-length")
def test_the_external_encoder_is_turned_and_the_temperature_around_the_motor_is_set(panel):
    panel.begin()
    panel.step("event")  # what is done at time 0 is kept
    pins = panel.tab("knife", "Pins")
    field = pins.get_by_role("spinbutton", name="ambient, °C")
    panel.say(field, "40")
    field.blur()
    pins.get_by_role("spinbutton", name="counts").fill("-300")
    pins.get_by_role("spinbutton", name="in seconds").fill("0.01")
    click(panel.button("turn the external encoder of knife"))
    panel.speed("5")
    panel.run()
    expect(panel.region("knife").locator('[data-part="edges"]')).to_have_text("−300")
    panel.pause()
    expect(field).to_have_value("40")


@on("winder")
def test_the_joystick(panel):
    panel.moving()
    panel.tab("traverse", "Pins")
    stick = panel.page.get_by_role("slider", name="joystick of traverse, by arrow keys")
    told = panel.page.get_by_text(re.compile("^joystick: "))
    stick.focus()
    panel.page.keyboard.down("ArrowRight")
    expect(told).to_have_text("joystick: 1000 pulses/s")
    panel.page.keyboard.up("ArrowRight")
    expect(told).to_have_text("joystick: at zero")
    stick.scroll_into_view_if_needed()
    box = stick.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    panel.page.mouse.move(*middle)
    panel.page.mouse.down()
    panel.page.mouse.move(middle[0] - 40, middle[1], steps=4)
    expect(told).to_have_text(re.compile(r"joystick: -\d+ pulses/s"))
    panel.page.mouse.up()
    expect(told).to_have_text("joystick: at zero")


@on("drill")
def test_fronts_tell_what_they_mean_and_all_registers(panel):
    panel.moving()
    card = panel.tab(panel.facts.who, "Front panel")
    for title, shown in (("What it means", "dl.meaning"), ("All registers", ".registers")):
        drawer = card.get_by_role("button", name=title)
        click(drawer)
        card.locator(shown).first.wait_for()
        click(drawer)
        card.locator(shown).first.wait_for(state="hidden")


@on("drill")
def test_switches_on_the_drawing_are_clicked_and_pressed_by_keys(panel):
    panel.moving()
    machine = panel.region("table")
    panel.open_unused("table")
    click(panel.button("Axes", machine))
    for switch, pin, free in (
        (machine.locator("button[data-act=input3]"), "input3", "off"),
        (machine.get_by_role("button", name="plus limit of X"), "limit_plus", "free"),
    ):
        panel.tab("table", "Pins")
        row = panel.page.get_by_role("group", name=f"table.{pin}", exact=True)
        for act, pressed in (
            (click, "true"),
            (partial(press, key="Enter"), "false"),
            (partial(press, key=" "), "true"),
            (click, "false"),
        ):
            act(switch)
            expect(switch).to_have_attribute("aria-pressed", pressed)
            expect(switch).to_contain_text("pressed" if pressed == "true" else free)
            if pressed == "true":
                expect(row).to_contain_text("driven")
            else:
                expect(row).not_to_contain_text("driven")
        panel.paused()
    click(panel.button("Top", machine))


@on("drill")
def test_a_fault_is_put_in_and_mended(panel):
    panel.moving()
    panel.tab("table", "Faults")
    faults = panel.region("faults")
    title = faults.get_by_role("button", name="Inject a fault")
    click(title)
    for kind, values in (("lose", {"count, characters": "3"}), ("open_limit", {})):
        click(faults.get_by_role("combobox", name="kind"))
        click(panel.page.get_by_role("option", name=re.compile(f"^{kind}: ")))
        for label, value in values.items():
            panel.field(label, faults).fill(value)
        panel.field("name", faults).fill(f"my-{kind}")
        click(panel.button("Inject"))
        row = faults.get_by_role("listitem").filter(has_text=f"my-{kind}")
        expect(row).to_contain_text("on since")
        click(panel.button(f"mend my-{kind}"))
        expect(row).to_contain_text("over")
    click(title)


@on("drill")
def test_a_table_from_above_its_tool_and_its_third_dimension(panel):
    panel.begin()
    card = panel.region("table")
    above = card.get_by_role("img", name="X, Y from above")
    expect(above).to_contain_text("Output 1 off")
    pins = panel.tab("table", "Pins")
    panel.choose("tool", "output 2", pins)
    expect(above).to_contain_text("Output 2 off")
    panel.choose("tool", "output 1", pins)
    panel.run_until("table.output1 rises")
    expect(above).to_contain_text("Output 1 on")
    expect(above.locator('[data-part="places"]')).to_have_attribute("d", re.compile("^M"))
    click(panel.button("3-D", card))
    card.locator("canvas").wait_for()
    click(panel.button("turn left"))
    click(panel.button("turn right"))
    click(panel.button("Top", card))
    card.locator("canvas").wait_for(state="hidden")
