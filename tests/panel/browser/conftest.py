"""A panel in a real browser: `axistwin serve SCENE --panel 0` as a program, and Debian's chromium at its page."""

import re
import shutil
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from .using import PATIENCE_MS, Panel, quiet

ROOT = Path(__file__).resolve().parents[3]
ARTEFACTS = ROOT / "tests" / "artefacts"
PROGRAM = [sys.executable, "-c", "from axistwin.cli.program import main; main()", "serve"]
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--force-prefers-reduced-motion",
    "--in-process-gpu", "--js-flags=--no-opt --no-maglev",
]  # fmt: skip
"""Flags of chromium.  No page is open for so long that it would pay to optimise its scripts."""
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
STILL = """addEventListener("DOMContentLoaded", () => {
  const style = document.createElement("style");
  style.textContent = "*, ::before, ::after { transition-duration: 0s !important; animation-duration: 0s !important; }";
  document.head.append(style);
});"""
"""Disables transitions on the page."""
PANEL = re.compile(r"panel on (http://\S+)")
SCENES = ("drill", "winder", "cut-to-length")
DESK, PHONE = {"width": 1280, "height": 900}, {"width": 360, "height": 740}
"""Sizes of a page."""


OPENS = "test_it_is_marked_virtual_and_runs_and_steps"
"""The test that shows that the page opens; all others are slow."""


@pytest.hookimpl(tryfirst=True)  # this must run before `-m` selects
def pytest_collection_modifyitems(items):
    """Put the tests in a browser last, grouped by machine: the first test of a machine starts its program."""
    here = Path(__file__).parent
    inside = [item for item in items if item.path.is_relative_to(here)]
    for item in inside:
        item.add_marker(pytest.mark.browser)
        if not item.name.startswith(OPENS):
            item.add_marker(pytest.mark.slow)
    items[:] = [*(item for item in items if item not in inside), *sorted(inside, key=_order)]


def _order(item):
    parameters = item.callspec.params if hasattr(item, "callspec") else {}
    place = SCENES.index(parameters["machine"]) if "machine" in parameters else len(SCENES)
    return place, "phone" not in item.fixturenames


@pytest.fixture(scope="package")
def browser():
    path = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if path is None:
        pytest.skip(
            "there is no browser here: install Debian's package chromium-headless-shell to test the panel in one"
        )
    playwright_of = pytest.importorskip("playwright.sync_api", reason="the panel is tested with playwright")
    with playwright_of.sync_playwright() as playwright:
        playwright.selectors.set_test_id_attribute("data-test")
        program = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield program
        program.close()


@contextmanager
def _shown(scene, messages, *options):
    """Serve a scene with a panel, and yield the panel's address.  `messages`: the file that receives stderr."""
    words = [*PROGRAM, str(scene), "--panel", "0", *options]
    with (
        messages.open("w") as stderr,
        subprocess.Popen(words, stdout=subprocess.PIPE, stderr=stderr, text=True, cwd=ROOT) as program,
    ):
        try:
            line = program.stdout.readline()
            assert PANEL.match(line), line + messages.read_text()
            yield PANEL.match(line)[1]
        finally:
            program.send_signal(signal.SIGTERM)
            program.communicate(timeout=300)
    assert program.returncode == 0
    said = messages.read_text()
    assert "Traceback" not in said, said


class Visit:
    """One browser at a panel.  Its requests to other hosts and its errors are recorded."""

    def __init__(self, browser, address, size=DESK):
        self.address = address
        self.context = browser.new_context(viewport=size, accept_downloads=True)
        self.context.set_default_timeout(PATIENCE_MS)
        self.context.add_init_script(STILL)
        self.page = self.context.new_page()
        self.asked, self.wrong = set(), []
        self.page.on("request", lambda request: self.asked.add(request.url.split("/")[2]))
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.page.on("console", lambda message: self.wrong.append(message.text) if message.type == "error" else None)
        self.page.goto(address)
        quiet(self.page)

    def resize(self, size):
        if self.page.viewport_size != size:
            self.page.set_viewport_size(size)

    def keep_picture(self):
        ARTEFACTS.mkdir(exist_ok=True)
        self.page.screenshot(path=ARTEFACTS / "failed.png", full_page=True)

    def close(self):
        """Close the page, and check that it has sent no requests to other hosts."""
        self.context.close()
        assert self.asked <= {self.address.split("/")[2], ""}, self.asked
        assert not self.wrong, self.wrong


@pytest.fixture(scope="package")
def shown(browser):  # without a browser nothing need be served
    return _shown


@pytest.fixture(scope="package")
def visiting(browser):
    """Return a context manager: `with visiting(address) as visit:` opens a page of any size."""

    @contextmanager
    def visit(address, size=DESK):
        one = Visit(browser, address, size)
        try:
            yield one
        except BaseException:
            one.keep_picture()
            one.context.close()
            raise
        one.close()

    return visit


@pytest.fixture(scope="package", params=SCENES)
def machine(request, shown, tmp_path_factory):
    """Serve an example with a panel; yield its name, its address, and the directory of what it writes."""
    name, written = request.param, tmp_path_factory.mktemp("written")
    traced = ("--trace", str(written / "first.csv"), "--record", str(written / "first.talk")) if name == "drill" else ()
    with shown(f"examples/{name}/scene.toml", written / "stderr", "--speed", "0.1", *traced) as address:
        yield name, address, written


@pytest.fixture(scope="package")
def driver(machine, visiting):
    """Open the driver's page for all tests of a machine, on a phone; later it is resized."""
    with visiting(machine[1], PHONE) as visit:
        yield visit


@pytest.fixture
def panel(machine, driver):
    return _panel(machine, driver, DESK)


@pytest.fixture
def phone(machine, driver):
    return _panel(machine, driver, PHONE)


def _panel(machine, driver, size):
    driver.resize(size)
    return Panel(machine[0], driver)
