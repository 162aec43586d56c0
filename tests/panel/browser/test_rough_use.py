"""Unusual input, and accessibility: focus, contrast and use by keyboard."""

from playwright.sync_api import expect

from .using import on

RINGED = """() => {
  const focused = document.activeElement, {outlineStyle, boxShadow} = getComputedStyle(focused.closest(".q-field__control") ?? focused);
  return outlineStyle !== "none" || boxShadow !== "none" || focused.outerHTML;
}"""  # noqa: E501


@on("drill")
def test_tab_leads_into_a_terminal_and_out_again(panel):
    panel.moving()
    who = panel.facts.who
    screen = panel.tab(who, "Terminal").get_by_test_id(f"terminal {who}")
    screen.focus()
    panel.page.keyboard.press("Tab")
    expect(panel.field(f"say to {who}")).to_be_focused()
    panel.page.keyboard.press("Shift+Tab")
    expect(screen).to_be_focused()
    panel.page.keyboard.press("Shift+Tab")
    expect(screen).not_to_be_focused()


@on("drill")
def test_a_message_is_wrapped_before_the_steps_of_a_program(panel):
    panel.moving()
    who, page = panel.facts.who, panel.page
    panel.tab(who, "Terminal")
    said = page.get_by_test_id(f"terminal {who}")
    inside = "box => box.scrollWidth <= box.clientWidth"
    lines = "box => [...box.querySelectorAll('b')].filter(each => each.getClientRects().length > 1).length"
    for width in (1280, 700, 1000):
        page.set_viewport_size({"width": width, "height": 900})
        assert said.evaluate(inside) and said.evaluate(lines) == 0
    page.set_viewport_size({"width": 1280, "height": 900})


@on("drill")
def test_what_has_the_focus_is_seen_to_have_it(panel):
    panel.moving()
    panel.page.get_by_role("link", name="to the machine").focus()
    for _ in range(20):
        panel.page.keyboard.press("Tab")
        assert panel.page.evaluate(RINGED) is True
