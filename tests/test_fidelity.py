"""Each decision in docs/fidelity.md names a test that exists."""

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "fidelity.md").read_text(encoding="utf-8")


@cache
def names_in(file):
    tree = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_the_tests_named_there_exist():
    named = re.findall(r"`([\w/]+\.py)::(\w+)`", PAGE)
    assert len(named) > 500 and [f"{file}::{name}" for file, name in named if name not in names_in(file)] == []


def test_every_entry_names_one():
    rows = [line for line in PAGE.splitlines() if line.startswith("| ")]
    entries = [row for row in rows if not row.startswith(("| question", "| ---"))]
    assert len(entries) > 50 and [row for row in entries if "::test_" not in row] == []
