"""Fixtures of all tests: a bench, and an IF1 that is initialised with `U61`; and the flag to record again.

Every file is `quick` unless it is slow: if only quick tests are requested, slow files are not even imported.
"""

import gc
import marshal
import os
import sys
from collections.abc import Callable, Iterator
from functools import cache
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
SLOW_FOLDERS = {"panel", "sessions", "basic", "drivers", "fmu", "integrations", "probing", "playground"}
SLOW_FILES = {
    "": "determinism docs fidelity numbers readme report storage tutorials",
    "bus_hosts": "x86",
    "cli": "board cli demo ending full_disk learn listening motors other_systems plot record run serve term way_in",
    "compumotor": "closed_loop closed_loop_maintenance closed_loop_stall command_list decisions home interactions"
    " manual_moves manual_programming manual_requests manual_sequences manual_stop moves outputs owners"
    " state_machine streaming streaming_moments",
    "conversations": "golden recorder",
    "diagnostics": "check_agrees check_fix check_formats codes",
    "digiplan": "anything at_every_moment backlash check command_list interpolation listing ramp sequence_properties"
    " stored_state",
    "editor": "editing lsp",
    "examples": "scenes",
    "fault_injection": "anywhere machines triggers",
    "guide": "new shipped",
    "links": "bus c_hosts comport fairness pty repeats rfc2217 tcp telnet urls",
    "motion": "expansion profile step_queue",
    "plant": "machine_units",
    "plots": "plot_trace",
    "robustness": "mutated_files mutation options same_instant",
    "scenes": "scene_happenings",
    "sim": "clock sampling serial",
    "smartmotor": "arrays brake_model brakes cam cam_on_the_fly check decisions_motion encoder_edges f_functions"
    " fault_handling follow host_mode host_streams image inputs_outputs interpreter interrupt_priority"
    " interrupt_returns interrupt_roles interrupts jit kernel_properties kernel_reference limits listing"
    " machine master_on_an_axis modes overheat pieces program program_store registers serial_data servo"
    " servo_reference status_word trajectory",
    "standin": "board driver hal protocol",
    "sweeps": "cluster code_of_others engine journal sensitivity sentences sweeps_page tuning values",
    "testing": "pytest_plugin twin",
    "traces": "trace traces traces_page",
}
"""Files in which a test takes more than 5 ms on average, and all of them a quarter of a second; without `test_`."""


POSIX_ONLY = {"test_pty.py", "test_serialdev.py", "test_term.py"}
"""Files that import modules which Windows does not have; `test_other_systems.py` tests ports and terminals there."""


def pytest_configure() -> None:
    """Keep bytecode, whatever the environment says: otherwise each process of a test compiles all sources again."""
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


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


@cache
def is_slow(path: Path) -> bool:
    *folders, file = path.relative_to(TESTS).with_suffix("").parts
    names = SLOW_FILES.get("/".join(folders), "").split()
    return file.removeprefix("test_") in names or not SLOW_FOLDERS.isdisjoint(folders)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    if sys.platform == "win32" and collection_path.name in POSIX_ONLY:
        return True
    return True if config.option.markexpr == "quick" and is_slow(collection_path) else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if not is_slow(item.path):
            item.add_marker("quick")
    if hasattr(config, "workerinput"):
        items.sort(key=turn)


def turn(item: pytest.Item) -> tuple[int, int]:
    """Return the position of a test if several processes share the work: long units first, short ones last.

    The second unit is a file that compiles the kernel, before a server in another unit needs it.  Files are mixed,
    because the files of one folder often wait for the same kind of event, and the processor would be idle.
    """
    if item.path == COMPILES:
        return 1, 0
    if "browser" in item.path.parts:
        return (0 if unit(item.nodeid).endswith("drill") else 2), 0
    return (3 if is_slow(item.path) else 4), crc32(unit(item.nodeid).encode())


@cache
def unit(nodeid: str) -> str:
    """Return the unit of a test: its file, or all tests in a browser with the drill, or all with other machines.

    Each of these two units starts a browser of its own.
    """
    file, _, rest = nodeid.partition("::")
    if not file.startswith(BROWSER):
        return file
    return f"{BROWSER} {'drill' if 'drill' in rest.partition('[')[2] else 'others'}"


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
