"""Faults on the page: the form, the list of faults, power switches and the ambient temperature."""

import pytest

from axistwin.bench import Bench
from axistwin.bench.faults.kinds import KINDS
from axistwin.bench.faults.table import On, Sort
from axistwin.controllers.registry import OURS
from axistwin.ui.panel.views.faults import faults, power
from axistwin.ui.panel.views.pins import pins

from .showing import bench_of, shown

EVERYTHING = ("if1", "1811", "smartmotor")
MUST = {"baudrate": 300, "percent": 2, "seconds": 0.01, "counts": 100, "torque": 0.5}
"""Values of the parameters without a default."""


def build():
    """Return a bench on which faults of all kinds are possible."""
    bench = Bench()
    bench.add("if1", "if1", X={"motor": {"torque": [[0, 1.0], [5000, 0.5]], "inertia": 3e-5}, "limits": (-100, 1000)})
    bench.add("1811", "1811", motor={"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 25_000}})
    bench.add("smartmotor", "smartmotor", shaft={"motor": "frame23", "limits": (-1000, 1000)})
    return bench


PLACES = {
    On.LINE: "if1.serial", On.PIN: "if1.input1", On.AXIS: "smartmotor.shaft", On.CONTROLLER: "smartmotor",
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
@shown(faults, build=build)
def test_a_fault_of_every_kind_has_a_form_with_usual_values_and_is_put_in_and_mended(visit, kind):
    place = "if1.X" if kind.name == "drive_fault" else PLACES[kind.on]
    visit.choose("fault-kind", kind.name)
    for parameter in kind.parameters:
        field = visit.found(f"fault-{parameter.name}")
        if parameter.sort in (Sort.WORD, Sort.LEVEL):
            assert list(field.options) == (list(parameter.words) or ["high", "low"])
        else:
            assert field.value == ("" if parameter.default is None else f"{parameter.default:g}")
            assert field.props["placeholder"] == parameter.wanted
    visit.choose("fault-on", place)
    for parameter in kind.parameters:
        if parameter.default is None and not parameter.optional and parameter.name in MUST:
            visit.choose(f"fault-{parameter.name}", str(MUST[parameter.name]))
    visit.press("fault-put")
    assert visit.messages == []
    (fault,) = visit.bench.faults
    assert (fault.kind, fault.spot.name) == (kind, place)
    if kind.at_once and not fault.on:
        assert visit.found(f"fault-{kind.name}-state").text == "over"
        return
    assert visit.found(f"fault-{kind.name}-state").text.startswith("on since 0.000 s")
    visit.press(f"mend-{kind.name}")
    assert not fault.on and visit.found(f"fault-{kind.name}-state").text == "over"


@shown(faults, "if1")
def test_a_fault_that_waits_begins_when_its_sentence_comes_true_and_ends_by_itself(visit):
    visit.choose("fault-kind", "stuck")
    visit.choose("fault-on", "if1.input1")
    visit.choose("fault-level", "high")
    visit.choose("fault-when", "if1.input2 rises")
    visit.choose("fault-nth", "2")
    visit.choose("fault-duration", "0.5")
    visit.choose("fault-name", "glue")
    visit.press("fault-put")
    assert visit.found("fault-glue-state").text == "waiting"
    for level in (True, False, True):
        visit.bench["if1"].pins["input2"].drive(level)
        visit.run(0.1)
    assert visit.found("fault-glue-state").text == "on since 0.200 s" and visit.bench["if1"].pins["input1"].level
    visit.run(0.5)
    assert visit.found("fault-glue-state").text == "over"


@shown(faults, "if1")
def test_what_is_wrong_is_told_with_what_is_wanted(visit):
    visit.choose("fault-kind", "lose")
    visit.choose("fault-probability", "2")
    visit.press("fault-put")
    assert "expected a number from 0 to 1" in visit.messages[-1] and list(visit.bench.faults) == []


@shown(faults, "1811")
def test_a_fault_for_which_there_is_nothing_here(visit):
    visit.choose("fault-kind", "lose")
    visit.press("fault-put")
    assert visit.messages == ["the bench has no serial line"]


@shown(faults, "if1")
def test_the_list_shows_the_faults_of_whatever_bench_there_is(visit):
    visit.bench.faults.add("jam", "if1.X")
    visit.frame()
    assert visit.found("fault-jam-state").text.startswith("on")
    visit.context.session.bench = bench_of("if1")()
    visit.frame()
    with pytest.raises(AssertionError):
        visit.found("fault-jam-state")


@pytest.mark.parametrize("model", OURS)
@shown(power)
def test_the_power_switch(visit, model):
    assert visit.pressed(f"{model}-power")
    visit.press(f"{model}-power")
    assert not visit.bench[model].powered and visit.found(f"{model}-power").text == "Power off"
    visit.press(f"{model}-power")
    assert visit.bench[model].powered


@shown(pins, "smartmotor")
def test_the_temperature_around_a_motor(visit):
    assert visit.found("smartmotor-ambient").value == 25
    visit.choose("smartmotor-ambient", 40)
    visit.trigger("smartmotor-ambient", "change")
    assert visit.bench["smartmotor"].ambient == 40
    visit.bench["smartmotor"].ambient = 30
    visit.frame()
    assert visit.found("smartmotor-ambient").value == 30
