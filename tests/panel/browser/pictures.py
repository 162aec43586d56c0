"""Take the screenshots in the README and on the page of the panel: `python tests/panel/browser/pictures.py`."""

import os
import sys
from io import BytesIO
from pathlib import Path
from shutil import which

from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "panel"))

from browser.conftest import BROWSERS, FLAGS, Visit, _shown  # noqa: E402
from browser.using import Panel  # noqa: E402

IMAGES = ROOT / "docs" / "images"
SIZE = {"width": 1440, "height": 900}


def main():
    with sync_playwright() as playwright:
        playwright.selectors.set_test_id_attribute("data-test")
        browser = playwright.chromium.launch(executable_path=next(filter(None, map(which, BROWSERS))), args=FLAGS)
        for take in (drill, cut_to_length):
            name = take.__name__.replace("_", "-")
            with _shown(f"examples/{name}/scene.toml", Path(os.devnull)) as address:
                visit = Visit(browser, address, SIZE)
                take(Panel(name, visit))
                visit.context.close()
        browser.close()


def drill(panel):
    """Run the drill example to the middle of its second row of holes."""
    panel.begin()
    panel.run_until("table.Y passes 1000")
    panel.run_until("table.output1 rises")
    move_on(panel, "table.X passes 5000")
    keep(panel, "panel-drill")


def cut_to_length(panel):
    """Run the cut-to-length example to the middle of a feed."""
    panel.begin()
    panel.tab("knife", "Program")
    panel.signals("feeder.X.velocity, knife.shaft.position, knife.D")
    panel.run_until("feeder.X passes 2000")
    move_on(panel, "feeder.X passes 4300")
    keep(panel, "panel-cut-to-length")


def move_on(panel, sentence):
    """Run in real time until `sentence` comes true, and wait until all notifications have disappeared."""
    panel.speed("1")
    panel.run_until(sentence)
    panel.page.get_by_role("alert").first.wait_for(state="hidden")
    panel.page.get_by_role("button", name="Undo").wait_for(state="hidden")
    panel.page.add_style_tag(content=".late { display: none; }")  # It is the computer of the pictures that is late.
    panel.page.mouse.move(0, 0)


def keep(panel, name):
    """Save a screenshot of the page with few colours."""
    data = panel.page.screenshot()
    Image.open(BytesIO(data)).quantize(256).save(IMAGES / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
