"""The operator panel of a scene: buttons, lamps and selector switches."""

import pytest

from axistwin import Session
from axistwin.core.errors import SceneError
from axistwin.scenes.reasons.remedies import ByHand
from axistwin.scenes.scene import Scene
from axistwin.scenes.tables import ButtonTable
from axistwin.ui.panel.context import Common, Context
from axistwin.ui.panel.people import People
from axistwin.ui.panel.views.operator import is_stop, operator
from axistwin.ui.teaching.tutor import Tutor

from .showing import shown

CONTROLLER = '[[controller]]\nmodel = "if1"\nname = "cell"\n'
PANEL = """
[[operator.button]]
name = "Start"
pin = "cell.input1"
[[operator.button]]
name = "Stop"
pin = "cell.estop"
pressed = "low"
latching = true
[[operator.lamp]]
name = "Led"
pin = "cell.led"
[[operator.selector]]
name = "Mode"
positions = { hand = "", auto = "cell.input2", test = "cell.input3" }
"""


def loaded(tmp_path, text):
    (tmp_path / "cell.toml").write_text(CONTROLLER + text)
    return Scene.load(tmp_path / "cell.toml")


@pytest.fixture
def context(tmp_path):
    scene, people = loaded(tmp_path, PANEL), People()
    return Context(Common(Session(scene.build, None, scene=scene)), people, people["somebody"])


@shown(operator)
def test_a_button_is_pressed_while_it_is_held_and_a_latching_one_until_the_next_click(visit, context):
    pins = visit.bench["cell"].pins
    for down, up in (("pointerdown", "pointerup"), ("keydown.enter", "keyup.enter")):
        visit.trigger("operator-Start", down)
        assert pins["input1"].level and visit.pressed("operator-Start") == ["operator-Start"]
        assert visit.found("operator-Start-word").text == "pressed"
        visit.trigger("operator-Start", up)
        assert not pins["input1"].level and visit.found("operator-Start-word").text == "released"
    assert visit.found("operator-Stop").props["title"] == "high"
    visit.press("operator-Stop")
    assert not pins["estop"].level and visit.pressed("operator-Stop") == ["operator-Stop"]
    assert visit.found("operator-Stop-word").text == "pressed: click to release"
    visit.press("operator-Stop")
    assert pins["estop"].level and visit.pressed("operator-Stop") == []
    assert len([act for moment in context.session.journal for act in moment.acts]) == 6


@shown(operator)
def test_an_emergency_stop_is_a_mushroom_and_a_start_button_is_white(visit, context):
    assert [name for name in ("Start", "Stop") if "stop" in visit.found(f"operator-{name}").classes] == ["Stop"]
    start, stop = context.session.operator.button
    assert is_stop(stop) and not is_stop(start)
    assert is_stop(ButtonTable(name="Emergency stop", pin="cell.input3", latching=True))
    assert not is_stop(ButtonTable(name="Stop the feed", pin="cell.input3", latching=True))


@shown(operator)
def test_a_lamp_shows_its_terminal(visit, context):
    assert visit.lit("operator-Led")
    visit.run(1.5)
    assert not visit.lit("operator-Led")


@shown(operator)
def test_a_selector_switch_has_one_position(visit, context):
    keys = [f"operator-Mode-{word}" for word in ("hand", "auto", "test")]
    pins = visit.bench["cell"].pins
    for word, levels in (("auto", (True, False)), ("test", (False, True)), ("hand", (False, False))):
        visit.press(f"operator-Mode-{word}")
        assert visit.pressed(*keys) == [f"operator-Mode-{word}"]
        assert (pins["input2"].level, pins["input3"].level) == levels


@pytest.mark.parametrize(("text", "message"), [
    ('[[operator.button]]\nname = "a"\npin = "cell.input9"', r"cell\.toml:6:1: cell has no pin 'input9'"),
    ('[[operator.button]]\nname = "a"\npin = "cell.output1"', r"cell\.output1 is an output: expected an input"),
    ('[[operator.lamp]]\nname = "a"\npin = "led"', r"CONTROLLER\.PIN"),
    ('[[operator.selector]]\nname = "a"\npositions = { on = "cell.input1" }', "at least 2")])  # fmt: skip
def test_an_invalid_operator_panel(tmp_path, text, message):
    with pytest.raises(SceneError, match=message):
        loaded(tmp_path, text).build()


def test_the_tutor_names_the_buttons_of_the_panel(context):
    session, cell = context.session, context.bench["cell"]
    remedies = ByHand(session.operator, "cell")
    tutor = Tutor(cell, remedies)
    assert remedies.drive("input1", "high") == "press Start" and remedies.drive("input1", "low") == "release Start"
    assert remedies.drive("input2", "high") == "turn Mode to auto"
    assert tutor.why()[0].startswith("the self-test")
    context.bench.run(1.5)
    for message in (b"(", b"U61\r"):
        cell.serial.write(message)
        context.bench.run(2)
    session.do("cell", "estop", "low")
    assert tutor.why() == ["the emergency stop is open (PL3 terminal 1): press Stop again  and then  K"]
    session.do("cell", "estop", "release")
    session.do("cell", "limit_plus", "low")
    cell.serial.write(b"K\r")
    context.bench.run(2)
    assert cell.registers["K"].read() == 0
    assert tutor.why() == [
        (
            "the plus limit is open: only moves in the minus direction begin (PL3 terminal 2): "
            "click the switch limit_plus again"
        )
    ]
    session.do("cell", "power", "off")
    assert tutor.why() == ["the power is off: switch the power on (button power)"]
