"""Machines and programs in a real browser: parts move, lines are marked, and the keyboard reaches them."""

import re

import pytest

expect = pytest.importorskip("playwright.sync_api").expect
pytestmark = pytest.mark.timeout(240)


@pytest.fixture(scope="module")
def cutter(shown):
    with shown("examples/cut-to-length/scene.toml") as address:
        yield address


@pytest.fixture(scope="module")
def drill(shown):
    with shown("examples/drill/scene.toml") as address:
        yield address


def part(page, label, name):
    """A part of the drawing that is called so to those who cannot see it."""
    return page.get_by_role("img", name=label).locator(f"[data-part={name}]")


def drive(visit):
    """Its page; whoever drove before does so no more."""
    people = visit.page.locator("button.people")
    expect(people).to_have_text(re.compile("you drive|drives"))
    if "you drive" not in people.inner_text():
        people.click()
        visit.page.get_by_role("button", name="Drive", exact=True).click()
        visit.page.keyboard.press("Escape")
    expect(people).to_contain_text("you drive")
    return visit.page


def tab(page, machine, kind):
    page.get_by_test_id(f"tab {machine} {kind}").click()


def test_discs_turn_and_numbers_go_along(cutter, visiting):
    with visiting(cutter) as visit:
        disc = part(visit.page, "X: a shaft", "disc")
        expect(disc).to_have_attribute("style", re.compile(r"rotate\([1-9]\d{2,}"))
        expect(part(visit.page, "external encoder", "edges")).to_have_text(re.compile(r"\d.\d{3}"))
        expect(part(visit.page, "external encoder", "sits-on")).to_have_text("on feeder.X")
        visit.keep_picture("cutter-machines")


@pytest.mark.parametrize("width", [1280, 360])
def test_nothing_is_wider_than_the_page(cutter, drill, visiting, width):
    for address, machines in ((cutter, ("feeder", "knife")), (drill, ("table",))):
        with visiting(address, width=width) as visit:
            for machine in machines:
                tab(visit.page, machine, "Program")
            expect(visit.page.get_by_role("img").first).to_be_visible()
            assert visit.page.evaluate("document.documentElement.scrollWidth") <= width
            visit.keep_picture(f"machines-{machines[0]}-{width}")


def test_breaks_are_made_with_mouse_and_keys_and_found_again_after_a_reload(cutter, visiting):
    with visiting(cutter) as visit:
        page = drive(visit)
        tab(page, "knife", "Program")
        listing = page.get_by_test_id("listing knife")
        first = listing.get_by_role("button", name="break at line 1: UC=1")
        third = listing.get_by_role("button", name="break at line 3: UG=1")
        first.click()
        expect(first).to_have_attribute("aria-pressed", "true")
        for key in ("ArrowDown", "ArrowDown", "Enter"):
            page.keyboard.press(key)
        expect(third).to_have_attribute("aria-pressed", "true")
        expect(third).to_be_focused()
        page.reload()
        expect(third).to_have_attribute("aria-pressed", "true")
        for number in (first, third):
            number.click()
            expect(number).to_have_attribute("aria-pressed", "false")


def test_the_running_line_is_marked_and_in_view_also_when_one_comes_back_to_its_tab(cutter, visiting):
    with visiting(cutter) as visit:
        page = drive(visit)
        tab(page, "knife", "Program")
        listing = page.get_by_test_id("listing knife")
        page.get_by_role("button", name="Off and on").click()
        running = listing.locator("[aria-current=step]")
        expect(running).to_be_visible()
        tab(page, "knife", "Pins")
        expect(listing).to_be_hidden()
        tab(page, "knife", "Program")
        page.wait_for_function("""() => {
            const row = document.querySelector('[data-test="listing knife"] .running');
            if (!row) return false;
            const line = row.getBoundingClientRect(), box = row.closest(".listing").getBoundingClientRect();
            return line.top >= box.top && line.bottom <= box.bottom;
        }""")


def test_three_dimensions_are_made_when_they_are_wanted_and_kept(drill, visiting):
    with visiting(drill) as visit:
        page = drive(visit)
        expect(part(page, "X, Y from above", "head")).to_have_attribute("style", re.compile("translate"))
        expect(page.locator(".solid canvas")).to_have_count(0)
        page.get_by_role("switch", name="3-D").click()
        expect(page.locator(".solid canvas")).to_be_visible()
        page.get_by_role("button", name="turn left").click()
        page.reload()
        expect(page.locator(".solid canvas")).to_be_visible()
        page.get_by_role("switch", name="3-D").click()
        expect(page.locator(".solid canvas")).to_have_count(0)


def test_a_program_is_pasted_and_runs(cutter, visiting):
    with visiting(cutter) as visit:
        page = drive(visit)
        tab(page, "knife", "Program")
        page.get_by_role("button", name="Load\u2026").click()
        page.get_by_label("or its text").fill("a=1\nWHILE 1\na=a+1\nLOOP\n")
        page.get_by_role("button", name="Load", exact=True).click()
        listing = page.get_by_test_id("listing knife")
        expect(listing.locator("li")).to_have_count(4)
        expect(listing.locator("[aria-current=step]")).to_be_visible()
