"""A small instance of `benchmarks/robustness/channel_access.py`: bad clients of an IOC leave the good ones alone."""

import subprocess
import sys

import pytest

from ..campaigns import ROBUSTNESS


@pytest.mark.slow
def test_three_hundred_bad_clients():
    pytest.importorskip("caproto", reason="caproto is not installed")
    ended = subprocess.run(
        [sys.executable, ROBUSTNESS / "channel_access.py", "--clients", "300"], capture_output=True, text=True
    )
    assert ended.stdout.startswith("passed: seed 1: 300 clients"), ended.stdout + ended.stderr
