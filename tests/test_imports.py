"""Pages and examples import names from `axistwin` or from a package, never from a module in a package.

Tests, benchmarks and tools import the module that defines a name.
"""

import ast
import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PLACES = "docs", "examples"
DEEP = re.compile(r"\baxistwin\.\w+\.\w")
"""Name of a module in a package; most sources contain none, and need not be parsed."""
SNIPPET = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def sources(place: str) -> Iterator[tuple[Path, str]]:
    """Yield each example and each Python snippet of a page with the name of a module in a package.

    The files in `docs` itself build the site.
    """
    for path in sorted((ROOT / place).rglob("*.py")):
        if path.parent != ROOT / "docs" and DEEP.search(source := path.read_text(encoding="utf-8")):
            yield path, source
    for path in sorted((ROOT / place).rglob("*.md")):
        for snippet in filter(DEEP.search, SNIPPET.findall(path.read_text(encoding="utf-8"))):
            yield path, snippet


def imported_modules(source: str) -> set[str]:
    """Return the names of all modules of axistwin from which a source imports."""
    nodes = list(ast.walk(ast.parse(source)))
    found = {node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module and not node.level}
    found |= {each.name for node in nodes if isinstance(node, ast.Import) for each in node.names}
    return {name for name in found if name.split(".")[0] == "axistwin"}


def is_module_in_a_package(name: str) -> bool:
    """Return True for e.g. `axistwin.sim.clock`, and False for the package `axistwin.sim` and for `axistwin.units`."""
    spec = find_spec(name)
    return name.count(".") > 1 and spec is not None and spec.submodule_search_locations is None


@pytest.mark.parametrize("place", PLACES)
def test_names_are_imported_from_packages(place):
    deep = {
        f"{path.relative_to(ROOT)}: {name}"
        for path, source in sources(place)
        for name in imported_modules(source)
        if is_module_in_a_package(name)
    }
    assert deep == set()
