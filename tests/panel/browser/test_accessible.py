"""Accessibility by axe-core: nothing serious on the page, on its menus and tabs, in both themes, and while stopped."""

import shutil
import subprocess
import tarfile

import pytest

from .conftest import DESK, PHONE, ROOT
from .using import click, on

INSTALLED = ROOT / "node_modules" / "axe-core" / "axe.min.js"
FOUND = """async () => (await axe.run({ resultTypes: ["violations"] })).violations
  .filter(({ impact }) => ["serious", "critical"].includes(impact))
  .map(({ id, nodes }) => [id, ...nodes.map(({ html }) => html.slice(0, 160))])"""


@pytest.fixture(scope="module")
def axe(tmp_path_factory):
    """Return the script of axe-core from `node_modules`, or from the cache of npm; nothing is downloaded."""
    if INSTALLED.exists():
        return INSTALLED.read_text()
    folder = tmp_path_factory.mktemp("axe")
    if shutil.which("npm"):
        subprocess.run(
            ["npm", "pack", "axe-core", "--offline", "--silent"], cwd=folder, capture_output=True, check=False
        )
    packed = next(folder.glob("axe-core-*.tgz"), None)
    if packed is None:
        pytest.skip("axe-core is not on this machine: `npm install --no-save axe-core` lets this test use it")
    with tarfile.open(packed) as archive:
        return archive.extractfile("package/axe.min.js").read().decode()


def none(page, axe):
    page.evaluate(axe)
    assert page.evaluate(FOUND) == []


@on("drill")
def test_axe_finds_nothing_serious(panel, axe):
    panel.moving()
    page = panel.page
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        for size in (DESK, PHONE):
            panel.visit.resize(size)
            none(page, axe)
    page.emulate_media(color_scheme="light")
    panel.visit.resize(DESK)
    for tab in ("Program", "Front panel", "Pins", "Faults", "Terminal"):
        panel.tab("table", tab)
        none(page, axe)
    trigger = page.get_by_role("button", name="Trigger: ").inner_text().partition("\n")[0]  # with the last test's mode
    of_scope = ("Signals", "Presets", trigger, "Lanes", "Cursors", "Save")
    for menu in ("Step", "Speed max", "more controls", *of_scope):
        panel.open(menu)
        none(page, axe)
    panel.close()
    stop = panel.page.get_by_role("button", name="Emergency stop").first
    click(stop)
    panel.state.get_by_text("emergency stop pressed").wait_for()
    none(page, axe)
    click(stop)
