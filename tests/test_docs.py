"""The documentation builds without a warning, and contains every code and every command of the tables."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from axistwin.bench import product
from axistwin.scenes.diagnostics import codes

ROOT = Path(__file__).resolve().parents[1]
BUILD = """
import gc, sys
from sphinx.builders.html import StandaloneHTMLBuilder
from sphinx.cmd.build import main
gc.disable()
StandaloneHTMLBuilder.search = False
sys.exit(main(sys.argv[1:]))
"""
"""Build the pages without the search index, the typographic quotes and the site's own theme: none of them warns."""

pytest.importorskip("sphinx", reason="the extra [docs] is not installed")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    out = tmp_path_factory.mktemp("site")
    options = ["-W", "--keep-going", "-q", "-D", "html_theme=basic", "-D", "smartquotes=0"]
    build = [sys.executable, "-c", BUILD, *options, ROOT / "docs", out]
    done = subprocess.run(build, capture_output=True, text=True, check=False, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")
    return out


@pytest.mark.slow
def test_every_code_and_every_command_is_listed(site):
    page = (site / "diagnostics.html").read_text(encoding="utf-8")
    missing = [
        rule.code for table in codes.tables().values() for rule in table if f'id="{rule.code.lower()}"' not in page
    ]
    assert missing == []
    rows = len(re.findall("<tr", (site / "generated" / "commands.html").read_text(encoding="utf-8")))
    assert rows == 3 + sum(len(product(model).commands) for model in ("if2", "1811", "smartmotor"))
