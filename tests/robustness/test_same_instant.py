"""External actions in the same nanosecond, in any order, on any model, whatever the model is doing."""

import ast
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import axistwin
from axistwin import Bench
from axistwin.sim.pins import connect

from .. import campaigns
from ..digiplan.talking import ask, initialise, ready, write

SOURCES = Path(axistwin.__file__).parent


campaign = campaigns.campaign("same_instant")


@st.composite
def cases(draw):
    model = draw(st.sampled_from(sorted(campaign.MODELS)))
    known = campaign.names()[model]
    act = st.sampled_from(sorted(known)).flatmap(lambda kind: st.tuples(st.just(kind), st.sampled_from(known[kind])))
    return campaign.Case(
        model,
        draw(st.integers(0, len(campaign.MODELS[model].works) - 1)),
        draw(st.integers(0, campaign.MOST_STEPS)),
        draw(st.sampled_from(campaign.MANNERS)),
        tuple(draw(st.lists(act, min_size=2, max_size=3))),
    )


@settings(max_examples=25, deadline=None)
@given(cases())
def test_any_acts_in_the_same_nanosecond(case):
    """The actions raise no exception, and a repetition gives the same result."""
    assert campaign.play(case) == campaign.play(case)


def test_a_short_campaign(capsys):
    assert campaign.main(["--seed", "7", "--count", "60"]) == 0
    assert capsys.readouterr().out == "passed: 60 combinations, seed 7: 0 raised or were not the same again\n"


def test_the_switch_is_turned_again_by_what_turning_it_changes():
    """A pin's change switches the power again, one turn after the other: off, off, on, off, on."""
    power = (("power", "cycle"), ("power", "cycle"), ("power", "off"))
    case = campaign.Case("if1", 1, 6, "inside", power)
    assert campaign.play(case)[-2] is True and campaign.wrong(case) == ""


WORKS = {
    "run": "XG$", "wait": "H1X5$", "pulse": "P1,50$", "index": "X900$", "sequence": ":XG:P1,20:H1A:$",
    "conversation": ":%:X5:$", "interpolation": "X400/Y90@500$",
}  # fmt: skip
FAULTS = ("estop", "x_fault", "y_fault", "limit_plus")


@pytest.mark.parametrize("model", ["if1", "if2"])
@pytest.mark.parametrize("work", WORKS)
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_and_a_loss_of_power(model, work, fault):
    """A fault, added twice in two ways, and a loss of power, in either order: the controller still works."""
    for acts in (
        ["fault", "off"],
        ["off", "fault"],
        ["fault", "fault", "off"],
        ["#", "fault", "off"],
        ["fault", "cut"],
    ):
        bench = Bench()
        it = ready(bench, model=model)
        write(it, WORKS[work])
        bench.run(0.045)
        for act in acts:
            if act == "fault":
                it.pins[fault].drive(not it.pins[fault].level)
            elif act == "off":
                it.power(False)
            elif act == "cut":
                bench.faults.add("power_cut", it.name, duration=0.01)
            else:
                write(it, act)
        stood = it.axes["X"].position
        bench.run(0.5)
        assert it.axes["X"].position == stood and not any(it.pins[f"output{n}"].level for n in range(1, 6))
        it.serial.drop_pending()
        it.serial.read()
        it.pins[fault].release()
        it.power_cycle()
        initialise(bench, it)
        write(it, "X5$")
        bench.run(0.2)
        assert it.axes["X"].position == stood + 5 and ask(bench, it, "E") == b"C\r"


@pytest.mark.parametrize("message", [":S1:H1:X100:$", "X7S1$", ":S1:X100:$"])
def test_an_output_wired_to_the_emergency_stop_ends_what_switches_it(message):
    """Clearing: "any axis in motion will stop", also if the interface itself opens the circuit."""
    bench = Bench()
    it = ready(bench)
    connect(it.pins["output1"], it.pins["estop"], invert=True)
    write(it, message)
    bench.run(1)
    assert (ask(bench, it, "E"), ask(bench, it, "K")) == (b"F\r", b"32\r")
    it.pins["estop"].drive(True)
    assert (ask(bench, it, "K"), ask(bench, it, "E")) == (b"32\r", b"C\r")
    assert it.axes["X"].position == (7 if message == "X7S1$" else 0)


@pytest.mark.parametrize(("model", "work", "pin"), [
    ("if1", 11, "output2"), ("if1", 12, "output1"), ("if2", 12, "output1"), ("1811", 13, "remote_acknowledge"),
    ("1811", 17, "direction"), ("smartmotor", 1, "brake")])  # fmt: skip
@pytest.mark.parametrize("act", ["off", "cycle"])
def test_power_that_goes_when_a_pin_of_its_own_changes(model, work, pin, act):
    """A subscriber to a pin is called while the controller acts, and may switch the controller off."""
    bench = Bench()
    it = campaign.MODELS[model].build(bench)
    left, times = [act], []

    def changed(_):
        if left:
            left.pop()
            times.append(bench.now)
            it.power_cycle() if act == "cycle" else it.power(False)

    it.pins[pin].subscribe(changed)
    campaign.MODELS[model].works[work](it)
    bench.run(1)
    if times:
        assert it.powered is (act == "cycle")
    if act == "off" and model.startswith("if") and times:
        assert not any(it.pins[f"output{n}"].level for n in range(1, 6))


def test_power_is_off_in_the_nanosecond_in_which_it_was_asked_for():
    """A step that switches two outputs is not completed if the first one switches the power off."""
    bench = Bench()
    it = ready(bench)
    it.pins["output1"].subscribe(lambda pin: it.power(False))
    edges = []
    for name in ("output1", "output2"):
        it.pins[name].subscribe(lambda pin: edges.append((pin.name, pin.level, bench.now)))
    write(it, "S12$")
    bench.run(1)
    assert len({at_ns for _, _, at_ns in edges}) == 1
    assert not it.powered and not it.pins["output1"].level and not it.pins["output2"].level


INSIDE = ("sim", "motion", "plant", "controllers", "fault_injection", "bench")


def test_procedures_are_interrupted_in_one_place():
    """Only the helper uses `process.interrupt()` and SimPy's `Interruption`."""
    files = [file for folder in INSIDE for file in (SOURCES / folder).rglob("*.py")]
    assert len({file.parent for file in files}) >= len(INSIDE)
    texts = {file: file.read_text() for file in files}
    calls = [
        f"{file.name}:{node.lineno}"
        for file, text in texts.items()
        if "interrupt" in text
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "interrupt"
    ]
    assert calls == []
    users = sorted(file.name for file in SOURCES.rglob("*.py") if "Interruption" in file.read_text())
    assert users == ["clock.py", "engine.py"]  # the helper itself, and the import of SimPy
