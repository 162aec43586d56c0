"""Take the screenshots in the README and on the page of the panel: `python tests/panel/browser/pictures.py`."""

import os
import sys
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "panel"))

from browser.conftest import FLAGS, Visit, _shown  # noqa: E402
from browser.using import Panel  # noqa: E402

IMAGES = ROOT / "docs" / "images"


def main():
    with sync_playwright() as playwright:
        playwright.selectors.set_test_id_attribute("data-test")
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        for take in (drill, cut_to_length):
            name = take.__name__.replace("_", "-")
            with _shown(f"examples/{name}/scene.toml", Path(os.devnull)) as address:
                visit = Visit(browser, address, {"width": 1280, "height": 1000})
                visit.page.get_by_text("you drive").wait_for()
                take(Panel(name, visit))
                visit.context.close()
        browser.close()


def drill(panel):
    """Run the drill example to the middle of its second row of holes."""
    panel.begin()
    panel.run_until("table.Y passes 1000")
    panel.run_until("table.output1 rises")
    signals(panel, "table.X.velocity, table.Y.velocity, table.output1, table.input1, table.output4")
    move_on(panel, "table.X passes 5000")
    keep(panel, "panel-drill", 1563)
    keep(panel, "panel", 830)


def cut_to_length(panel):
    """Run the cut-to-length example to the middle of a feed."""
    panel.begin()
    panel.tab("feeder", "Terminal")
    panel.tab("knife", "Program")
    panel.run_until("feeder.X passes 2000")
    signals(panel, "feeder.X.velocity, knife.shaft.position")
    move_on(panel, "feeder.X passes 4300")
    keep(panel, "panel-cut-to-length", 2390)


def signals(panel, names):
    panel.say(panel.region("oscilloscope").get_by_test_id("scope-signals"), names)
    panel.page.mouse.move(0, 0)


def move_on(panel, sentence):
    """Run in real time until `sentence` comes true, and wait until all notifications have disappeared."""
    panel.speed("1")
    panel.run_until(sentence)
    panel.page.get_by_role("alert").first.wait_for(state="hidden")
    panel.page.evaluate("scrollTo(0, 0)")


def keep(panel, name, height):
    """Save a screenshot of the upper part of the page with few colours."""
    data = panel.page.screenshot(full_page=True, clip={"x": 0, "y": 0, "width": 1280, "height": height})
    Image.open(BytesIO(data)).quantize(256).save(IMAGES / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
