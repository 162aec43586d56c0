"""Pages and examples import users' names from the public modules alone."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PUBLIC = {f"axistwin{name}" for name in ("", ".devices", ".drivers", ".ophyd", ".sweeps", ".testing")}
OF_ONE_PAGE = {
    "docs/bus.md": "axistwin.links.bus_hosts", "docs/tutorials/c.md": "axistwin.links.bus_hosts",
    "docs/conversations.md": "axistwin.bench.talk",
}  # fmt: skip
"""Where the public modules have no name for a page's tool, in Python: the modules of this tool."""
IMPORT = re.compile(r"^ *(?:from|import) (axistwin[\w.]*)|'from (axistwin[\w.]*)", re.MULTILINE)


def test_pages_and_examples_use_public_names():
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").rglob("*")]
    deep = {
        f"{path.relative_to(ROOT)}: {module}"
        for path in pages
        if path.suffix in (".md", ".py") and "generated" not in path.parts
        for found in IMPORT.findall(path.read_text(encoding="utf-8"))
        for module in ["".join(found)]
        if module not in PUBLIC and not module.startswith(OF_ONE_PAGE.get(path.relative_to(ROOT).as_posix(), "-"))
    }
    assert deep == set()


def test_the_picture_of_the_rooms_shows_the_contract():
    done = subprocess.run(
        [sys.executable, ROOT / "tools" / "rooms.py", "--check"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
