"""VALUES and designs: listed values, random values, and invalid texts."""

import pytest

from axistwin import AxistwinError
from axistwin.sweeps import points, read_values

from ..told import raises


@pytest.mark.parametrize(("text", "listed"), [
    ("0..3", [0, 1, 2, 3]), ("-1..1", [-1, 0, 1]), ("0..10:3", [0, 5, 10]), ("0..1:3", [0.0, 0.5, 1.0]),
    ("0.5..2:4", [0.5, 1.0, 1.5, 2.0]), ("1..100:3:log", [1.0, 10.0, 100.0]), ("[1, 2.5]", [1, 2.5]),
    ('["frame17", "frame23"]', ["frame17", "frame23"]), ("frame17", ["frame17"]), ("7", [7]), ("true", [True]),
    ("normal(1, 0.1)", []), ("0.1..0.2", [])])  # fmt: skip
def test_listed_values(text, listed):
    assert list(read_values(text).listed) == pytest.approx(listed)


@pytest.mark.parametrize(("text", "fraction", "value"), [
    ("normal(5, 2)", 0.5, 5.0), ("normal(0, 1)", 0.8413447460685429, 1.0), ("uniform(2, 4)", 0.25, 2.5),
    ("triangular(0, 1, 3)", 1 / 3, 1.0), ("triangular(0, 0, 2)", 0.75, 1.0), ("0..9", 0.999, 9), ("0..9", 0.0, 0),
    ("1..10000:log", 0.5, 100), ("1.0..100.0:log", 0.5, 10.0), ("[3, 1]", 0.5, 1)])  # fmt: skip
def test_drawn_values(text, fraction, value):
    assert read_values(text).at(fraction) == pytest.approx(value)


@pytest.mark.parametrize(("text", "told"), [
    ("5..1", "invalid range 5..1: expected the lower value first, e.g. 1..5"),
    ("1..1", "expected the lower value first"), ("0..1:1", "expected 2 to"),
    ("0..5:3:log", "expected a lower limit above 0"), ("0..9999999", "expected at most"), ("1..b", "invalid range"),
    ("[]", "the list of values is empty"), ("[1,", "invalid value"),
    ("gauss(1, 2)", "expected one of normal, uniform, triangular"), ("normal(1)", "expected normal(mean, deviation)"),
    ("normal(1, 0)", "above 0"), ("uniform(2, 1)", "low below high"), ("triangular(0, 5, 3)", "in this order")
])  # fmt: skip
def test_refused_values(text, told):
    with pytest.raises(AxistwinError) as error:
        read_values(text)
    assert told in str(error.value)


def design(name, runs=None, seed=0, **varied):
    return points(name, {path: read_values(text) for path, text in varied.items()}, runs, seed)


def test_a_grid_takes_every_combination():
    assert design("grid", a="0..1", b="[5, 6]") == [(0, 5), (0, 6), (1, 5), (1, 6)]


def test_zip_takes_values_together():
    assert design("zip", a="0..2", b="7", c="[4, 5, 6]") == [(0, 7, 4), (1, 7, 5), (2, 7, 6)]
    raises(AxistwinError, "a 2, b 3", design, "zip", a="0..1", b="0..2")


def test_draws_in_a_grid_are_new_for_each_run_and_follow_from_the_seed():
    found = design("grid", 3, a="0..1", b="normal(0, 1)")
    assert [a for a, _ in found] == [0, 0, 0, 1, 1, 1] and len({b for _, b in found}) == 6
    assert found == design("grid", 3, a="0..1", b="normal(0, 1)")
    assert found != design("grid", 3, 1, a="0..1", b="normal(0, 1)")
    raises(AxistwinError, "--runs", design, "grid", b="normal(0, 1)")


@pytest.mark.parametrize("name", ["random", "lhs", "sobol"])
def test_sampled_designs_follow_from_the_seed(name):
    if name != "random":
        pytest.importorskip("scipy", reason="the extra [sweeps] is not installed")
    found = design(name, 16, a="0..3", b="0.0..1.0")
    assert len(found) == 16 and found == design(name, 16, a="0..3", b="0.0..1.0")
    assert found != design(name, 16, 5, a="0..3", b="0.0..1.0")
    if name != "random":  # stratified: each quarter of the range has a quarter of the points
        assert sorted(a for a, _ in found) == [n // 4 for n in range(16)]
    raises(AxistwinError, "number of runs is missing", design, name, a="0..3")


def test_too_many_runs_are_refused():
    raises(AxistwinError, "1,002,001 runs", design, "grid", a="0..1000", b="0..1000")
