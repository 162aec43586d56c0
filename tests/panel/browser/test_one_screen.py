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
    panel.tab(panel.facts.who, "Terminal")
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
    stop = panel.page.locator(".op.stop")
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


PARTS = ("header", ".machine", ".next", ".desk", ".view", ".switchboard", ".talk", ".scope-card")
HEADER = (".ident", ".what", ".clock", ".run", ".restart", ".steps", ".speed", ".past", ".more")
FONTS = """() => {
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), found = new Set();
  while (texts.nextNode()) {
    const each = texts.currentNode.parentElement;
    if (!each.checkVisibility() || each.closest('.q-icon, svg, style, .nicegui-error-popup, .restart')) continue;
    const { fontFamily, fontSize, fontWeight } = getComputedStyle(each);
    found.add([fontFamily.split(',')[0], fontSize, fontWeight].join(' '));
  }
  return [...found];
}"""
LOOKS = {f"{family} {size}px {weight}" for family in ("Roboto", "ui-monospace") for size in (12, 14, 16, 24)
         for weight in (400, 500)}  # fmt: skip


@on("drill")
def test_each_part_has_its_place(panel):
    """In a low window, the oscilloscope folds to its bar."""
    panel.moving()
    page = panel.page
    panel.visit.resize(SCREEN)
    places = [page.locator(part).first.bounding_box() for part in HEADER]
    assert [place["x"] for place in places] == sorted(place["x"] for place in places)
    header, machine, line, desk, view, pins, talk, scope = (page.locator(part).first.bounding_box() for part in PARTS)
    assert header["height"] < line["y"] < view["y"] == desk["y"] < pins["y"] < scope["y"]
    assert view["x"] < desk["x"] < talk["x"] and scope["width"] > machine["width"] + talk["width"]
    assert machine["height"] * machine["width"] > max(each["height"] * each["width"] for each in (talk, scope))
    page.set_viewport_size({**SCREEN, "height": 800})
    expect(page.locator(".scope-bar")).to_be_in_viewport(ratio=1)
    assert page.locator(".scope-card").bounding_box()["height"] < 48
    assert page.evaluate("document.scrollingElement.scrollHeight") <= 800


@on("drill")
def test_one_family_of_fonts_in_four_sizes_and_two_weights(panel):
    panel.moving()
    for tab in ("Terminal", "Program", "Front panel", "Pins", "Faults"):
        panel.tab("table", tab)
        assert set(panel.page.evaluate(FONTS)) <= LOOKS, tab


@on("drill")
def test_at_most_one_button_is_filled_and_an_emergency_stop_is_seen_to_be_pressed(panel):
    panel.moving()
    stop = panel.page.locator(".op.stop")
    filled = panel.page.locator(".q-btn.bg-primary:visible")
    expect(filled).to_have_count(1)
    expect(filled).to_contain_text("Run")
    for state, pressed, named in (
        ("emergency stop pressed", "true", "Release"),
        ("Stopped after", "false", "Power off"),
    ):
        click(stop)
        panel.state.get_by_text(state).wait_for()
        expect(stop).to_have_attribute("aria-pressed", pressed)
        expect(stop.locator(".down" if pressed == "true" else ".up")).to_be_visible()
        expect(filled).to_have_count(1)
        expect(filled).to_contain_text(named)


@on("drill")
def test_a_menu_hides_a_tooltip_and_a_lost_server_greys_the_page(panel):
    panel.moving()
    page, tip = panel.page, panel.page.locator(".q-tooltip")
    panel.button("Restart", panel.driving).hover()
    tip.wait_for()
    panel.button("Step").press("Enter")
    page.locator(".q-menu").wait_for()
    expect(tip).to_be_hidden()
    page.mouse.move(0, 0)
    panel.close()
    page.evaluate("window.socket.disconnect()")
    page.get_by_role("alert").filter(has_text="No answer since").wait_for()
    expect(page.locator("#app")).to_have_css("pointer-events", "none")
    page.reload()
    expect(page.locator("#gone")).to_be_hidden()
