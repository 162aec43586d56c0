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
    parts: [...document.querySelectorAll('.fold-title')].some(
      (each) => visible(each) && each.ariaExpanded === 'false'),
    open: [...document.querySelectorAll('.q-menu, .q-dialog')].some(visible),
    drives: !document.querySelector('.more').textContent.includes('drives'),
    clock: document.querySelector('[data-test=clock]').innerText,
    state: document.querySelector('[data-test=state]').innerText,
    runs: !document.querySelector('.run').innerText.includes('Run'),
    speed: document.querySelector('.speed').innerText.trim().split('\\n')[0],
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
    """Name of an unconnected input; `lane`: its name on the oscilloscope."""
    lane: str
    says: str
    """Command that is typed at a terminal; `answer`: the controller's answer."""
    answer: str


FACTS = {
    "drill": Facts(who="table", axis="X", moving="table.X passes 1000", pin="input3", lane="Input 3",
                   says="N", answer="0CR"),
    "winder": Facts(who="traverse", axis="motor", moving="traverse.motor passes 1000", pin="trigger2", lane="Trigger 2",
                    says="position_from_absolute_zero", answer=""),
    "cut-to-length": Facts(who="knife", axis="shaft", moving="feeder.X passes 1000", pin="F", lane="knife Pin F",
                           says="RP", answer="CR"),
}  # fmt: skip


class Panel:
    def __init__(self, machine, visit):
        self.machine, self.facts = machine, FACTS[machine]
        self.visit, self.page = visit, visit.page
        self.clock = self.page.get_by_test_id("clock")
        self.driving = self.page.get_by_role("group", name="driving")
        self.header = self.page.get_by_role("banner")
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
        """Open a tab of the conversation with a controller, which is chosen first if there are several."""
        chosen = self.page.locator(".talk-with").get_by_role("tab", name=who, exact=True)
        if chosen.is_visible():
            click(chosen)
        card = self.region(f"conversation of {who}")
        click(card.get_by_role("tab", name=name, exact=True))
        return card.get_by_role("tabpanel").last

    def open(self, name, within=None):
        """Open a menu by its button, and return it."""
        self.close()
        click(self.page.locator(".more") if name == "more controls" else self.button(name, within))
        return self.page.locator(".q-menu").last

    def close(self):
        """Close all menus and dialogs, the upper one first."""
        open_ = self.page.locator(".q-menu, .q-dialog")
        while left := open_.count():
            strike(self.page, "Escape")
            expect(open_).not_to_have_count(left)

    def open_unused(self, who):
        """Unfold the switches and lamps that are neither wired nor named."""
        unused = self.region(who).locator("details.unused")
        if unused.get_attribute("open") is None:
            click(unused.locator("summary"))

    def rarely(self, label, text):
        """Type into a field of the menu of what is rarely used."""
        self.say(self.field(label, self.open("more controls")), text)
        self.close()

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
        expect(self.button("Run", self.driving)).to_be_visible()
        if why:
            expect(self.state).to_contain_text(f"Paused{why}")

    def run(self):
        click(self.button("Run", self.driving))
        expect(self.button("Pause", self.driving)).to_be_visible()

    def pause(self):
        quiet(self.page)
        if self.driving.get_by_role("button", name="Pause").is_visible():
            click(self.button("Pause", self.driving))
        self.paused()

    def go_to(self, seconds):
        self.rarely("go to this moment", f"{seconds}")
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
        usual = {"parts": False, "open": False, "drives": True, "speed": "Speed max", "runs": False}
        if at != {**at, **usual, "state": f"Paused: {self.facts.moving}"}:
            self.begin()
            self.run_until(self.facts.moving)

    def begin(self):
        """Go to time 0, delete the recording, and set the maximum speed; the bench is paused."""
        ready(self.page)
        at = self.page.evaluate(AT)
        if at["open"]:
            self.close()
        if at["parts"]:
            self.page.evaluate(UNFOLD)
            quiet(self.page)
        if not at["drives"]:  # a failed test may have left another driver
            click(self.button("Drive", self.open("more controls")))
            self.close()
        if at["runs"]:
            self.pause()
        if at["clock"] != "0.000000 s" or "Replay" in at["state"]:
            self.go_to(0)
            self.live()
        if at["speed"] != "Speed max":
            self.speed("max")

    def live(self):
        click(self.button("Live from here", self.page.get_by_role("group", name="next")))
        expect(self.state).not_to_contain_text("Replay")

    def step(self, kind):
        before = self.clock.inner_text()
        click(self.open("Step").get_by_role("menuitem", name=f"to the next {kind}"))
        expect(self.clock).not_to_have_text(before)
        self.paused()

    def speed(self, text):
        self.open(self.page.locator(".speed").inner_text().split("\n")[0])
        self.say(self.field("times real time"), text)
        self.close()

    def run_until(self, sentence):
        self.rarely("run until", sentence)
        self.paused(f": {sentence}")

    def signals(self, names):
        """Choose the signals of the oscilloscope."""
        self.open("Signals", self.region("oscilloscope"))
        self.say(self.page.get_by_test_id("scope-signals"), names)
        self.close()


def number(text):
    """Return the first number in a text; it may contain thin spaces and the minus sign U+2212."""
    return float(re.search(r"[−-]?\d[\d\u2009]*(\.\d+)?", text)[0].replace("\u2009", "").replace("−", "-"))


def thumb(slider):
    """Return the part of a slider that can have the focus."""
    return slider.locator("[tabindex='0']")
