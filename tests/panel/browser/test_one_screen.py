"""One screen of 1440 × 900 pixels without scrolling, with lanes and targets that are large enough."""

from playwright.sync_api import expect

SCREEN = {"width": 1440, "height": 900}
HEIGHTS = "(lanes) => lanes.filter((each) => !each.classList.contains('folded')).map((each) => each.offsetHeight)"
SMALL = """() => [...document.querySelectorAll(
    'button, summary, input, a[href], [role=tab], [role=slider], [role=checkbox], [role=switch]')]
  .filter((each) => each.getClientRects().length && !each.closest('.skip'))
  .map((each) => [each, (each.closest('.q-field__control') ?? each).getBoundingClientRect()])
  .filter(([_, { width, height }]) => width < 24 || height < 24)
  .map(([each]) => each.outerHTML.slice(0, 120))"""


def test_everything_is_on_one_screen(panel):
    panel.moving()
    page = panel.page
    panel.visit.resize(SCREEN)
    assert page.evaluate("document.scrollingElement.scrollHeight") <= SCREEN["height"]
    header = page.locator("header")
    expect(header).to_have_count(1)
    assert header.bounding_box()["height"] <= 56
    for part in ("machine", "conversation", "oscilloscope"):
        box = panel.region(part).bounding_box()
        assert box["y"] >= 56 and box["y"] + box["height"] <= SCREEN["height"], part
    assert page.locator(".next").bounding_box()["height"] == 48
    heights = page.locator(".scope-names li").evaluate_all(HEIGHTS)
    assert heights and min(heights) >= 28
    assert page.evaluate(SMALL) == []
