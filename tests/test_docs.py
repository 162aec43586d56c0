"""The documentation builds without a warning, and contains every code and every command of the tables."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from axistwin.bench import product
from axistwin.diagnostics import codes

ROOT = Path(__file__).resolve().parents[1]

pytest.importorskip("sphinx", reason="the extra [docs] is not installed")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    out = tmp_path_factory.mktemp("site")
    theme = ["-D", "html_theme=basic"]  # a quarter of the time is the site's own theme, which has no effect on warnings
    build = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", *theme, ROOT / "docs", out]
    done = subprocess.run(build, capture_output=True, text=True, check=False, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")
    return out


@pytest.mark.timeout(240)
def test_every_code_and_every_command_is_listed(site):
    page = (site / "diagnostics.html").read_text(encoding="utf-8")
    missing = [
        rule.code for table in codes.tables().values() for rule in table if f'id="{rule.code.lower()}"' not in page
    ]
    assert missing == []
    text = (site / "generated" / "commands.html").read_text(encoding="utf-8")
    rows = len(re.findall("<tr", text))
    assert rows == 3 + sum(len(product(model).commands) for model in ("if2", "1811", "smartmotor"))
