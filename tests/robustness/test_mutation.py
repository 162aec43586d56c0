"""The mutation score: the mutants, and the verdicts on them by the tests of a tiny module."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("coverage")
if sys.platform == "win32":
    pytest.skip("processes are forked", allow_module_level=True)

ROBUSTNESS = Path(__file__).parents[2] / "benchmarks" / "robustness"

MODULE = '''"""Documented."""

LIMIT = 10


def clipped(value: int, step: int = 2) -> int:
    """Not above the limit."""
    if value > LIMIT:
        return LIMIT
    return value + step


def forgotten(value: int) -> bool:
    return not value
'''
TESTS = """
from tiny.module import clipped

def test_above():
    assert clipped(11) == 10

def test_at_the_limit():
    assert clipped(10) == 12

def test_below():
    assert clipped(0, 5) == 5
"""
CACHED = """
from functools import lru_cache

@lru_cache
def doubled(value):
    return value * 2
"""
CACHED_TESTS = """
from tiny.cached import doubled

def test_nothing():
    doubled(3)

def test_three():
    assert doubled(3) == 6
"""
CAMPAIGN = """
import json, sys
from pathlib import Path
root = Path(sys.argv[1])
sys.path[:0] = [sys.argv[2], str(root)]
from mutants.campaign import Target, run
target = Target("tiny", "tiny", root / "tiny", root, ("test_tiny.py",))
scratch = root / "scratch"
scratch.mkdir()
told = []
result = run(target, 100, 1, 1, set(sys.argv[3:]), scratch, told.append)
print(json.dumps(result))
"""


@pytest.fixture
def operators(monkeypatch):
    monkeypatch.syspath_prepend(str(ROBUSTNESS))
    from mutants import operators

    return operators


def test_what_is_changed(operators):
    names = [mutant.name for mutant in operators.mutants("module.py", MODULE)]
    assert names == [
        "module.py:3: module: 10 -> 11", "module.py:3: module: 10 -> 9", "module.py:6: clipped: 2 -> 3",
        "module.py:6: clipped: 2 -> 1", "module.py:8: clipped: if value > LIMIT -> if True",
        "module.py:8: clipped: if value > LIMIT -> if False", "module.py:8: clipped: value > LIMIT -> value >= LIMIT",
        "module.py:9: clipped: return LIMIT -> return None",
        "module.py:10: clipped: return value + step -> return None",
        "module.py:10: clipped: value + step -> value - step",
        "module.py:14: forgotten: return not value -> return None", "module.py:14: forgotten: not value -> value",
    ]  # fmt: skip


def test_a_table_entry_is_changed_in_range_opcode_unit_and_state(operators):
    table = 'T = u16("time", 1, unit="s")\nC = Opcode(0x2A, "wait seconds", SEQ, (T,), S | Q, handler)\n'
    changes = {(mutant.before, mutant.after) for mutant in operators.mutants("commands.py", table)}
    assert changes == {
        ("1", "2"), ("1", "0"), ("'s'", "'furlongs'"), ("42", "43"), ("42", "41"), ("S | Q", "S"), ("S | Q", "Q"),
    }  # fmt: skip


@pytest.mark.parametrize("number", range(12))
def test_each_change_is_one_node(operators, number):
    """The changed module differs from the original in one line at most."""
    from ast import parse, unparse

    mutant = operators.mutants("module.py", MODULE)[number]
    before, after = unparse(parse(MODULE)).splitlines(), unparse(operators.apply(MODULE, mutant)).splitlines()
    assert sum(a != b for a, b in zip(before, after, strict=True)) == 1


def test_a_sample_depends_on_its_seed_only(operators):
    from random import Random

    found = operators.mutants("module.py", MODULE)
    first, again, other = (operators.sample(found, 5, Random(seed)) for seed in (1, 1, 2))
    assert first == again != other


@pytest.mark.slow
def test_a_tiny_campaign(tmp_path):
    """A mutant is killed if a test fails; a mutant that no test runs, or that has no effect, survives.

    The four mutants of a function with a cache are found by its second test.
    """
    (tmp_path / "tiny").mkdir()
    (tmp_path / "tiny" / "__init__.py").touch()
    (tmp_path / "tiny" / "module.py").write_text(MODULE)
    (tmp_path / "tiny" / "cached.py").write_text(CACHED)
    (tmp_path / "test_tiny.py").write_text(TESTS + CACHED_TESTS)
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = --import-mode=importlib\n")
    words = [sys.executable, "-c", CAMPAIGN, str(tmp_path), str(ROBUSTNESS)]
    equivalent = "module.py: forgotten: not value -> value"
    done = subprocess.run([*words, equivalent], capture_output=True, text=True, check=True, cwd=tmp_path)
    result = json.loads(done.stdout)
    assert result["mutants"] == result["of"] == 12 + 4
    assert (result["killed"], result["survived"], result["equivalent"]) == (10 + 4, 1, 1)
    assert result["survivors"] == ["module.py:14: forgotten: return not value -> return None (no test runs it)"]
    assert result["score"] == 93.3  # 14 of 15
