"""The motor of `benchmarks/frameworks`: the example of lewis, with its words and its answers."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from axistwin.testing import device_checks

from .made import ask, device_in, on_a_bench

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
Motor = device_in(BENCHMARKS / "frameworks" / "motor_axistwin.py", "Motor")


def test_it_answers_as_the_example_of_lewis():
    bench, controller = on_a_bench(Motor)

    def said(line, seconds=0.0):
        return ask(bench, controller, line + b"\r\n", seconds).decode().splitlines()

    assert [said(line) for line in (b"S?", b"P?", b"T?")] == [["idle"], ["0.0"], ["0.0"]]
    assert said(b"T=10", 1) == ["T=10.0"]
    # 2 mm/s after a ramp of 0.2 s and 0.2 mm
    assert [said(line) for line in (b"S?", b"P?", b"T?", b"T=3")] == [["moving"], ["1.8"], ["10.0"], ["err: not idle"]]
    assert said(b"H") == ["T=1.8,P=1.8"]
    assert [said(line) for line in (b"S?", b"T=251", b"T=-1", b"what")] == [
        ["idle"], ["err: not 0<=T<=250"], ["err: not 0<=T<=250"], [],
    ]  # fmt: skip
    assert said(b"T=0", 1.1 - 1e-9) == ["T=0.0"] and said(b"S?", 1e-8) == ["moving"]  # 1.8/2 + 2/10 s
    assert (said(b"S?"), said(b"P?")) == (["idle"], ["0.0"])


@pytest.mark.parametrize("check", device_checks(Motor))
def test_it_keeps_what_every_device_must(check):
    check()


@pytest.mark.slow
def test_the_benchmark_names_what_is_missing_and_measures_the_rest():
    words = [sys.executable, BENCHMARKS / "device_frameworks.py", "--rounds", "1", "--seconds", "0.01"]
    run = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    for name in ("lewis", "sinstruments", "tickit"):
        assert re.search(rf"^{name}.* (-m pip install {name}$|\d+ )", run.stdout, re.MULTILINE)
    assert re.search(r"^axistwin, speed 1 +27 +[\d,]+ +[\d,]+ +[\d.]+ … [\d.]+$", run.stdout, re.MULTILINE)
