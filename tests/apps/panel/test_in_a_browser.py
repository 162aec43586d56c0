"""Every control of the panel used once, in a real browser, on each of the example machines."""

import re

import pytest

expect = pytest.importorskip("playwright.sync_api").expect

SCENES = {
    "drill": ("table",),
    "winder": ("traverse",),
    "cut-to-length": ("feeder", "knife"),
}
pytestmark = pytest.mark.timeout(240)


@pytest.fixture(scope="module", params=SCENES)
def machine(request, shown):
    """One of the examples, served with a panel."""
    with shown(f"examples/{request.param}/scene.toml") as address:
        yield request.param, address


@pytest.fixture
def page(machine, visiting):
    with visiting(machine[1]) as visit:
        expect(visit.page.get_by_test_id("clock")).to_have_text(re.compile(r"\d+\.\d{3} s"))
        yield visit.page


def button(page, name):
    return page.get_by_role("button", name=name, exact=True)


def moment(page):
    return float(page.get_by_test_id("clock").inner_text().removesuffix(" s"))


def state(page):
    return page.get_by_role("status")


def test_it_is_marked_virtual_and_time_passes(page):
    expect(page.get_by_text("VIRTUAL", exact=True)).to_be_visible()
    began = page.get_by_test_id("clock").inner_text()
    expect(page.get_by_test_id("clock")).not_to_have_text(began)


def test_pause_and_run(page):
    button(page, "Pause").click()
    expect(state(page)).to_contain_text("stands")
    stood = page.get_by_test_id("clock").inner_text()
    button(page, "event").click()
    expect(page.get_by_test_id("clock")).not_to_have_text(stood)
    expect(state(page)).to_contain_text("stands")
    button(page, "Run").click()
    expect(state(page)).to_contain_text("running")
