"""The page on a phone: a touch screen that is 360 pixels wide."""

from playwright.sync_api import expect

from .conftest import PHONE
from .using import click, on, quiet

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


def test_nothing_is_wider_than_the_screen_and_everything_is_reached_by_tab(phone):
    phone.begin()
    phone.run_until(phone.facts.moving)
    is_reached_by_tab(phone)
    is_narrow(phone)


FOLDED = ("Switches and lamps", "Host, program and pins", "Front panel", "Oscilloscope", "Faults")
LAMPS = "front of table"


@on("drill")
def test_the_rest_is_folded_until_the_user_unfolds_it(machine, visiting):
    with visiting(machine[1], {**PHONE, "width": 390}) as visit:
        page = visit.page
        page.get_by_text("virtual", exact=False).first.wait_for()
        for shown in (
            page.get_by_test_id("clock"),
            page.get_by_role("button", name="Restart"),
            page.locator(".axis").first,
        ):
            expect(shown).to_be_visible()
        assert page.locator(".run").inner_text().split()[-1] in ("Run", "Pause")
        parts = [page.get_by_role("button", name=name, exact=True) for name in FOLDED]
        for part in parts:
            expect(part).to_have_attribute("aria-expanded", "false")
        hidden = ".switchboard, .terminal, .scope-plot, .speed, .form"
        assert page.locator(hidden).filter(visible=True).count() == 0
        columns = page.locator(".readouts").first.evaluate("(each) => getComputedStyle(each).gridTemplateColumns")
        assert min(float(width.removesuffix("px")) for width in columns.split()) >= 172, "for −17 813 pulses/s"
        lamps = page.get_by_label(LAMPS)
        expect(lamps).to_be_hidden()
        click(parts[2])
        expect(lamps).to_be_visible()
        page.reload()
        quiet(page)
        expect(page.get_by_label(LAMPS)).to_be_visible()
        page.set_viewport_size({"width": 1280, "height": 900})
        expect(parts[0]).to_be_hidden()
        expect(page.locator(".scope-plot")).to_be_visible()


def is_narrow(phone):
    card = phone.region(phone.facts.who)
    for tab in ("Pins", "Program", "Terminal"):
        phone.tab(phone.facts.who, tab)
        expect(card.get_by_role("tab", name=tab)).to_have_attribute("aria-selected", "true")
        assert phone.page.evaluate(WIDE) <= 360, tab
    title = phone.region("faults").get_by_role("button", name="Inject a fault")
    click(title)
    assert phone.page.evaluate(WIDE) <= 360
    click(title)


def is_reached_by_tab(phone):
    assert phone.page.evaluate(UNREACHED) == []
    page = phone.page
    page.evaluate(RECORD)
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="to the machines")).to_be_focused()
    for _ in range(20):
        for _ in range(20):
            page.keyboard.press("Tab")
        first, *others = page.evaluate(FOCUSED)
        if first in others:  # all around the page
            break
    assert len({first, *others}) > 40
