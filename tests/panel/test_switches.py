"""Switches and lamps on the drawing of a machine."""

import re

import pytest

from axistwin.ui.drawings.switches import Switches
from axistwin.ui.panel.views.machines import machines

from .showing import bench_of, show, shown
from .test_machines import SLIDE


def told(visit, mark, part):
    """Return what a switch shows: its state, the level of its terminal, and its state for screen readers."""
    shown = visit.found(mark).drawing.shown
    level = shown.get((f"{part}-level", "text")) or shown[part, "title"].partition(": ")[2]
    return shown[f"{part}-word", "text"], level, shown[part, "aria-pressed"]


SWITCHES = (
    ("if1", "input1", "low", "off"), ("if1", "estop", "high", "released"), ("1811", "trigger3", "high", "released"),
    ("1811", "home", "high", "released"), ("smartmotor", "E", "high", "released"),
)  # fmt: skip


@pytest.mark.parametrize(("model", "pin", "free", "word"), SWITCHES)
@shown(machines, after=1.5)
def test_a_click_presses_a_switch_and_a_second_click_releases_it(visit, model, pin, free, word):
    pressed = {"low": "high", "high": "low"}[free]
    mark, part = f"switches {model}", f"switch-{pin}"
    assert told(visit, mark, part) == (word, free, "false")
    visit.trigger(mark, "act", pin)
    assert told(visit, mark, part) == ("pressed", pressed, "true") and visit.bench[model].pins[pin].driven
    visit.trigger(mark, "act", pin)
    assert told(visit, mark, part) == (word, free, "false") and not visit.bench[model].pins[pin].driven

    visit.bench[model].pins[pin].drive(free == "high")  # as a script releases a button
    visit.frame()
    assert told(visit, mark, part) == (word, free, "false")
    visit.bench[model].pins[pin].hold(pressed == "high")
    visit.frame()
    assert told(visit, mark, part)[:2] == ("stuck", pressed)


@pytest.mark.parametrize(("model", "part", "pin", "free"), [
    ("if1", "minus", "limit_minus", "high"), ("if1", "plus", "limit_plus", "high"),
    ("1811", "plus", "cw_limit", "low"), ("1811", "home", "home", "high"), ("smartmotor", "minus", "D", "low")
])  # fmt: skip
def test_the_switches_of_a_slide_are_pressed_there(model, part, pin, free):
    axis = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}[model]
    options = {axis: {**SLIDE, **({"home": (-10, 10)} if model == "1811" else {})}}

    def play(visit):
        mark = f"axis {model}.{axis}"
        for click, word in ((False, "free"), (True, "pressed"), (True, "free")):
            if click:
                visit.trigger(mark, "act", pin)
            level = free if word == "free" else {"low": "high", "high": "low"}[free]
            assert told(visit, mark, part) == (word, level, "true" if word == "pressed" else "false")
            assert visit.bench[model].pins[pin].level is (level == "high")
        assert (f"switch-{pin}-word", "text") not in visit.found(f"switches {model}").drawing.shown

    def begin(visit):
        visit.run(1.5)
        play(visit)

    show(bench_of(model, **options), lambda context: machines(context, model), begin)


@shown(machines, "1811", after=1.5)
def test_a_lamp_shows_an_output(visit):
    lamps = visit.found("switches 1811").drawing.shown
    assert lamps["lamp-output1", ".lit"] and lamps["lamp-output1", "aria-label"] == "Output 1: on"
    assert not lamps["lamp-led", ".lit"]
    visit.bench["1811"].power(False)
    visit.frame()
    assert lamps["lamp-output1", "aria-label"] == "Output 1: off"


@shown(machines, "smartmotor", after=1.5)
def test_an_output_pin_is_no_input(visit):
    visit.bench["smartmotor"].serial.write(b"UAO UA=0 ")
    visit.run(0.1)
    assert told(visit, "switches smartmotor", "switch-A") == ("output", "low", "false")
    visit.trigger("switches smartmotor", "act", "A")
    assert told(visit, "switches smartmotor", "switch-A") == ("pressed", "high", "true")


@shown(machines, "if1", after=1.5)
def test_only_the_driver_presses_switches_and_only_those_of_the_drawing(visit):
    visit.trigger("switches if1", "act", "output1")
    visit.trigger("switches if1", "act", ["input1"])
    visit.context.people.driver = None
    visit.trigger("switches if1", "act", "input1")
    assert not any(pin.driven for pin in visit.bench["if1"].pins.values())
    assert "drives: press Drive to take over" in visit.messages[-1]


def wired():
    bench = bench_of("if1", "1811")()
    bench.wires += [("if1.output1", "if1.input2"), ("1811.output2", "if1.input3")]
    return bench


def test_wired_and_named_terminals_come_first_and_the_others_are_folded():
    board = Switches(wired()["if1"], lambda pin, level: None, {"input1": "Start"})
    first, _, rest = board.drawing.art.partition("<details")
    assert re.findall(r'data-part="(?:switch|lamp)-(\w+)-word"', first) == ["input1", "input2", "input3", "output1"]
    for words in ('Input 1 <span class="quiet">Start', "from output 1", "from 1811 output 2", "to input 2"):
        assert words in first
    folded = re.findall(r'data-part="(?:switch|lamp)-(\w+)-word"', rest)
    assert f"{len(folded)} unused" in rest and "estop" in folded


def test_the_input_that_a_user_must_change_is_marked():
    controller = wired()["if1"]
    board = Switches(controller, lambda pin, level: None)
    shown = board.drawing.shown
    for wanted in ("input1", "input2", "nothing"):
        board.show(controller, wanted)
        assert [name for name in ("input1", "input2") if shown.get((f"switch-{name}", ".wanted"))] == (
            [wanted] if wanted != "nothing" else []
        )
