"""Table of the lines that each test runs, recorded once per family with a `coverage` context for each test."""

import os
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from pickle import dumps, loads
from time import process_time

import pytest

from mutants.children import run_tests

SLOWEST_S = 30.0
"""Time limit of a test, traced in plain Python; the result names slower tests, which are omitted."""


@dataclass(frozen=True)
class Traced:
    """`lines`: by file and line, the tests, `""` for no test; `seconds`: by test, its processor time."""

    seconds: dict[str, float]
    lines: dict[str, dict[int, list[str]]]
    slow: list[str]
    failed: list[str]

    def covering(self, file: str, line: int) -> list[str]:
        """Return the tests that run a line, the quickest first."""
        return sorted(filter(None, self.lines.get(file, {}).get(line, ())), key=self.seconds.__getitem__)

    def runs_at_import(self, file: str, line: int) -> bool:
        """Return True if a line has run outside of every test."""
        return "" in self.lines.get(file, {}).get(line, ())

    @property
    def all(self) -> list[str]:
        """Return every test, the quickest first."""
        return sorted(self.seconds, key=self.seconds.__getitem__)


class _Recorder:
    """A pytest plug-in that sets a context for each test and measures its time."""

    def __init__(self, coverage: object, sources: Iterable[Path], skipped: tuple[str, ...]) -> None:
        self._coverage, self._skipped = coverage, skipped
        self._files = {str(path.resolve()) for path in sources}
        self.seconds: dict[str, float] = {}
        self.failed: list[str] = []

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out the skipped tests."""
        items[:] = [item for item in items if not item.nodeid.startswith(self._skipped)]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Set the test's name as the context of the lines that it runs.

        A function with a cache would run in the first test only, so the caches are emptied before each test.
        """
        self._empty_caches()
        self._coverage.switch_context(item.nodeid)
        started = process_time()
        try:
            return (yield)
        finally:
            self.seconds[item.nodeid] = process_time() - started
            self._coverage.switch_context("")

    def _empty_caches(self) -> None:
        for module in list(sys.modules.values()):
            if getattr(module, "__file__", None) in self._files:
                for value in vars(module).values():
                    if callable(empty := getattr(value, "cache_clear", None)):
                        empty()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Record a test that fails without a mutant; such a test cannot detect mutants."""
        if report.failed:
            self.failed.append(report.nodeid)


def trace(root: Path, sources: list[Path], tests: tuple[str, ...], skipped: tuple[str, ...], scratch: Path) -> Traced:
    """Run the tests once in a child, and return the source lines that each test has run."""
    result = scratch / "traced"
    child = os.fork()
    if child == 0:
        try:
            result.write_bytes(dumps(_traced(root, sources, tests, skipped)))
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    return loads(result.read_bytes())


def _traced(root: Path, sources: list[Path], tests: tuple[str, ...], skipped: tuple[str, ...]) -> Traced:
    from coverage import Coverage  # lazy import: only the recording child needs it

    os.dup2(os.open(os.devnull, os.O_RDWR), 1)
    coverage = Coverage(data_file=None, include=[str(path) for path in sources], config_file=False)
    recorder = _Recorder(coverage, sources, skipped)
    coverage.start()
    run_tests(root, tests, recorder)
    coverage.stop()
    data = coverage.get_data()
    slow = sorted(name for name, seconds in recorder.seconds.items() if seconds > SLOWEST_S)
    assert recorder.seconds, "pytest has run no test"
    usable = {n: s for n, s in recorder.seconds.items() if n not in slow and n not in recorder.failed}
    lines = {
        str(Path(file).resolve()): {
            line: [name for name in names if not name or name in usable]
            for line, names in data.contexts_by_lineno(file).items()
        }
        for file in data.measured_files()
    }
    return Traced(usable, lines, slow, recorder.failed)
