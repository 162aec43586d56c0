"""Unusual input, and accessibility: focus, contrast and use by keyboard."""

from playwright.sync_api import expect

from .using import click, on

LETTER_BY_LETTER = "(field, text) => { field.value = text; field.dispatchEvent(new Event('input', {bubbles: true})) }"
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
RINGED = """() => {
  const focused = document.activeElement, {outlineStyle, boxShadow} = getComputedStyle(focused.closest(".q-field__control") ?? focused);
  return outlineStyle !== "none" || boxShadow !== "none" || focused.outerHTML;
}"""  # noqa: E501


@on("drill")
def test_tab_leads_into_a_terminal_and_out_again(panel):
    panel.begin()
    who = panel.facts.terminal
    tab = panel.tab(who, "Terminal")
    screen = tab.get_by_test_id(f"terminal {who}").locator("textarea")
    screen.focus()
    panel.page.keyboard.press("Tab")
    expect(panel.field(f"say to {who}")).to_be_focused()
    panel.page.keyboard.press("Shift+Tab")
    expect(screen).to_be_focused()
    panel.page.keyboard.press("Shift+Tab")
    expect(screen).not_to_be_focused()


@on("drill")
def test_a_terminal_is_as_wide_as_there_is_room(panel):
    panel.begin()
    who, page = panel.facts.terminal, panel.page
    panel.tab(who, "Terminal").get_by_test_id(f"terminal {who}")
    inside = "() => [...document.querySelectorAll('.xterm-screen')].every((each) => {"
    inside += " const room = each.closest('.terminal:not(.xterm)').clientWidth;"
    inside += " return !room || (each.clientWidth <= room && each.clientWidth > room - 40); })"
    for width in (1280, 700, 1000):
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_function(inside)
    page.set_viewport_size({"width": 1280, "height": 900})


@on("drill")
def test_what_has_the_focus_is_seen_to_have_it(panel):
    panel.begin()
    panel.page.get_by_role("link", name="to the machines").focus()
    for _ in range(20):
        panel.page.keyboard.press("Tab")
        assert panel.page.evaluate(RINGED) is True


def test_words_are_dark_enough_to_be_read(panel):
    panel.begin()
    panel.run_until(panel.facts.moving)
    for name in ("Pins", "Program", "Terminal"):
        panel.tab(panel.facts.who, name)
        panel.page.wait_for_function(f"() => ({PALE})().length === 0")  # after all fade-in and fade-out effects


@on("drill")
def test_a_text_that_is_no_program_for_its_length_is_not_taken(panel):
    panel.begin()
    click(panel.button("Load…", panel.tab(panel.facts.who, "Program")))
    dialog = panel.page.get_by_role("dialog")
    panel.field("or its text", dialog).evaluate(LETTER_BY_LETTER, ("x" * 1000 + "\n") * 1200)
    click(panel.button("Load", dialog))
    panel.message("the text is too long: expected at most 262,144 characters")
    panel.visit.wrong.clear()  # NiceGUI has logged to the console that the text was too long to send
    click(panel.button("Cancel", dialog))
    dialog.wait_for(state="hidden")
