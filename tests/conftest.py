"""What all tests share: a bench, an IF1 on it that is initialised with `U61` and ready, and the flag to re-record."""

from collections.abc import Callable
from typing import Any

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .digiplan.talking import ready


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
