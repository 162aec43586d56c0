"""Fixtures of all tests: a bench, and an IF1 that is initialised with `U61`; the flag to record again; slow tests.

`pytest` leaves out the tests that are marked `slow`; `pytest -m slow` runs only these, `pytest PATH` all in a path.
"""

import gc
import marshal
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest
from hypothesis import HealthCheck, settings

from axistwin import Bench
from axistwin.bench import Controller

from .digiplan.talking import ready

# Results depend neither on the machine's speed nor on chance: Hypothesis draws the same input in each run.
settings.register_profile("axistwin", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("random", settings.get_profile("axistwin"), derandomize=False)
settings.load_profile("axistwin")

TESTS = Path(__file__).parent
BROWSER = "tests/panel/browser"
COMPILES = TESTS / "cli" / "test_motors.py"
PACKED = "packed"
LONG_FOLDERS = {"integrations", "cli", "drivers", "panel", "sweeps", "testing", "traces"}
"""Folders whose tests start other programs, or run long: they come first if several processes share the work."""

POSIX_ONLY = {"test_pty.py", "test_serialdev.py", "test_term.py"}
"""Files that import modules which Windows does not have; `test_other_systems.py` tests ports and terminals there."""


def pytest_configure(config: pytest.Config) -> None:
    """Keep bytecode, whatever the environment says: otherwise each process of a test compiles all sources again."""
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    if whole(config) and not config.option.markexpr:
        config.option.markexpr = "not slow"


def whole(config: pytest.Config) -> bool:
    """Return True if no path is given."""
    return config.args_source is pytest.Config.ArgsSource.TESTPATHS


def pytest_report_header(config: pytest.Config) -> str | None:
    return "first, each process imports all tests: up to half a minute" if whole(config) else None


@pytest.hookimpl(wrapper=True)
def pytest_report_to_serializable() -> Iterator[dict[str, Any]]:
    """Send a report as one value, because xdist serialises a report's items one by one in Python, which is slow."""
    return {PACKED: marshal.dumps((yield))}


@pytest.hookimpl(wrapper=True)
def pytest_report_from_serializable(data: dict[str, Any]) -> Iterator[Any]:
    data |= marshal.loads(data.pop(PACKED))
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Collect tests without garbage collection, and exclude the objects that live to the end from later rounds.

    Later rounds are rarer than by default, where they take more than a tenth of the processor time.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(10_000)
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Iterator[pytest.CollectReport]:
    """Let each process begin with other files, so that a file is compiled by one process and cached for the others."""
    report = yield
    worker = getattr(collector.config, "workerinput", None)
    if worker is not None and collector.path == TESTS:
        first = len(report.result) * int(worker["workerid"].removeprefix("gw")) // worker["workercount"]
        report.result = report.result[first:] + report.result[:first]
    return report


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    return True if sys.platform == "win32" and collection_path.name in POSIX_ONLY else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if hasattr(config, "workerinput"):
        items.sort(key=turn)


def turn(item: pytest.Item) -> tuple[int, int]:
    """Return the position of a test if several processes share the work: long units first, short ones last.

    The second unit compiles the kernel, before a server in another unit needs it.  Files are mixed, because the files
    of one folder often wait for the same kind of event, and the processor would be idle.
    """
    if "browser" in item.path.parts:
        return 0, 0
    if item.path == COMPILES:
        return 1, 0
    long = not LONG_FOLDERS.isdisjoint(item.path.relative_to(TESTS).parts)
    return (2 if long else 3), crc32(unit(item.nodeid).encode())


def unit(nodeid: str) -> str:
    """Return the unit of a test: its file, or all tests in a browser, which share the browser and its servers."""
    return BROWSER if nodeid.startswith(BROWSER) else nodeid.partition("::")[0]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Give whole units to each process."""
    from xdist.scheduler import LoadScopeScheduling

    class ByUnit(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return unit(nodeid)

    return ByUnit(config, log)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--record-conversations",
        action="store_true",
        help="write what the controllers say now into tests/conversations/*.talk; review the difference",
    )
    parser.addoption(
        "--hardware",
        action="append",
        default=[],
        metavar="MODEL=PORT",
        help="run tests/drivers/test_hardware.py with a real controller, e.g. if1=/dev/ttyUSB0; it moves 400 counts",
    )


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def if1(bench: Bench) -> Controller:
    return ready(bench)


@pytest.fixture
def printed(record_property: Callable[[str, object], None]) -> Callable[..., None]:
    """Compare a number printed in a manual with the one obtained; both go into the fidelity report.

    `printed(section, words, expected, obtained)`: `words` quotes the manual; `within` is the tolerance it allows.
    """

    def compare(section: str, words: str, expected: Any, obtained: Any, within: float = 0) -> None:
        row = {"section": section, "words": words, "expected": expected, "obtained": obtained, "within": within}
        record_property("printed", row)
        assert abs(obtained - expected) <= within if within else obtained == expected, f"{section}: {words}"

    return compare
