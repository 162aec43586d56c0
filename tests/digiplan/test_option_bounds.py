"""Ruling 2: figures for which the manual gives only a bound are options; a wrong value is an error of one line."""

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

FIGURES = ("self_test_s", "recalculation_s", "strobe_ms")
ONE_OF = {
    "wiring": ("5-wire", "3-wire", "3-wire DSR-DTR", "3-wire unlinked"), "busy": ("hold", "ignore"),
    "limits": ("any motion", "motion ahead"), "unlock": ("last format", "lock format", "any format"),
}  # fmt: skip


@pytest.mark.parametrize(("name", "value"), [
    *((name, value) for name in FIGURES for value in (60, 60.0, 0.5, 1)),
    *((name, value) for name in ("self_test_s", "recalculation_s") for value in (0, 0.0))])  # fmt: skip
def test_figures_from_0_to_60(name, value):
    Bench().add("if1", **{name: value})


@pytest.mark.parametrize("name", FIGURES)
@pytest.mark.parametrize("value", [-1, -0.001, 60.001, 61, True, False, "1", None])
def test_figures_that_are_refused(name, value):
    low = "0.001" if name == "strobe_ms" else "0"
    with pytest.raises(UsageError, match=f"^{name}={value!r}: expected a number from {low} to 60$"):
        Bench().add("if1", **{name: value})


@pytest.mark.parametrize("value", [0, 0.0, 1e-9])
def test_a_strobe_takes_time(value):
    with pytest.raises(UsageError, match=f"^strobe_ms={value}: expected a number from 0.001 to 60$"):
        Bench().add("if1", strobe_ms=value)


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in ONE_OF.items() for value in values])
def test_choices(name, value):
    Bench().add("if1", **{name: value})
    with pytest.raises(UsageError, match=f"^{name}='{value}x': expected one of .*{value!r}"):
        Bench().add("if1", **{name: f"{value}x"})


@pytest.mark.parametrize("name", ["fault_output", "strict_format"])
def test_yes_or_no(name):
    Bench().add("if1", **{name: True})
    with pytest.raises(UsageError, match=f"^{name}=1: expected true or false$"):
        Bench().add("if1", **{name: 1})
