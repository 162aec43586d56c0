"""What all tests share: a bench, an IF1 on it that is initialised with `U61` and ready, and the flag to re-record."""

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
