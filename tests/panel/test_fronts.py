"""Front panels of controllers on the page."""

import pytest

from axistwin.bench import Bench, product
from axistwin.controllers.front import Lamp
from axistwin.controllers.registry import OURS
from axistwin.ui.panel.views.front import front, generic

from .showing import bench_of, shown


@shown(front, "if1")
def test_the_lamp_of_an_if1_is_lit_during_the_self_test_and_flashes_when_it_waits_for_the_format(visit):
    assert visit.lit("if1-LED-Interface")
    visit.run(1.5)
    assert not visit.lit("if1-LED-Interface")
    visit.bench["if1"].serial.write(b"(")
    visit.run(0.1)
    seen = set()
    for _ in range(10):
        visit.run(0.1)
        seen.add(visit.lit("if1-LED-Interface"))
    assert seen == {True, False}


@shown(front, "if1")
def test_words_and_readings_follow_the_registers(visit):
    assert visit.found("if1-state-Interface").text == "self-test"
    visit.run(1.5)
    assert visit.found("if1-state-Interface").text == "waiting for ("
    assert visit.found("if1-E-Interface").text == "no answer yet"
    visit.bench["if1"].power(False)
    visit.frame()
    assert visit.found("if1-state-Interface").text == "no power"


@shown(front, "smartmotor", line="instant")
def test_a_status_word_by_letter_and_an_error_in_its_colour(visit):
    visit.run(0.001)
    letters = {letter: visit.lit(f"smartmotor-{letter}-Status-word-W") for letter in ("Br", "Bl", "Bo", "Be")}
    assert letters == {"Br": True, "Bl": True, "Bo": True, "Be": False}
    visit.bench["smartmotor"].serial.write(b"UCI UDI ZS BRKRLS OFF A=1000 V=100000 P=5000 MP G ")
    visit.run(0.5)
    assert visit.lit("smartmotor-Bt-Status-word-W") and not visit.lit("smartmotor-Bo-Status-word-W")
    assert visit.found("smartmotor-MODE-Motor").text == "P  absolute position"


@pytest.mark.parametrize("model", OURS)
@shown(front)
def test_the_list_of_all_registers_is_made_when_it_is_opened_and_kept_open_for_this_person(visit, model):
    visit.run(1.1)
    register = next(iter(visit.bench[model].registers))
    assert not visit.user.find(marker=f"{model}-registers").elements.pop().value
    with pytest.raises(AssertionError):
        visit.found(f"{model}-register-{register}")
    visit.choose(f"{model}-registers", True)
    for _ in range(5):
        visit.frame()
    assert visit.found(f"{model}-register-{register}").text == str(visit.bench[model].registers[register].read())
    assert model != "1811" or visit.found("1811-register-status").text == str(0x50)
    assert visit.context.person.settings[f"{model} registers"] is True


@pytest.mark.parametrize("model", OURS)
@shown(front)
def test_what_it_means_explains_each_item_in_words_and_is_kept_open_for_this_person(visit, model):
    assert not visit.found(f"{model}-meaning").value
    visit.choose(f"{model}-meaning", True)
    assert visit.context.person.settings[f"{model} meaning"] is True
    explained = [label.text for label in visit.found(f"{model}-meaning").descendants() if hasattr(label, "text")]
    for group in product(model).front:
        assert f"{group.title}: {group.chapter}" in explained
        for item in group.items:
            words = [item.label, f"{item.name}.  {item.doc}" if item.doc else item.name]
            row = words if item.label else [item.name, item.doc]
            assert row in [explained[n : n + 2] for n in range(len(explained))]


@shown(front, "if1")
def test_another_bench_takes_the_place_of_the_one_before(visit):
    visit.run(1.5)
    assert not visit.lit("if1-LED-Interface")
    visit.context.session.bench = bench_of("if1")()
    visit.frame()
    assert visit.lit("if1-LED-Interface")


def without_a_front():
    bench = bench_of("if1")()
    bench["if1"].product = bench["if1"].product._replace(make_front=tuple)
    return bench


@shown(front, "if1", build=without_a_front)
def test_a_controller_without_a_front_gets_its_terminals_and_registers(visit):
    assert visit.lit("if1-led-Outputs") and visit.lit("if1-estop-Inputs")
    visit.run(1.5)
    assert visit.found("if1-state-Registers").text == "waiting for ("


@pytest.mark.parametrize("model", OURS)
def test_a_generic_panel_shows_every_terminal_and_register(model):
    controller = Bench().add(model)
    groups = {group.title: [item.source for item in group.items] for group in generic(controller)}
    assert sorted(groups["Outputs"] + groups["Inputs"]) == sorted(controller.terminals)
    assert groups["Registers"] == list(controller.registers)


@pytest.mark.parametrize("model", OURS)
def test_everything_on_a_front_exists_and_says_what_it_is(model):
    controller = Bench().add(model)
    assert not controller.terminals.keys() & controller.registers.keys(), "a name means one thing"
    for group in product(model).front:
        assert group.title and group.chapter
        for item in group.items:
            assert item.source in controller.terminals or item.source in controller.registers
            assert item.name
            if isinstance(item, Lamp):
                assert item.label
                assert item.bit is None or item.source in controller.registers


@pytest.mark.parametrize("model", OURS)
def test_no_two_items_of_a_group_are_called_the_same(model):
    for group in product(model).front:
        labels = [item.label or item.name for item in group.items]
        assert len(labels) == len(set(labels))


@pytest.mark.parametrize("model", OURS)
@shown(front)
def test_without_power_lamps_are_dark_and_readings_absent(visit, model):
    visit.run(2)
    visit.bench[model].power(False)
    for pin in ("input1", "trigger1", "A"):
        if pin in visit.bench[model].pins:
            visit.bench[model].pins[pin].drive(True)
    visit.frame()
    for group in product(model).front:
        for item in group.items:
            mark = f"{model} {item.label or item.name} {group.title}".replace(" ", "-")
            if isinstance(item, Lamp):
                assert not visit.lit(mark), mark
            else:
                assert visit.found(mark).text in ("", "no power"), mark
    visit.bench[model].power(True)
    visit.run(2)
    assert any(
        visit.lit(f"{model} {item.label or item.name} {group.title}".replace(" ", "-"))
        for group in product(model).front
        for item in group.items
        if isinstance(item, Lamp)
    )
