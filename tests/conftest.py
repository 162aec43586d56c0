"""What all tests share: a bench, an IF1 on it that is initialised with `U61` and ready, and the flag to re-record.

Every file is `quick` unless it is slow: if only quick tests are asked for, slow files are not even imported.
"""

import gc
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .digiplan.talking import ready

TESTS = Path(__file__).parent
SLOW_FOLDERS = {"panel", "sessions", "basic"}
SLOW_FILES = {
    # programs, pages, pictures and everything together
    "board", "check_fix", "check_formats", "cli", "codes", "demo", "editing", "lsp", "motors", "plot", "plot_trace",
    "record", "run", "serve", "serve_panel", "serve_trace", "term", "traces", "twin", "tutorials", "pytest_plugin",
    "storage", "determinism", "same_instant", "scenes", "x86", "c_hosts", "bus", "pty", "profile", "conversations",
    "fidelity", "machines", "anywhere",
    # IF1 and IF2
    "anything", "at_every_moment", "backlash", "check", "command_list", "control_of_data_transfer", "data_format",
    "initialisation", "inputs", "interpolation", "listing", "ramp", "sequence_properties", "speed", "stored_state",
    # 1810 and 1811
    "closed_loop_maintenance", "home", "manual_stop", "state_machine",
    # SmartMotor
    "arrays", "brake_model", "cam_on_the_fly", "f_functions", "fault_handling", "host_mode", "host_streams",
    "inputs_outputs", "interpreter", "interrupt_roles", "jit", "kernel_properties", "kernel_reference", "modes",
    "overheat", "pieces", "program", "registers", "servo", "servo_reference",
}  # fmt: skip
"""Those that take more than half a second of processor time, by their names without `test_`."""


def pytest_configure() -> None:
    """Keep bytecode, whatever the environment says: each process that a test starts would compile all sources again."""
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def is_slow(path: Path) -> bool:
    folders = path.parts[len(TESTS.parts) :]
    return path.stem.removeprefix("test_") in SLOW_FILES or not SLOW_FOLDERS.isdisjoint(folders)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    return True if config.option.markexpr == "quick" and is_slow(collection_path) else None


def pytest_collection_finish() -> None:
    """Collect garbage less often: the modules of all tests stay, and Python would search them again and again."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 20, 100)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if not is_slow(item.path):
            item.add_marker("quick")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--record-conversations",
        action="store_true",
        help="write what the controllers say now into tests/conversations/*.talk; review the difference",
    )


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def if1(bench: Bench) -> Controller:
    return ready(bench)


@pytest.fixture
def printed(record_property: Callable[[str, object], None]) -> Callable[..., None]:
    """Compare a number that a manual prints with the one that comes out; both go into the fidelity report.

    `printed(section, words, expected, obtained)`: `words` is what the manual says; `within` the tolerance it allows.
    """

    def compare(section: str, words: str, expected: Any, obtained: Any, within: float = 0) -> None:
        row = {"section": section, "words": words, "expected": expected, "obtained": obtained, "within": within}
        record_property("printed", row)
        assert abs(obtained - expected) <= within if within else obtained == expected, f"{section}: {words}"

    return compare
