"""`axistwin demo`."""

import re

import pytest
from click.testing import CliRunner

from axistwin.cli.program import axistwin
from axistwin.core.errors import UsageError


@pytest.fixture
def demo(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(axistwin, ["demo", *arguments], catch_exceptions=False).stdout


def test_what_is_said_and_what_moves(demo, tmp_path):
    output = demo()
    said = [re.sub(r"^ +[\d.]+ s  ", "", line) for line in output.splitlines()]
    at = 0
    for line in (
        "> (", "< U<CR>", "> U61<CR>", "> X4000@4000$<CR>", "< 768<CR>", "= X 4000, Y 0", "= X 2000, Y 1000", "= Z 0",
        "< 64<CR>", "< 4888<CR>", "> X-4888$<CR>", "= X 2000", "! power off", "! power on", "= X 800", "= X 0",
        "< [<CR>", "= motor 50000", "< 24576/476<CR>", "< B<CR>", "! shaft.jam on", "< 1<CR>",
    ):  # fmt: skip
        at = next(n for n in range(at, len(said)) if said[n].startswith(line)) + 1
    assert "Drawn in axistwin-demo.png." in output
    assert (tmp_path / "axistwin-demo.png").read_bytes().startswith(b"\x89PNG")
    assert max(map(len, output.splitlines())) <= 90


def test_the_picture_may_be_drawn_elsewhere(demo, tmp_path):
    assert "Drawn in other.svg." in demo("--plot", "other.svg")
    assert "<svg" in (tmp_path / "other.svg").read_text() and not (tmp_path / "axistwin-demo.png").exists()


def test_a_picture_of_no_kind_is_refused_before_anything_happens(demo):
    with pytest.raises(UsageError, match=r"invalid file name 'a\.bmp' for a picture"):
        demo("--plot", "a.bmp")
