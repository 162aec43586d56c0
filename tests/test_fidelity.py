"""Each decision in docs/fidelity.md names a test that exists."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
NAMED = sorted(set(re.findall(r"`([\w/]+\.py)::(\w+)`", (ROOT / "docs" / "fidelity.md").read_text(encoding="utf-8"))))


@cache
def names_in(file):
    tree = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize(("file", "name"), NAMED)
def test_the_test_named_there_exists(file, name):
    assert name in names_in(file)


def test_every_entry_names_one():
    rows = [
        line
        for line in (ROOT / "docs" / "fidelity.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("| ")
    ]
    entries = [row for row in rows if not row.startswith(("| question", "| ---"))]
    assert len(entries) > 50
    assert [row for row in entries if "::test_" not in row] == []
