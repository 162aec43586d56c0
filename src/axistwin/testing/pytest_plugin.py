"""The pytest plug-in: controllers on real ports for a host under test, in virtual time.  See `docs/testing.md`.

    import pytest

    @pytest.mark.axistwin("if1", self_test_s=0.5)           # or scene="cell.toml", or scene={"controller": [...]}
    def test_my_host(axistwin_port, axistwin_clock):
        host = MyHost(axistwin_port)                        # a URL for pyserial; .visa for PyVISA, .address for asyn
        axistwin_clock.advance(1.5)                         # virtual time passes in this call only

The conversation and a trace of the axes are recorded in the test's `tmp_path`.  If the test fails, its report names
these files; otherwise they are removed.  `--axistwin-report DIR` writes a page for each test.  Other modules of
axistwin are imported when a test uses one of the fixtures.
"""

import re
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from axistwin.links.manual_clock import ServedClock
    from axistwin.testing.twin import Twin, Url

RECORDED_FILES = pytest.StashKey[tuple[Path, ...]]()
FAILED = pytest.StashKey[bool]()
VERDICT = pytest.StashKey[tuple[str, str]]()
"""Key for the outcome of a test and the text of its failure."""
MARKER = (
    "axistwin(what, *, scene=None, speed='manual', **options): the model, or the scene (a path relative to the test's "
    "file, or a dict), that the fixtures axistwin_twin, axistwin_port and axistwin_clock serve."
)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.getgroup("axistwin").addoption(
        "--axistwin-report", metavar="DIR", type=Path,
        help="Write a page for each test that uses axistwin: picture, conversation, verdict and provenance.",
    )  # fmt: skip


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", MARKER)


@pytest.fixture
def axistwin_twin(request: pytest.FixtureRequest, tmp_path: Path) -> "Iterator[Twin]":
    """Run a twin for a test with a marker, e.g. `@pytest.mark.axistwin("if1")`.  Yields the `Twin`."""
    # Import `axistwin.testing.twin` only for tests that use a virtual controller, because the import is slow.
    from axistwin.testing.twin import serve

    what, keywords = _marker_arguments(request)
    files = request.node.stash[RECORDED_FILES] = (tmp_path / "axistwin.talk", tmp_path / "axistwin.csv")
    with serve(what, **{"speed": "manual", **keywords}, record=files[0], trace=files[1]) as twin:
        yield twin
    if (directory := request.config.getoption("axistwin_report")) is not None:
        _write_page(request.node, files, directory)


@pytest.fixture
def axistwin_port(axistwin_twin: "Twin") -> "Url":
    """URL at which pyserial opens the port of the first controller."""
    return next(iter(axistwin_twin.ports.values()))


@pytest.fixture
def axistwin_clock(axistwin_twin: "Twin") -> "ServedClock":
    """Clock of the twin's virtual time: `advance(seconds)`, `run_until(condition, timeout)`, `seconds`, `now`."""
    return axistwin_twin.clock


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """List the recorded files, and what may explain the failure, in the report of a failed test.

    The files of a test that has passed are deleted.
    """
    report = yield
    files = [path for path in item.stash.get(RECORDED_FILES, ()) if path.exists()]
    if report.when == "call" or report.failed:
        item.stash[VERDICT] = (report.outcome, report.longreprtext)
    if report.failed and files:
        item.stash[FAILED] = True
        twin: Twin | None = getattr(item, "funcargs", {}).get("axistwin_twin") if report.when == "call" else None
        notes = [] if twin is None else twin.notes()
        report.sections.append(("axistwin", "\n".join([*notes, *(f"kept: {_shown(path)}" for path in files)])))
    if report.when == "teardown" and not item.stash.get(FAILED, False):
        for path in files:
            path.unlink(missing_ok=True)
    return report


def _write_page(item: pytest.Item, files: tuple[Path, ...], directory: Path) -> None:
    from axistwin.scenes.reports.page import of_recorded_files, write_page

    outcome, failure = item.stash.get(VERDICT, ("error", ""))
    page = of_recorded_files(item.nodeid, outcome, outcome == "passed", failure.splitlines(), *files)
    directory.mkdir(parents=True, exist_ok=True)
    write_page(page, directory / f"{re.sub(r'[^A-Za-z0-9.]+', '-', item.nodeid).strip('-')}.html")


def _marker_arguments(request: pytest.FixtureRequest) -> tuple[Any, dict[str, Any]]:
    marker = request.node.get_closest_marker("axistwin")
    if marker is None or len(marker.args) + ("scene" in marker.kwargs) != 1:
        raise pytest.UsageError(
            f"invalid marker `axistwin` of the test {request.node.nodeid}: expected a model or a scene, "
            'e.g. @pytest.mark.axistwin("if1") or @pytest.mark.axistwin(scene="cell.toml")'
        )
    keywords = dict(marker.kwargs)
    what = marker.args[0] if marker.args else keywords.pop("scene")
    if isinstance(what, Path) or (isinstance(what, str) and what.endswith(".toml")):
        what = request.path.parent / what
    return what, keywords


def _shown(path: Path) -> str:
    here = Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)
