"""Terminals on the page: switches, sliders, the joystick, control lines; all actions go through the session."""

import pytest

from axistwin.sim.pins import connect
from axistwin.ui.panel.views.pins import pins

from .showing import bench_of, shown


def keys(name):
    return [f"{name}-high", f"{name}-low", f"{name}-release"]


@pytest.mark.parametrize(("model", "name"), [("if1", "input2"), ("1811", "trigger2"), ("smartmotor", "F")])
@shown(pins)
def test_an_input_is_driven_high_and_low_and_released(visit, model, name):
    pin, mark = visit.bench[model].pins[name], f"{model}-{name}"
    released = pin.level
    assert visit.pressed(*keys(mark)) == [f"{mark}-release"]
    visit.press(f"{mark}-high")
    assert (pin.level, pin.driven) == (True, True)
    assert visit.lit(f"{mark}-level") and visit.pressed(*keys(mark)) == [f"{mark}-high"]
    assert visit.found(f"{mark}-why").text == "driven"
    visit.press(f"{mark}-low")
    assert (pin.level, pin.driven) == (False, True) and not visit.lit(f"{mark}-level")
    visit.press(f"{mark}-release")
    assert (pin.level, pin.driven) == (released, False)
    assert visit.found(f"{mark}-why").text == ""


def wired():
    bench = bench_of("if1")()
    connect(bench["if1"].pins["output1"], bench["if1"].pins["input1"])
    return bench


@shown(pins, "if1", build=wired)
def test_it_is_told_who_decides_about_a_level(visit):
    assert visit.found("if1-input1-why").text == "wired"
    visit.bench.faults.add("stuck", "if1.input1", level=True)
    visit.frame()
    assert visit.found("if1-input1-why").text == "stuck" and visit.lit("if1-input1-level")


@shown(pins, "if1")
def test_only_what_is_no_output_can_be_touched(visit):
    marks = {mark for element in visit.user.client.elements.values() for mark in element._markers}
    assert "if1-estop-high" in marks and not marks & {"if1-output1-high", "if1-led-high"}


@shown(pins, "1811")
def test_a_terminal_with_two_names_is_there_once(visit):
    assert visit.found("1811-home-level").text == "home, home_enable"


@shown(pins, "smartmotor")
def test_a_slider_drives_volts_and_shows_what_the_converter_makes_of_them(visit):
    pin = visit.bench["smartmotor"].pins["E"]
    assert visit.found("smartmotor-E-figure").text == "5.00 V = 1023"
    visit.trigger("smartmotor-E-volts", "update:modelValue", 2.5)
    assert (pin.volts, pin.driven) == (2.5, True)
    assert visit.found("smartmotor-E-figure").text == "2.50 V = 512" and visit.pressed(*keys("smartmotor-E")) == []
    visit.press("smartmotor-E-release")
    assert visit.found("smartmotor-E-volts").value == 5.0


@shown(pins, "if1")
def test_whoever_does_not_drive_touches_nothing_and_is_told_so(visit):
    visit.context.people.driver = visit.context.people["another"]
    visit.press("if1-input2-high")
    assert not visit.bench["if1"].pins["input2"].level and "visitor 2 drives" in visit.messages[-1]


@shown(pins, "smartmotor")
def test_a_slider_goes_back_where_it_was_when_one_may_not_touch_it(visit):
    visit.context.people.driver = visit.context.people["another"]
    visit.choose("smartmotor-E-volts", 2.5)
    visit.trigger("smartmotor-E-volts", "update:modelValue", 2.5)
    assert visit.found("smartmotor-E-volts").value == 5.0


@shown(pins, "if1")
def test_the_host_lets_its_control_lines_go(visit):
    host = visit.bench["if1"].serial.host
    assert visit.lit("if1-host-dtr-level")
    visit.press("if1-dtr-low")
    assert (host.dtr_line.level, visit.lit("if1-host-dtr-level")) == (False, False)
    visit.press("if1-dtr-high")
    assert host.dtr_line.level


@shown(pins, "smartmotor")
def test_the_external_encoder_is_turned(visit):
    visit.choose("smartmotor-master-counts", -300)
    visit.choose("smartmotor-master-seconds", 0.5)
    visit.press("smartmotor-master-turn")
    visit.run(1)
    assert visit.bench["smartmotor"].master.count == -300


@shown(pins, "1811")
def test_the_stick_is_deflected_while_an_arrow_is_held(visit):
    joystick = visit.bench["1811"].joystick
    visit.trigger("1811-stick", "keydown", {"key": "ArrowRight", "shiftKey": True})
    assert joystick.rate == 5000
    assert visit.found("1811-joystick-rate").text == "joystick: 5000 pulses/s"
    visit.trigger("1811-stick", "keyup")
    assert joystick.rate == 0
    visit.trigger("1811-stick", "keydown", {"key": "ArrowDown"})
    assert joystick.rate == -1000
    visit.trigger("1811-stick", "blur")
    assert joystick.rate == 0


@shown(pins, "1811")
def test_the_stick_is_dragged_and_springs_back(visit):
    joystick = visit.bench["1811"].joystick
    visit.trigger("1811-joystick", "start")
    visit.trigger("1811-joystick", "move", {"data": {"vector": {"x": -0.5, "y": 0.1}}})
    assert joystick.rate == -2500
    visit.trigger("1811-joystick", "end")
    assert joystick.rate == 0


@shown(pins, "1811")
def test_a_page_that_goes_lets_the_stick_go(visit):
    joystick = visit.bench["1811"].joystick
    visit.trigger("1811-stick", "keydown", {"key": "ArrowRight"})
    assert joystick.rate == 1000
    for handler in visit.user.client.disconnect_handlers:
        handler()
    assert joystick.rate == 0


@shown(pins, "1811")
def test_looking_at_a_joystick_changes_nothing(visit):
    visit.run(0.1)
    pins = visit.bench["1811"].pins
    assert [pins[name].level for name in ("at_zero", "step_in", "direction_in")] == [True, True, True]
