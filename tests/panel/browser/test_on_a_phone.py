"""The page on a phone: a touch screen that is 360 pixels wide."""

from playwright.sync_api import expect

from .using import Panel, click

WIDE = "document.scrollingElement.scrollWidth"
FOCUSED = "((each) => each === document.body ? null : each.id + each.className)(document.activeElement)"
UNREACHED = """() => {
  const controls = 'button, input, textarea, a[href], [role=tab], [role=slider], [role=combobox]';
  const off = '[disabled], [aria-disabled=true], .disabled';
  const within = '[tabindex="0"], .listing, [role=tablist], label';  // where arrow keys lead on
  return [...document.querySelectorAll(controls)]
    .filter((each) => each.offsetParent && !each.disabled && !each.closest(off))
    .filter((each) => each.tabIndex < 0 && !each.querySelector('[tabindex="0"]') && !each.closest(within))
    .map((each) => each.outerHTML.slice(0, 120));
}"""


def test_nothing_is_wider_than_the_screen_and_everything_is_reached_by_tab(machine, panel, visiting):
    panel.begin()
    panel.run_until(panel.facts.moving)
    with visiting(machine[1], width=360, height=740) as visit:
        expect(visit.page.get_by_test_id("clock")).to_have_text(panel.clock.inner_text())
        phone = Panel(machine[0], visit)
        is_reached_by_tab(phone)
        is_narrow(phone)


def is_narrow(phone):
    card = phone.region(phone.facts.who)
    for tab in ("Pins", "Program", "Terminal"):
        phone.tab(phone.facts.who, tab)
        expect(card.get_by_role("tab", name=tab)).to_have_attribute("aria-selected", "true")
        assert phone.page.evaluate(WIDE) <= 360, tab
        phone.visit.keep_picture(f"{phone.machine}-360-{tab}")
    click(phone.region("faults").get_by_role("button", name="Inject a fault"))
    assert phone.page.evaluate(WIDE) <= 360


def is_reached_by_tab(phone):
    assert phone.page.evaluate(UNREACHED) == []
    seen, page = [], phone.page
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="to the machines")).to_be_focused()
    for _ in range(400):
        focused = page.evaluate(FOCUSED)
        if focused is None:
            break
        seen.append(focused)
        page.keyboard.press("Tab")
    assert len(set(seen)) > 40
