"""The page on a phone, a touch screen that is 360 pixels wide: what is folded, seen, reached and kept."""

import re

from playwright.sync_api import expect

from .conftest import DESK, PHONE
from .using import click, on

PALE = r"""() => {
  const numbers = (text) => { const found = text.match(/[\d.]+/g).map(Number); return found.length < 4 ? [...found, 1] : found; };
  const over = (top, below) => [0, 1, 2].map((n) => top[n] * top[3] + below[n] * (1 - top[3]));
  const bright = (colour) => {
    const [r, g, b] = colour.map((n) => (n / 255 <= 0.03928 ? n / 255 / 12.92 : ((n / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (element) => {
    const layers = [];
    for (let each = element; each; each = each.parentElement) layers.push(numbers(getComputedStyle(each).backgroundColor));
    return layers.reverse().reduce((below, layer) => over(layer, below), [255, 255, 255]);
  };
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), found = [];
  while (texts.nextNode()) {
    const text = texts.currentNode.textContent.trim(), element = texts.currentNode.parentElement;
    if (!text || !element.getClientRects().length || element.closest("script, style, [disabled], .disabled, .q-field--disabled, [aria-hidden=true], .skip, .xterm-accessibility, .live-region")) continue;
    const style = getComputedStyle(element), ink = numbers(element.namespaceURI.endsWith("svg") ? style.fill : style.color);
    for (let each = element; each; each = each.parentElement) ink[3] *= getComputedStyle(each).opacity;
    const below = behind(element), both = [bright(over(ink, below)), bright(below)].sort((one, other) => other - one);
    if ((both[0] + 0.05) / (both[1] + 0.05) < 4.5) found.push([text.slice(0, 30), element.className.baseVal ?? element.className]);
  }
  return found;
}"""  # noqa: E501
DARK = f"() => ({PALE})().length === 0"  # at last, after all fade-in and fade-out effects
WIDE = "document.scrollingElement.scrollWidth"
RECORD = """() => {
  document.body.tabIndex = -1;  // from the beginning of the page
  document.body.focus();
  document.body.removeAttribute("tabindex");
  window.focused = [];
  addEventListener("focusin", ({ target }) => window.focused.push(target.id + target.className));
}"""
FOCUSED = "window.focused"
UNREACHED = """() => {
  const controls = 'button, input, textarea, a[href], [role=tab], [role=slider], [role=combobox]';
  const off = '[disabled], [aria-disabled=true], .disabled';
  const within = '[tabindex="0"], .listing, [role=tablist], label';  // where arrow keys lead on
  return [...document.querySelectorAll(controls)]
    .filter((each) => each.offsetParent && !each.disabled && !each.closest(off))
    .filter((each) => each.tabIndex < 0 && !each.querySelector('[tabindex="0"]') && !each.closest(within))
    .map((each) => each.outerHTML.slice(0, 120));
}"""


LAMPS = "front of table"
ORDER = (".q-header", ".above", ".axes", ".desk", ".next", ".switchboard", ".talk", ".scope-card")
"""The parts of a page from top to bottom, by importance."""
TOPS = "(parts) => parts.map((part) => document.querySelector(part).getBoundingClientRect().top)"


@on("drill")
def test_the_rest_is_folded_until_the_user_unfolds_it(phone):
    """This test is the first one of the machine, because `begin` unfolds everything."""
    page = phone.page
    page.set_viewport_size({**PHONE, "width": 390})
    for shown in (phone.clock, phone.state, page.locator(".above"), page.locator(".axis").first):
        expect(shown).to_be_visible()
    assert page.locator(".run").inner_text().split()[-1] in ("Run", "Pause")
    tops = page.evaluate(TOPS, ORDER)
    assert tops == sorted(tops)
    assert page.locator(".desk").bounding_box()["y"] < 740, "the operator's buttons are seen without scrolling"
    part = phone.button("Oscilloscope")
    expect(part).to_have_attribute("aria-expanded", "false")
    expect(page.locator(".scope-plot")).to_be_hidden()
    expect(page.get_by_label(LAMPS)).to_be_hidden()
    phone.tab("table", "Front panel")
    expect(page.get_by_label(LAMPS)).to_be_visible()
    page.set_viewport_size(DESK)
    expect(part).to_be_hidden()
    expect(page.locator(".scope-plot")).to_be_visible()


def test_nothing_is_wider_than_the_screen_and_words_are_dark_enough_and_everything_is_reached_by_tab(phone):
    phone.moving()
    page = phone.page
    assert page.evaluate(UNREACHED) == []
    if phone.machine == "drill":
        leads_around_the_page(page)
    for tab in ("Pins", "Program", "Terminal"):
        phone.tab(phone.facts.who, tab)
        selected = phone.region("conversation").get_by_role("tab", name=tab)
        expect(selected).to_have_attribute("aria-selected", "true")
        assert page.evaluate(WIDE) <= PHONE["width"], tab
        page.wait_for_function(DARK)
    phone.tab(phone.facts.who, "Faults")
    title = phone.region("faults").get_by_role("button", name="Inject a fault")
    click(title)
    assert page.evaluate(WIDE) <= PHONE["width"]
    click(title)
    phone.visit.resize(DESK)
    page.wait_for_function(DARK)


def leads_around_the_page(page):
    """Press Tab until the focus is again where it was first."""
    page.evaluate(RECORD)
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="to the machine")).to_be_focused()
    for _ in range(20):
        for _ in range(20):
            page.keyboard.press("Tab")
        first, *others = page.evaluate(FOCUSED)
        if first in others:
            break
    assert len({first, *others}) > 25


@on("drill")
def test_a_reload_loses_nothing(phone):
    phone.moving()  # everything is unfolded
    phone.visit.resize(DESK)
    said = phone.tab("table", "Terminal").get_by_test_id("terminal table").get_by_role("list")
    expect(said).to_contain_text("4.055104 > [CR")
    lanes = phone.page.locator(".scope-names li")
    phone.signals("table.input3")
    expect(lanes).to_have_count(1)
    before = phone.clock.inner_text(), said.inner_text()
    phone.page.reload()
    expect(phone.clock).to_have_text(before[0])
    expect(lanes).to_have_count(1)
    said.wait_for()
    expect(said).to_have_text(anyhow_wrapped(before[1]), use_inner_text=True)
    phone.signals("table.*")
    phone.visit.resize(PHONE)
    expect(phone.page.locator(".scope-plot")).to_be_visible()


def anyhow_wrapped(text):
    """Return a pattern that matches a text even if the terminal has wrapped its lines."""
    return re.compile(r"\s*".join(["^", *(re.escape(character) for character in "".join(text.split())), "$"]))
