"""Sobol indices: of a function whose indices are known, and of a sweep."""

import json

import pytest

from axistwin.core.errors import UsageError
from axistwin.sweeps import sensitivity

from ..command import run
from .scenes import stepper

pytest.importorskip("SALib", reason="the extra [sensitivity] is not installed")


class Column(list):
    def to_pylist(self):
        return list(self)


class Rows:
    def __init__(self, column):
        self.num_rows, self.column = len(column), column

    def __getitem__(self, _):
        return self.column


def test_a_function_with_known_indices():
    """For y = 2 a + b, with a and b uniform, a has 4/5 and b 1/5 of the variance, without interactions; c has none."""
    points = sensitivity.fractions(3, 512, seed=1)
    found = Column(2 * a + b for a, b, _ in points)
    plan = {"design": "saltelli", "runs": 512, "varied": dict.fromkeys("abc"), "measures": {"y": ""}}
    shares = sensitivity.indices(Rows(found), plan)["y"]
    for kind in ("first", "total"):
        assert [shares[path][kind] for path in "abc"] == pytest.approx([0.8, 0.2, 0.0], abs=0.02)
    assert sensitivity.indices(Rows(Column([1.0] * len(points))), plan) == {"y": None}
    assert sensitivity.indices(Rows(found), {**plan, "design": "sobol"}) == {}


def test_a_sweep_reports_and_draws_the_shares(tmp_path):
    words = ("sweep", stepper(tmp_path), "--vary", "table.X.load.torque=0.05..0.1", "--vary", "wire.0.delay_ms=1..50")
    words += ("--design", "saltelli", "--runs", 4, "--workers", 0, "--out", tmp_path / "s.parquet")
    done = run(*words, "--measure", "echo: from table.output1 rises to table.input1 rises", "--json")
    shares = json.loads(done.out)["sensitivity"]["echo"]
    assert shares["table.X.load.torque"]["total"] == 0 and shares["wire.0.delay_ms"]["total"] > 0.5
    assert "share of echo" in run("sweep", tmp_path / "s.parquet").out
    assert run("plot", tmp_path / "s.parquet", "-o", tmp_path / "s.svg").code == 0
    assert "share of the variance" in (tmp_path / "s.svg").read_text()


@pytest.mark.parametrize(("paths", "runs", "told"), [(2, 100, "a power of 2, e.g. --runs 128"), (1, 64, "two or more")])
def test_wrong_designs_are_refused(paths, runs, told):
    with pytest.raises(UsageError, match=told):
        sensitivity.fractions(paths, runs, 0)
