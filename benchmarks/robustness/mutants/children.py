"""A child process that imports the tree with one module changed, and runs tests until one fails."""

import ast
import gc
import importlib.abc
import importlib.machinery
import importlib.util
import os
import resource
import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from types import CodeType
from typing import Any

import _hypothesis_pytestplugin
import pytest
import pytest_timeout
from hypothesis import Phase, settings

MEMORY = 4 * 1024**3
"""Memory limit of a child; a mutant that exceeds this limit counts as detected."""
SLACK_S, FACTOR = 2.0, 8
"""Time limit of a test, as a multiple of its usual processor time plus some seconds."""
OPTIONS = (
    "-q", "--no-header", "--no-summary", "-p", "no:cacheprovider", "--tb=no",
    "-W", "ignore::pytest.PytestAssertRewriteWarning", "-o", "timeout=0", "-o", "addopts=--import-mode=importlib",
)  # fmt: skip

settings.register_profile(
    "mutation", derandomize=True, database=None, deadline=None, phases=[Phase.explicit, Phase.generate]
)
"""Settings of Hypothesis: the same examples in every child, without shrinking."""


class Changed(importlib.abc.MetaPathFinder, importlib.machinery.SourceFileLoader):
    """Import one module from a syntax tree instead of its file."""

    def __init__(self, name: str, path: Path, tree: ast.Module) -> None:
        super().__init__(name, str(path))
        self._tree = tree

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:  # noqa: ARG002
        """Return the specification of the changed module; None for other names."""
        return (
            importlib.util.spec_from_file_location(fullname, self.path, loader=self) if fullname == self.name else None
        )

    def get_code(self, fullname: str) -> CodeType:  # noqa: ARG002
        """Return the code of the syntax tree, without a cache."""
        return compile(self._tree, self.path, "exec")


class Chosen:
    """A pytest plug-in: run only these tests, in this order, each within its processor time."""

    def __init__(self, seconds: Mapping[str, float]) -> None:
        self._seconds, self.failed = seconds, ""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Sort the chosen tests by the order in which they were given; drop the others."""
        rank = {name: number for number, name in enumerate(self._seconds)}
        items[:] = sorted((item for item in items if item.nodeid in rank), key=lambda item: rank[item.nodeid])

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """End the process by a signal when a test does not end."""
        signal.setitimer(signal.ITIMER_VIRTUAL, SLACK_S + FACTOR * self._seconds[item.nodeid])
        try:
            return (yield)
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Record the first test that fails."""
        if report.failed and not self.failed:
            self.failed = report.nodeid


def run_tests(root: Path, names: Sequence[str], plugin: object) -> int:
    """Run pytest in this process on files or node ids; return its exit code."""
    settings.load_profile("mutation")
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    os.chdir(root)
    return int(pytest.main([*OPTIONS, *names], plugins=[pytest_timeout, _hypothesis_pytestplugin, plugin]))


def survive(finder: Changed, root: Path, seconds: Mapping[str, float], result: Path) -> None:
    """Run the chosen tests against a changed module, write the failed test, and end the process."""
    started = perf_counter()
    devnull = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(devnull, stream)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    gc.freeze()
    sys.dont_write_bytecode = True
    sys.meta_path.insert(0, finder)
    plugin = Chosen(seconds)
    words = "import"
    try:
        code = run_tests(root, ["-x", *sorted({name.split("::")[0] for name in seconds})], plugin)
        words = plugin.failed or ("" if code == 0 else f"pytest: {pytest.ExitCode(code).name}")
    finally:
        result.write_text(f"{words}\n{perf_counter() - started:.2f}\n")
        os._exit(0)
