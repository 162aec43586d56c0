"""The complete page: tabs, users, terminals, and a controller of another family."""

import json

import pytest
from nicegui import ui

from axistwin.bench import Bench
from axistwin.ui.conversation.conversation import Conversation
from axistwin.ui.panel.context import together
from axistwin.ui.panel.drawings import entries
from axistwin.ui.panel.page import build_views
from axistwin.ui.panel.views.people import people
from axistwin.ui.panel.views.tabs import tabs
from axistwin.ui.panel.views.terminal import terminal

from .showing import bench_of, show, shown


def whole(context):
    return together(*build_views(context))


def said(visit, name):
    entries = visit.context.common(Conversation).log.since(name, 0)[1]
    return b"".join(each.data for each in entries if each.who == ">")


def type_into(visit, mark, text):
    visit.choose(mark, text)
    visit.trigger(mark, "keydown.enter")


@shown(whole, "if1")
def test_the_clock_is_written_without_an_update_of_the_page(visit):
    outbox, clock = visit.user.client.outbox, visit.found("clock")
    visit.run(0.5)
    outbox.updates.clear()
    outbox.messages.clear()
    visit.run(0.5)
    written = f'axistwinState.write(Vue.toRaw(mounted_app.elements), {clock.id}, "1.000000 s")'
    assert clock.id not in outbox.updates
    assert [data["code"] for _, kind, data in outbox.messages if kind == "run_javascript"].count(written) == 1


def of_another_family():
    bench = bench_of("if1")()
    product = bench["if1"].product
    made = {"model": "x9", "title": "Something new", "family": "", "suffix": "", "check": None}
    bench["if1"].product = product._replace(**made, make_front=tuple, programs=())
    return bench


@shown(whole, build=of_another_family)
def test_a_controller_of_which_the_panel_knows_nothing_is_seen_and_touched(visit):
    visit.run(1.5)
    visit.user.find("Front panel").click()
    visit.frame()
    assert visit.found("if1-state-Registers").text == "waiting for ("
    visit.user.find("Pins").click()
    visit.frame()
    visit.press("if1-input2-high")
    assert visit.bench["if1"].pins["input2"].level
    visit.user.find("Terminal").click()
    visit.frame()
    type_into(visit, "say-if1", "(")
    visit.run(0.5)
    assert said(visit, "if1") == b"(\r"
    visit.press("if1-power")
    assert not visit.bench["if1"].powered


def chained():
    bench = Bench()
    motors = [bench.add("smartmotor", name) for name in ("left", "right")]
    bench.chain(*motors, name="both")
    return bench


@shown(whole, build=chained)
def test_a_line_that_motors_share_has_a_terminal_of_its_own(visit):
    visit.run(1)
    visit.user.find("both").click()
    visit.frame()
    type_into(visit, "say-both", "RP")
    assert visit.messages == []


# People


@shown(people, "if1")
def test_who_drives_is_on_the_button_and_taking_over_is_told(visit):
    told = []
    visit.context.people.subscribe(told.append)
    assert visit.found("people").text == "you drive"
    visit.choose("name", "Anna")
    visit.trigger("name", "keydown.enter")
    visit.context.people.take_over(visit.context.people["another"])
    visit.frame()
    assert visit.found("people").text == "visitor 2 drives"
    visit.press("drive")
    assert visit.found("people").text == "you drive"
    assert told == ["visitor 2 drives now", "Anna drives now"]


# Tabs


def test_a_view_is_made_when_it_is_looked_at_and_the_last_one_is_known_again():
    made, fresh = [], []

    def kind(name):
        def make():
            made.append(name)
            return lambda: fresh.append(name)

        return make

    kinds = {"One": kind("One"), "Two": kind("Two")}

    def play(visit):
        assert (made, set(fresh)) == (["One"], {"One"})
        fresh.clear()
        visit.user.find("Two").click()
        visit.frame()
        assert (made, set(fresh)) == (["One", "Two"], {"Two"})
        assert visit.context.person.settings["tab thing"] == "Two"

    show(bench_of("if1"), lambda context: tabs(context, "thing", kinds), play)


# Terminals


@pytest.mark.parametrize("model", ["if1", "smartmotor"])
@shown(terminal)
def test_a_line_goes_out_with_the_end_that_is_chosen_and_is_remembered(visit, model):
    visit.run(1.5)
    visit.context.person.ending = "CR"
    type_into(visit, f"say-{model}", "(")
    assert said(visit, model) == b"(\r" and visit.found(f"say-{model}").value == ""
    assert visit.context.person.lines[model] == ["("]
    type_into(visit, f"say-{model}", r"\x41\r")
    assert said(visit, model) == b"(\rA\r\r"
    with visit.user.client:
        visit.user.find(ui.select).elements.pop().value = "LF"
    type_into(visit, f"say-{model}", "Q")
    assert said(visit, model) == b"(\rA\r\rQ\n"


@pytest.mark.parametrize("model", ["if1", "smartmotor"])
@shown(terminal)
def test_keys_go_out_one_by_one_from_the_screen_itself(visit, model):
    visit.run(1.5)
    visit.press(f"why-{model}")
    for key in "Ra ":
        visit.trigger(f"list-{model}", "keys", key)
    visit.frame()
    assert said(visit, model) == b"Ra "


@shown(terminal, "1811")
def test_a_board_takes_hex_or_words_and_tells_where_they_are_wrong(visit):
    visit.run(1.5)
    type_into(visit, "say-1811", "go_relative 25000")
    type_into(visit, "say-1811", "goo_relative 25000")
    assert "invalid text in column 1 of the line" in visit.messages[-1]
    assert visit.found("say-1811").value == "goo_relative 25000"


@pytest.mark.parametrize("model", ["if1", "smartmotor"])
@shown(terminal)
def test_break_and_format(visit, model):
    visit.run(1.5)
    host, talk = visit.bench[model].serial.host, visit.context.common(Conversation)
    visit.press(f"break-{model}")
    assert [each.text for each in talk.log.since(model, 0)[1] if each.who == ">"] == ["<BREAK 0.25 s>"]
    type_into(visit, f"format-{model}", "2400 7E1")
    assert str(host.format) == "2400 7E1"
    type_into(visit, f"format-{model}", "fast")
    assert "fast" in visit.messages[-1]


@shown(terminal, "if1")
def test_control_lines(visit):
    visit.choose("dtr-if1", False)
    assert not visit.bench["if1"].serial.host.dtr


@pytest.mark.parametrize(("model", "line"), [("if1", "("), ("1811", "go_relative 2500"), ("smartmotor", "Ra ")])
@shown(whole)
async def test_a_reload_loses_nothing(visit, monkeypatch, model, line):
    written = []
    monkeypatch.setattr(entries, "execute", lambda _, code: written.append(code))

    def conversation():
        """Return the last state of each entry that the page has got."""
        sent = (json.loads(code.partition(",[")[2][:-2]) for code in written if '"add"' in code)
        return {entry["number"]: entry for added in sent for entry in added}

    visit.run(1.5)
    visit.user.find("Terminal").click()
    visit.frame()
    type_into(visit, f"say-{model}", line)
    visit.run(0.5)
    visit.choose("scope-signals", f"{model}.host_says")
    visit.press("scope-show")
    shown = visit.found("clock").text, visit.found("scope-signals").value, conversation()
    assert shown[0] == "2.000000 s" and shown[1] == f"{model}.host_says"
    assert any(entry["time"] == "1.500000" for entry in shown[2].values())
    written.clear()
    await visit.reload()
    assert (visit.found("clock").text, visit.found("scope-signals").value, conversation()) == shown
    assert visit.found("people").text == "you drive"


@shown(terminal, "if1")
def test_who_is_connected_from_outside_is_told(visit):
    assert visit.found("client-if1").text == "No host is connected"
