"""Small instances of the proofs of `axistwin probe`: mutants, planted faults, late answers and random states."""

import importlib
import random
import sys
from pathlib import Path

import pytest

from axistwin.real.probing.comparing import Verdict

pytestmark = pytest.mark.slow

ROBUSTNESS = Path(__file__).parents[2] / "benchmarks" / "robustness"


@pytest.fixture(scope="module")
def scripts():
    """Return the scripts by name; `probe` of this folder, not of another one."""
    names = ("states", "probe", "probe_faults", "probe_load", "probe_states")
    before = {name: sys.modules.pop(name, None) for name in names}
    sys.path.insert(0, str(ROBUSTNESS))
    yield {name: importlib.import_module(name) for name in names}
    sys.path.remove(str(ROBUSTNESS))
    for name in names:
        sys.modules.pop(name, None)
        if before[name] is not None:
            sys.modules[name] = before[name]


@pytest.mark.parametrize("mutant", [
    ("if1", "B", "ignored", None), ("if1", "$", "ignored", None), ("if1", "busy", "option", "ignore"),
    ("1811", 0x76, "ignored", None), ("1811", 0x33, "another parameter", None), ("1811", "reply_ms", "option", 8.0),
    ("smartmotor", "KP=", "ignored", None), ("smartmotor", "RKP", "another answer", None),
    ("smartmotor", "GOSUBn", "another parameter", None), ("smartmotor", "CASE", "ignored", None)])  # fmt: skip
def test_mutants_are_found(scripts, mutant):
    assert scripts["probe"].found_by_probe(mutant)


@pytest.mark.parametrize(
    "mutant", [("1811", 0x00, "ignored", None), ("smartmotor", "LIMD", "ignored", None), ("if1", "\n", "ignored", None)]
)
def test_mutants_that_cannot_be_shown_have_a_reason(scripts, mutant):
    assert scripts["probe"].reason(*mutant[:2])


def test_the_changes_of_a_mutant_end_with_it(scripts):
    probe = scripts["probe"]
    assert not probe.differs(probe.probed("if1", to_the_end=True))


@pytest.mark.parametrize("number", [0, 3, 9, 13, 14, 20, 21, 22, 23, 24])
def test_planted_faults_are_named(scripts, number):
    fault = scripts["probe_faults"].planted(random.Random(2))[number]
    assert any(fault.expected in name for name in scripts["probe_faults"].findings(fault))


def test_nothing_moves_in_random_states(scripts):
    wrong, kinds = scripts["probe_states"].campaign(5, 9)
    assert wrong == [] and kinds["probed"] >= 5


@pytest.mark.parametrize("port", ["some answers late", "few answers very late", "all answers late"])
def test_late_answers_are_no_differences(scripts, port):
    load = scripts["probe_load"]
    for model in ("if1", "1811"):
        assert not load.probed(model, port, random.Random(3)).of(Verdict.DIFFERS)


def test_with_an_idle_port_everything_is_the_same(scripts):
    load = scripts["probe_load"]
    for seed in (3, 4):
        found = load.probed("1811", "idle", random.Random(seed))
        assert [result.case.name for result in found.results if result.verdict is not Verdict.SAME] == []


def test_a_fault_is_found_while_answers_are_late(scripts):
    assert scripts["probe_load"].with_fault("if1", "some answers late", random.Random(5)) == ""
