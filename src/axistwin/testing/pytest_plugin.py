"""The pytest plug-in: a host under test meets controllers on real ports, in virtual time; see `docs/testing.md`.

    import pytest

    @pytest.mark.axistwin("if1", self_test_s=0.5)           # or scene="cell.toml", or scene={"controller": [...]}
    def test_my_host(axistwin_port, axistwin_clock):
        host = MyHost(axistwin_port)                        # a URL for pyserial; .visa for PyVISA, .address for asyn
        axistwin_clock.advance(1.5)                         # virtual time passes only when told

What is said, and a trace of what moves, are written into the test's `tmp_path` and named in the report of a test that
fails; otherwise they are removed.  Nothing of axistwin is imported before a test asks for one of the fixtures.
"""

from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from axistwin.links.hand import ServedClock
    from axistwin.testing.twin import Twin, Url

KEPT = pytest.StashKey[tuple[Path, ...]]()
FAILED = pytest.StashKey[bool]()
MARKER = (
    "axistwin(what, *, scene=None, speed='manual', **options): the model, or the scene (a path seen from the test's "
    "file, or a dict), that the fixtures axistwin_twin, axistwin_port and axistwin_clock serve."
)


def pytest_configure(config: pytest.Config) -> None:
    """Make the marker known."""
    config.addinivalue_line("markers", MARKER)


@pytest.fixture
def axistwin_twin(request: pytest.FixtureRequest, tmp_path: Path) -> "Iterator[Twin]":
    """The served model or scene that the marker `axistwin` names: ports, bench, advance, run_until, call, start."""
    from axistwin.testing.twin import serve  # late: nothing is imported for those who do not ask

    what, keywords = _asked_for(request)
    kept = request.node.stash[KEPT] = (tmp_path / "axistwin.talk", tmp_path / "axistwin.csv")
    with serve(what, **{"speed": "manual", **keywords}, record=kept[0], trace=kept[1]) as twin:
        yield twin


@pytest.fixture
def axistwin_port(axistwin_twin: "Twin") -> "Url":
    """Where its first controller is reached, as a URL for pyserial."""
    return next(iter(axistwin_twin.ports.values()))


@pytest.fixture
def axistwin_clock(axistwin_twin: "Twin") -> "ServedClock":
    """Its virtual time: `advance(seconds)`, `run_until(condition, timeout)`, `seconds`, `now`."""
    return axistwin_twin.clock


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Name what is kept of a test that has failed; of any other nothing is kept."""
    report = yield
    kept = [path for path in item.stash.get(KEPT, ()) if path.exists()]
    if report.failed and kept:
        item.stash[FAILED] = True
        report.sections.append(("axistwin", "\n".join(f"kept: {_shown(path)}" for path in kept)))
    if report.when == "teardown" and not item.stash.get(FAILED, False):
        for path in kept:
            path.unlink(missing_ok=True)
    return report


def _asked_for(request: pytest.FixtureRequest) -> tuple[Any, dict[str, Any]]:
    """What the marker says: a model or a scene, and options."""
    marker = request.node.get_closest_marker("axistwin")
    if marker is None or len(marker.args) + ("scene" in marker.kwargs) != 1:
        raise pytest.UsageError(
            f'{request.node.nodeid}: say what to serve, one thing: @pytest.mark.axistwin("if1") or (scene="cell.toml")'
        )
    keywords = dict(marker.kwargs)
    what = marker.args[0] if marker.args else keywords.pop("scene")
    if isinstance(what, Path) or (isinstance(what, str) and what.endswith(".toml")):
        what = request.path.parent / what
    return what, keywords


def _shown(path: Path) -> str:
    """Seen from where pytest was started, if it is there."""
    here = Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)
