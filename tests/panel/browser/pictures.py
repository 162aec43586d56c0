"""Take pictures of the panel.

`python tests/panel/browser/pictures.py` renews those in the README and in docs; with a folder, and names of cases if
not all, it takes them at both sizes and in both themes: `pictures.py /tmp/pictures drill emergency_stop`.
"""

import os
import sys
from io import BytesIO
from pathlib import Path
from shutil import which

from PIL import Image
from playwright.sync_api import expect, sync_playwright

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "panel"))

from browser import conftest  # noqa: E402
from browser.using import Panel, click, quiet  # noqa: E402

conftest.PROGRAM[-1:-1] = ["--device", "examples/devices/esp300.py"]
IMAGES = ROOT / "docs" / "images"
SIZES = {"desk": {"width": 1440, "height": 900}, "phone": {"width": 390, "height": 844}}


def main(folder="", *cases):
    os.makedirs(folder or IMAGES, exist_ok=True)
    with sync_playwright() as playwright:
        playwright.selectors.set_test_id_attribute("data-test")
        path = next(filter(None, map(which, conftest.BROWSERS)))
        browser = playwright.chromium.launch(executable_path=path, args=conftest.FLAGS)
        for take in [CASES[name] for name in cases] if cases else CASES.values() if folder else (drill, cut_to_length):
            picture(browser, take, folder and Path(folder))
        browser.close()


def picture(browser, take, folder):
    scene = SHOWN.get(take, f"examples/{take.__name__.replace('_', '-')}/scene.toml")
    with conftest._shown(scene, Path(os.devnull)) as address:
        visit = conftest.Visit(browser, address, SIZES["desk"])
        panel = Panel("drill", visit)  # the facts of a machine are not needed
        panel.begin()
        take(panel)
        if not folder:
            keep(panel, IMAGES / f"panel-{take.__name__.replace('_', '-')}.png")
        for size in SIZES if folder else ():
            for theme in ("light", "dark"):
                panel.page.emulate_media(color_scheme=theme)
                visit.resize(SIZES[size])
                keep(panel, folder / f"{take.__name__}-{size}-{theme}.png", full_page=size == "phone")
        visit.context.close()


def drill(panel):
    """Run the drill example to the middle of its second row of holes."""
    panel.run_until("table.Y passes 1000")
    panel.run_until("table.output1 rises")
    move_on(panel, "table.X passes 5000")


def winder(panel):
    """Run the winder example to the middle of a layer."""
    panel.run_until("traverse.motor passes 12000")
    move_on(panel, "traverse.motor passes 6000")


def cut_to_length(panel):
    """Run the cut-to-length example to the middle of a feed."""
    panel.tab("knife", "Program")
    panel.signals("feeder.X.velocity, knife.shaft.position, knife.D")
    panel.run_until("feeder.X passes 2000")
    move_on(panel, "feeder.X passes 4300")


def bare_if1(panel):
    """Show an IF1 that has just been switched on."""
    go_on(panel, 2)


def bare_1811(panel):
    """Show an 1811 that has just been switched on."""
    go_on(panel, 2)


def smartmotor(panel):
    """Show a SmartMotor that does not move, because nothing is connected to its limit inputs."""
    say(panel, "smartmotor", "A=100 V=100000 P=1000 G")


def emergency_stop(panel):
    """Press the emergency stop of the drill while it moves."""
    drill(panel)
    press_stop(panel)


def released(panel):
    """Release the emergency stop again."""
    emergency_stop(panel)
    press_stop(panel)


def limit_fault(panel):
    """Drive an axis of the X-Y table onto its limit switch."""
    go_on(panel, 2)
    for line in ("(", "U61", ">1 <4 ^20 @4000", "X-900$"):
        say(panel, "table", line)


def esp300(panel):
    """Move two axes of a controller that a file adds."""
    for line in ("1MO;1PA12.5;2MO;2PA-20", "1TP?"):
        say(panel, "esp300", line)


CASES = {take.__name__: take for take in (
    drill, winder, cut_to_length, bare_if1, bare_1811, smartmotor, emergency_stop, released, limit_fault, esp300,
)}  # fmt: skip
SHOWN = {
    bare_if1: "if1", bare_1811: "1811", smartmotor: "smartmotor", limit_fault: "examples/xy-table.toml",
    emergency_stop: "examples/drill/scene.toml", released: "examples/drill/scene.toml", esp300: "esp300",
}  # fmt: skip


def say(panel, who, line):
    panel.say(panel.field(f"say to {who}"), line)
    go_on(panel, 2)


def press_stop(panel):
    click(panel.region("operator panel").get_by_role("button", name="Emergency stop"))
    go_on(panel, 2)


def go_on(panel, seconds):
    """Run for some seconds, and leave the machine running."""
    if panel.button("Run", panel.driving).is_visible():
        panel.speed("1")
        panel.run()
    panel.later_than(panel.seconds + seconds)
    settle(panel)


def move_on(panel, sentence):
    """Run in real time until `sentence` comes true."""
    panel.speed("1")
    panel.run_until(sentence)
    settle(panel)


def settle(panel):
    """Wait until all notifications have disappeared."""
    expect(panel.page.get_by_role("alert")).to_have_count(0)
    panel.page.get_by_role("button", name="Undo").wait_for(state="hidden")
    # The computer of the pictures is late; and a picture of a whole page shows what is below the window.
    panel.page.add_style_tag(content=".late { display: none; } .log li { content-visibility: visible !important; }")
    panel.page.mouse.move(0, 0)


def keep(panel, path, **options):
    """Save a screenshot of the page with few colours."""
    quiet(panel.page)
    data = panel.page.screenshot(**options)
    Image.open(BytesIO(data)).quantize(256).save(path, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
