"""The page of the playground in Chromium, from a folder that `python -m http.server` could serve."""

import os
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest

from axistwin.ui.playground.building import build
from axistwin.ui.playground.link import Shared, encode

from ..panel.browser.test_accessible import axe, none

__all__ = ["axe"]  # a fixture

ENGINE = os.environ.get("AXISTWIN_ENGINE", "")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not ENGINE, reason="AXISTWIN_ENGINE names no folder made by `make engine`"),
]


class Files(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        """Print nothing."""


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    build(folder, Path(ENGINE))
    assert sum(path.stat().st_size for path in folder.rglob("*")) < 27e6
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Files, directory=str(folder)))
    Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as tool:
        yield tool.chromium.launch(executable_path="/usr/bin/chromium-headless-shell", args=["--no-sandbox"])


def begin(page, address):
    """Open the playground, and wait until its first machine is there."""
    page.goto(address)
    page.wait_for_selector("html[data-state=ready]", timeout=50_000)
    return page


def test_a_conversation_and_its_link(address, browser):
    page, foreign = browser.new_page(), []
    page.on("request", lambda request: request.url.startswith((address, "data:")) or foreign.append(request.url))
    begin(page, address)
    page.select_option("#speed", "10")
    page.wait_for_function("() => parseFloat(document.querySelector('#time').textContent) > 2")  # power-up takes 1 s
    shown = "document.querySelector('#machine [data-part={}]').textContent"
    at_rest = f"() => {shown.format('position')} === '4\u2009000' && {shown.format('velocity')} === '0'"
    for line, answer in (("(", "UCR"), ("U61", "U61CR"), ("X4000@1000$", "$CR"), ("K", "0CR")):
        if line == "K":
            page.wait_for_function(at_rest)
        page.fill("#text", line)
        page.press("#text", "Enter")
        page.wait_for_function("words => document.querySelector('.log').textContent.includes(words)", arg=answer)
    assert page.text_content("#state") == "Waiting for a command"
    page.click("#run")
    page.click("#more summary")
    page.click("#share")
    page.wait_for_function("() => document.querySelector('#note').textContent.includes('link')")
    other = begin(browser.new_page(viewport={"width": 390, "height": 844}), page.url)
    other.wait_for_function(
        "time => document.querySelector('#time').textContent === time", arg=page.inner_text("#time")
    )
    assert other.text_content("#machine") == page.text_content("#machine")
    assert other.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert not foreign


def test_a_page_begins_with_the_first_steps_and_a_lesson_and_begins_again(address, browser):
    page = browser.new_page()
    page.goto(address)
    assert page.is_visible("#progress") and page.inner_text("#stage").endswith("…")
    page.wait_for_selector("html[data-state=ready]", timeout=50_000)
    assert not page.is_visible("#progress") and page.inner_text("h1") == "Digiplan IF1 stepper motor interface"
    page.wait_for_function("() => document.querySelector('#words').textContent.startsWith('The IF1 is on')")
    assert page.inner_text("#first h2") == "No messages yet"
    page.click("text=Begin lesson 1")
    page.wait_for_selector("#lesson:not([hidden])")
    page.click("#why")
    page.wait_for_selector(".log [data-who=question] .note")
    page.click("#tab-Front-panel")
    assert page.is_visible("text=Motion status K")
    page.click("#restart")
    page.wait_for_function("() => parseFloat(document.querySelector('#time').textContent) < 1")
    assert page.is_hidden("#lesson")


def test_axe_finds_nothing_serious(address, browser, axe):
    page = begin(browser.new_page(), address)
    none(page, axe)
    page.select_option("#choice", "open_example drill")
    page.wait_for_selector("#operator .stop")
    page.click("#operator .stop")
    page.wait_for_function("() => document.querySelector('#state').textContent.includes('emergency stop pressed')")
    page.click("#more summary")
    page.click("#theme")
    for width in (1440, 390):
        page.set_viewport_size({"width": width, "height": 900})
        none(page, axe)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_damaged_link_is_told_in_a_sentence(address, browser):
    page = begin(browser.new_page(), f"{address}#eJw")
    assert page.inner_text("#note").startswith("the URL of the shared scene is")


OWN = """
import js
from axistwin.devices import Device, Lines, Positioner

js.console.log("own.py runs")

class Own(Device):
    model, title, framing, axes = "own", "A stage of my own", Lines(b"\\r"), {"1": Positioner(velocity=2000)}
"""
SCENE = "[[controller]]\nmodel = 'own'\n"
ASKED = "own.py is Python code, which would run in this page. Open it only if you trust its author."


@pytest.mark.parametrize(("agrees", "after", "title", "told"), [
    (False, [], "Digiplan IF1", "own.py was not run"), (True, ["own.py runs"], "A stage of my own", "")])  # fmt: skip
def test_a_device_in_a_link_runs_only_after_the_user_agrees(address, browser, agrees, after, title, told):
    page, happened = browser.new_page(), []

    def answer(dialog):
        happened.append(dialog.message)
        (dialog.accept if agrees else dialog.dismiss)()

    page.on("console", lambda message: happened.append(message.text))
    page.on("dialog", answer)
    begin(page, f"{address}#{encode(Shared({'scene.toml': SCENE, 'own.py': OWN}, 0))}")
    assert happened == [ASKED, *after]
    assert page.inner_text("h1").startswith(title) and page.inner_text("#note").startswith(told)


@pytest.mark.parametrize("missing", ["Worker", "WebAssembly"])
def test_an_old_browser_is_told_in_a_sentence(address, browser, missing):
    page = browser.new_page()
    if missing == "WebAssembly":
        page.route(
            "**/worker.js", lambda route: route.fulfill(body=_without(missing, route), content_type="text/javascript")
        )
    page.add_init_script(f"delete window.{missing}")
    page.goto(address)
    page.wait_for_function("() => document.querySelector('#note').textContent.includes('current Firefox')")


def _without(name, route):
    return f"delete self.{name};\n" + route.fetch().text()


def test_files_too_large_for_a_page_are_told_in_a_sentence(address, browser):
    page = begin(browser.new_page(), address)
    page.set_input_files("#files", {"name": "big.toml", "mimeType": "text/plain", "buffer": b"#" * 4_000_001})
    page.wait_for_function("() => document.querySelector('#note').textContent.includes('4000001 bytes')")
