"""A panel in a real browser: `axistwin serve SCENE --panel 0` as a program, and Debian's chromium at its page."""

import re
import shutil
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
ARTEFACTS = ROOT / "tests" / "artefacts"
PROGRAM = [sys.executable, "-c", "from axistwin.apps.cli import main; main()", "serve"]
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--force-prefers-reduced-motion",
]  # fmt: skip
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PATIENCE_MS = 20_000
PANEL = re.compile(r"panel on (http://\S+)")


@pytest.fixture(scope="module")
def browser():
    """Debian's chromium, or whatever is called so."""
    path = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if path is None:
        pytest.skip("there is no browser here: install Debian's package chromium to test the panel in one")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        playwright.selectors.set_test_id_attribute("data-test")
        program = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield program
        program.close()


@contextmanager
def _shown(scene, *options):
    """The address of the panel of a scene (a path, or a model's name), served at ten times real time."""
    words = [*PROGRAM, str(scene), "--panel", "0", *options]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT) as program:
        try:
            line = program.stdout.readline()
            assert PANEL.match(line), line + program.stderr.read()
            yield PANEL.match(line)[1]
        finally:
            program.send_signal(signal.SIGTERM)
            _, said = program.communicate(timeout=30)
    assert program.returncode == 0
    assert "Traceback" not in said, said


class Visit:
    """One browser at a panel.  Whatever it asks of other hosts, and whatever goes wrong in it, is remembered."""

    def __init__(self, browser, address, width=1280, height=900):
        self.address = address
        self.context = browser.new_context(viewport={"width": width, "height": height}, accept_downloads=True)
        self.context.set_default_timeout(PATIENCE_MS)
        self.page = self.context.new_page()
        self.asked, self.wrong = set(), []
        self.page.on("request", lambda request: self.asked.add(request.url.split("/")[2]))
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.page.on("console", lambda message: self.wrong.append(message.text) if message.type == "error" else None)
        self.page.goto(address)

    def keep_picture(self, name):
        """A screenshot, as an artefact."""
        ARTEFACTS.mkdir(exist_ok=True)
        self.page.screenshot(path=ARTEFACTS / f"{name}.png", full_page=True)

    def close(self):
        """Leave; nothing has been asked of anybody else."""
        self.context.close()
        assert self.asked <= {self.address.split("/")[2], ""}, self.asked
        assert not self.wrong, self.wrong


@pytest.fixture(scope="module")
def shown(browser):  # without one nothing need be served
    """`with shown(SCENE) as address:` serves it with a panel meanwhile."""
    return _shown


@pytest.fixture(scope="module")
def visiting(browser):
    """`with visiting(address) as visit:` is a browser there, of any size."""

    @contextmanager
    def visit(address, **size):
        one = Visit(browser, address, **size)
        yield one
        one.close()

    return visit
