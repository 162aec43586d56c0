"""Helpers that use the panel as users do, and find controls by their labels."""

import re
from dataclasses import dataclass

import pytest
from playwright.sync_api import expect

PATIENCE_MS = 240_000
QUIET = """async ([states, patience, frame]) => {
  if (frame) await new Promise(requestAnimationFrame);
  const state = () => document.body.dataset.state;
  if (states.includes(state())) return;
  await new Promise((resolve, reject) => {
    const late = setTimeout(() => reject(new Error(`the page is ${state()}`)), patience);
    const changes = new MutationObserver(() => {
      if (!states.includes(state())) return;
      changes.disconnect();
      clearTimeout(late);
      resolve();
    });
    changes.observe(document.body, { attributeFilter: ["data-state"] });
  });
}"""
AT = """() => {
  const visible = (each) => each?.getClientRects().length > 0;
  return {
    folded: visible(document.querySelector('button.more')) && !visible(document.querySelector('.speed-box')),
    parts: [...document.querySelectorAll('.fold-title')].some(
      (each) => visible(each) && each.ariaExpanded === 'false'),
    open: [...document.querySelectorAll('.q-menu, .q-dialog')].some(visible),
    drives: [...document.querySelectorAll('button')].some(
      (each) => visible(each) && each.innerText.includes('you drive')),
    clock: document.querySelector('[data-test=clock]').innerText,
    state: document.querySelector('[data-test=state]').innerText,
    speed: document.querySelector('[aria-label="times real time"]').value,
  };
}"""
"""Returns where a page is; one message to the browser instead of one for each question."""

UNFOLD = """() => {
  for (const each of document.querySelectorAll('.fold-title[aria-expanded=false]')) each.click();
}"""

expect.set_options(timeout=PATIENCE_MS)


def on(*machines):
    return pytest.mark.parametrize("machine", machines, indirect=True)


def quiet(page):
    """Wait until the page has handled all messages and shows the present state."""
    page.evaluate(QUIET, [("quiet", "running"), PATIENCE_MS, True])


def ready(page, *states):
    """Wait as `quiet` does, but without waiting for a frame if the page is quiet now; used before an act."""
    page.evaluate(QUIET, [states or ("quiet", "running"), PATIENCE_MS, False])


def click(locator):
    """Click an element on a quiet page, and wait until the page is quiet again."""
    ready(locator.page)
    locator.click()
    quiet(locator.page)


def press(locator, key):
    """Press a key on an element, with the same waits as in `click`."""
    ready(locator.page)
    locator.press(key)
    quiet(locator.page)


def strike(page, key):
    """Press a key on the element that has the focus, with the same waits as in `click`."""
    ready(page)
    page.keyboard.press(key)
    quiet(page)


@dataclass(frozen=True)
class Facts:
    who: str
    """Name of a controller with a stored program."""
    axis: str
    moving: str
    """Sentence that comes true in the middle of a motion."""
    pin: str
    """Name of an unconnected input."""
    says: str
    """Command that is typed at a terminal; `answer`: the controller's answer."""
    answer: str


FACTS = {
    "drill": Facts(who="table", axis="X", moving="table.X passes 1000", pin="input3", says="N", answer="0CR"),
    "winder": Facts(who="traverse", axis="motor", moving="traverse.motor passes 1000", pin="trigger2",
                    says="position_from_absolute_zero", answer=""),
    "cut-to-length": Facts(who="knife", axis="shaft", moving="feeder.X passes 1000", pin="F", says="RP", answer="CR"),
}  # fmt: skip


class Panel:
    def __init__(self, machine, visit):
        self.machine, self.facts = machine, FACTS[machine]
        self.visit, self.page = visit, visit.page
        self.clock = self.page.get_by_test_id("clock")
        self.driving = self.page.get_by_role("toolbar", name="driving")
        self.time = self.page.get_by_role("toolbar", name="time")
        self.state = self.page.get_by_test_id("state")

    def button(self, name, within=None):
        return (within or self.page).get_by_role("button", name=name, exact=True)

    def field(self, name, within=None):
        return (within or self.page).get_by_role("textbox", name=name, exact=True)

    def say(self, field, text):
        field.fill(text)
        press(field, "Enter")

    def region(self, name):
        return self.page.get_by_role("region", name=name, exact=True)

    def tab(self, who, name):
        card = self.region(who)
        click(card.get_by_role("tab", name=name, exact=True))
        return card.get_by_role("tabpanel").last

    def choose(self, label, option, within=None):
        click((within or self.page).get_by_role("combobox", name=label, exact=True))
        click(self.page.get_by_role("option", name=option, exact=True))

    def message(self, words):
        self.page.get_by_role("alert").filter(has_text=words).last.wait_for()

    # Time

    @property
    def seconds(self):
        return float(self.clock.inner_text().removesuffix(" s"))

    def paused(self, why=""):
        ready(self.page, "quiet")
        expect(self.state).to_contain_text(f"paused{why}")

    def run(self):
        click(self.button("Run", self.driving))
        expect(self.state).to_contain_text("running")

    def pause(self):
        quiet(self.page)
        if self.driving.get_by_role("button", name="Pause").is_visible():
            click(self.button("Pause", self.driving))
        self.paused()

    def go_to(self, seconds):
        self.say(self.field("go to this moment"), f"{seconds}")
        expect(self.clock).to_have_text(f"{seconds:.6f} s")
        self.paused()

    def near(self, seconds, within):
        """Wait until the bench is paused at nearly this virtual time."""
        near = "([clock, at, within]) => Math.abs(parseFloat(clock.innerText) - at) <= within"
        self.page.wait_for_function(near, arg=[self.clock.element_handle(), seconds, within])
        self.paused()

    def later_than(self, seconds):
        later = "([clock, at]) => parseFloat(clock.innerText) >= at"
        self.page.wait_for_function(later, arg=[self.clock.element_handle(), seconds])

    def moving(self):
        """Run from time 0 until the machine is in the middle of a motion, unless it is paused there now."""
        ready(self.page)
        at = self.page.evaluate(AT)
        usual = {"folded": False, "parts": False, "open": False, "drives": True, "speed": "max"}
        if at != {**at, **usual, "state": f"paused: {self.facts.moving}"}:
            self.begin()
            self.run_until(self.facts.moving)

    def begin(self):
        """Go to time 0, delete the recording, and set the maximum speed; the bench is paused."""
        ready(self.page)
        at = self.page.evaluate(AT)
        if at["open"]:
            strike(self.page, "Escape")
        if at["folded"]:
            click(self.button("more controls"))
        if at["parts"]:
            self.page.evaluate(UNFOLD)
            quiet(self.page)
        if not at["drives"]:  # a failed test may have left another driver
            click(self.page.get_by_role("button", name="drives").first)
            click(self.button("Drive"))
            strike(self.page, "Escape")
        if not at["state"].startswith("paused"):
            self.pause()
        if at["clock"] != "0.000000 s" or "replaying" in at["state"]:
            self.go_to(0)
            click(self.button("Live from here"))
            expect(self.state).to_have_text("paused")
        if at["speed"] != "max":
            self.speed("max")

    def step(self, kind):
        before = self.clock.inner_text()
        click(self.button(kind))
        expect(self.clock).not_to_have_text(before)
        self.paused()

    def speed(self, text):
        self.say(self.field("times real time"), text)

    def run_until(self, sentence):
        self.say(self.field("run until"), sentence)
        self.paused(f": {sentence}")


def number(text):
    """Return the first number in a text; it may contain thin spaces and the minus sign U+2212."""
    return float(re.search(r"[−-]?\d[\d\u2009]*(\.\d+)?", text)[0].replace("\u2009", "").replace("−", "-"))


def thumb(slider):
    """Return the part of a slider that can have the focus."""
    return slider.locator("[tabindex='0']")
