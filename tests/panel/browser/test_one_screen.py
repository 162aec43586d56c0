"""One screen of 1440 × 900 pixels without scrolling, with lanes and targets that are large enough; nothing shifts."""

from playwright.sync_api import expect

from .using import click, on

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


SHIFTED = """async () => {
  const found = [];
  const at = ({ x, y }) => `${x}, ${y}`;
  const told = ({ node, previousRect, currentRect }) =>
    [(node?.parentElement ?? node)?.outerHTML.slice(0, 120), at(previousRect), at(currentRect)];
  new PerformanceObserver((list) => found.push(...list.getEntries().map(({ sources }) => sources.map(told))))
    .observe({ type: "layout-shift", buffered: true });
  for (let frame = 0; frame < 3; frame += 1) await new Promise(requestAnimationFrame);
  return found;
}"""
"""Returns all layout shifts since the page was opened, also those after an act of the user."""
MOVED = """() => {
  const were = window.places ?? {}, now = {};
  for (const each of document.querySelectorAll('button:not(.act), summary, [role=tab]'))
    if (each.offsetParent) now[each.innerText.split('\\n')[0]] = JSON.stringify(each.getBoundingClientRect());
  window.places = now;
  return Object.keys(now).filter((each) => each in were && were[each] !== now[each]);
}"""
"""Returns the buttons that are not where they were at the call before, except those that a state offers."""


@on("drill", "winder")
def test_nothing_shifts_while_a_page_opens_and_in_a_minute(machine, panel, visiting):
    panel.begin()
    with visiting(machine[1], SCREEN) as other:
        panel.speed("20")
        panel.run()
        panel.later_than(60)
        assert other.page.evaluate(SHIFTED) == []
    panel.pause()


def test_nothing_shifts_on_an_if1_from_the_first_command_to_the_end_of_a_move(shown, visiting, tmp_path):
    with shown("if1", tmp_path / "stderr") as address, visiting(address, SCREEN) as visit:
        click(visit.page.get_by_role("button", name="Initialise", exact=True).first)
        click(visit.page.get_by_role("button", name="Send X1000$", exact=True))
        visit.page.get_by_role("region", name="if1", exact=True).get_by_text("1\u2009000").wait_for()
        visit.page.get_by_text("Waiting for a command").wait_for()
        assert visit.page.evaluate(SHIFTED) == []


@on("drill")
def test_no_button_moves_while_the_operator_stops_the_machine_and_starts_it_again(machine, panel, visiting):
    panel.moving()
    panel.speed("1")
    panel.visit.resize(SCREEN)
    panel.run()
    stop = panel.page.get_by_role("button", name="Emergency stop").first
    power = panel.button("Power off and on", panel.page.get_by_role("group", name="next"))
    panel.page.evaluate(MOVED)
    for act, state in (
        (stop, "emergency stop pressed"),
        (stop, "Stopped after"),
        (power, "Waiting for input 2 (Start)"),
    ):
        click(act)
        panel.state.get_by_text(state).wait_for()
        assert panel.page.evaluate(MOVED) == []
    panel.pause()
