"""The user interface of the oscilloscope on a simulated page; the tests use each control at least once."""

import json
from fractions import Fraction

import pytest

from axistwin import Session
from axistwin.core.units import S
from axistwin.sim.motion.profile import Profile, Segment
from axistwin.ui.panel.context import Common, Context
from axistwin.ui.panel.people import People
from axistwin.ui.panel.scope.frames import frame
from axistwin.ui.panel.scope.screen import Screen
from axistwin.ui.panel.views.scope import Scopes, scope

from .showing import bench_of, show, show_to, shown


def screen_of(visit) -> Screen:
    return visit.context.person.settings["scope"]


def tell(visit, **what):
    """Send a message as the script of the page does for mouse, fingers and keys."""
    layout = visit.user.client.layout
    (listener,) = (listener for listener in layout._event_listeners.values() if listener.type == "scope")
    visit.user.client.handle_event({"id": layout.id, "listener_id": listener.id, "args": [json.dumps(what)]})
    visit.frame()


@shown(scope, "if1", after=1.5)
def test_it_shows_how_axes_move_to_begin_with_and_what_is_chosen_after_that(visit):
    assert visit.found("scope-signals").value.startswith("if1.X.pulses, if1.Y.pulses")
    visit.choose("scope-signals", "if1.X.pulses, *.led")
    visit.press("scope-show")
    assert screen_of(visit).names == ("if1.led", "if1.X.pulses")
    visit.choose("scope-signals", "if1.Q.*")
    visit.press("scope-show")
    assert "no signal matches 'if1.Q.*'" in visit.messages[-1] and screen_of(visit).names == ("if1.led", "if1.X.pulses")


@shown(scope, "if1", after=1.5)
def test_signals_are_searched_in_a_list_and_put_on_and_off(visit):
    visit.choose("scope-search", "X.")
    visit.choose("scope-box-if1.X.velocity", True)
    visit.choose("scope-box-if1.X.pulses", False)
    assert "if1.X.velocity" in screen_of(visit).names and "if1.X.pulses" not in screen_of(visit).names


MACHINE = {"units": {"per": 80, "of": "mm"}, "limits": ("-1 mm", "300 mm")}


def with_unit():
    bench = bench_of("if1", X=MACHINE)()
    bench.wires.append(("if1.output1", "if1.input2"))
    return bench


@shown(scope, build=with_unit)
def test_it_opens_on_what_the_scene_uses_and_offers_presets(visit):
    used = ("if1.X.velocity", "if1.X.pulses", "if1.output1", "if1.input2", "if1.host_says", "if1.controller_says")
    assert screen_of(visit).names == used
    visit.press("scope-preset-Wires")
    assert screen_of(visit).names == ("if1.input2", "if1.output1")
    visit.press("scope-preset-Scene")
    assert screen_of(visit).names == used


@shown(scope, build=with_unit)
def test_values_at_the_pointer_have_units(visit):
    screen_of(visit).show(["if1.X.pulses", "if1.led"])
    visit.choose("scope-measures", True)
    visit.bench["if1"].axes["X"].start(Profile([Segment(Fraction(1000), Fraction(3))]), -1)
    visit.run(2.0005)
    screen_of(visit).span_ns = 2 * S
    tell(visit, do="hover", place=0.5)
    for _ in range(5):
        visit.frame()
    row, other = visit.found("scope-readout").rows
    assert (row["unit"], row["at"], row["now"]) == ("mm (pulses)", "−12.50 (−1000)", "−25.00 (−2000)")
    assert (other["unit"], other["at"]) == ("", other["now"])
    assert visit.found("scope-times").text == "pointer 1.000 s"
    assert frame(screen_of(visit))["signals"][0]["range"] == "\u221226.00 … 0.00"
    assert frame(screen_of(visit))["signals"][0]["now"] == "\u221212.50"
    tell(visit, do="hover", place=None)
    for _ in range(5):
        visit.frame()
    assert visit.found("scope-readout").rows[0]["at"] == "–"


@shown(scope, "if1", after=1.5)
def test_lanes_are_moved_folded_and_renamed(visit):
    screen = screen_of(visit)
    screen.show(["if1.led", "if1.X.pulses", "if1.input1"])
    visit.press("scope-arrange")
    visit.frame()
    tell(visit, do="lane", lane=0, to=2)
    assert screen.names == ("if1.X.pulses", "if1.input1", "if1.led")
    visit.press("scope-up-if1.led")
    assert screen.names == ("if1.X.pulses", "if1.led", "if1.input1")
    visit.press("scope-up-if1.X.pulses")
    assert screen.names[0] == "if1.X.pulses"
    visit.choose("scope-fold-if1.led", True)
    visit.choose("scope-title-if1.led", "  lamp ")
    first, lamp, _ = frame(screen)["signals"]
    assert (lamp["name"], lamp["title"], lamp["folded"]) == ("if1.led", "lamp", True)
    assert (first["title"], first["folded"]) == ("X position", False)


@shown(scope, "1811", after=1.5)
def test_messages_of_a_bus_are_decoded(visit):
    screen_of(visit).show(["1811.host_says"])
    visit.run(0.1)
    visit.bench["1811"].product.attend(visit.bench["1811"].bus).write(b"\x83")
    visit.run(0.5)
    (signal,) = frame(screen_of(visit))["signals"]
    text, words = signal["words"][0][1].split("\n")
    assert text == "83"
    assert words == visit.bench["1811"].product.language.explain(b"\x83") != ""


@shown(scope, "if1")
def test_the_next_and_the_previous_activity(visit):
    screen_of(visit).show(["if1.input1"])
    visit.run(1.5)
    visit.bench["if1"].pins["input1"].drive(True)  # at 1.5 s
    visit.run(20)
    screen_of(visit).span_ns = 2 * S
    visit.press("scope-previous-activity")
    from_ns, to_ns = screen_of(visit).edges
    assert (from_ns, to_ns) == (0, 2 * S), "no time before 0 is shown"
    visit.press("scope-previous-activity")
    assert visit.messages == ["no earlier activity"] and screen_of(visit).edges == (0, 2 * S)
    tell(visit, do="zoom", factor=0.1, place=0.0)  # to 0.2 s
    tell(visit, do="key", key="n")
    assert screen_of(visit).edges[1] == 1.68 * S, "a tenth of the screen before 1.5 s"
    tell(visit, do="key", key="n")
    from_ns, to_ns = screen_of(visit).edges
    assert from_ns < 1.5 * S < to_ns
    before = screen_of(visit).edges
    visit.press("scope-next-activity")
    assert screen_of(visit).edges == before


@shown(scope, "if1", after=1.5)
def test_pause_and_live(visit):
    screen_of(visit).span_ns = S
    visit.press("scope-pause")
    before = screen_of(visit).edges
    visit.run(1.0)
    assert screen_of(visit).edges == before and visit.found("scope-pause").text == "Live"
    assert visit.found("scope-state").text == "frozen"
    visit.press("scope-pause")
    assert screen_of(visit).edges[1] == visit.bench.now


@shown(scope, "if1", after=1.5)
def test_the_time_base_is_turned_by_buttons(visit):
    visit.press("scope-shorter")
    assert visit.found("scope-span").text == "200 ms a division"
    visit.press("scope-longer")
    visit.press("scope-longer")
    assert visit.found("scope-span").text == "1 s a division"
    visit.press("scope-all")
    assert screen_of(visit).edges == (0, visit.bench.now)


@shown(scope, "if1", after=1.5)
def test_lanes_or_overlaid(visit):
    visit.choose("scope-lanes", False)
    assert not screen_of(visit).lanes
    tell(visit, do="key", key="l")
    assert visit.found("scope-lanes").value is True


@shown(scope, "if1", after=1.5)
def test_a_trigger_on_an_edge(visit):
    visit.choose("scope-signals", "if1.input1")
    visit.press("scope-show")
    visit.choose("scope-trigger", "normal")
    visit.choose("scope-slope", "up")
    screen_of(visit).span_ns = 2 * S
    visit.choose("scope-place", 0.25)
    visit.frame()
    assert visit.found("scope-state").text == "waiting for an edge of Input 1"
    at_ns = visit.bench.now
    visit.bench["if1"].pins["input1"].drive(True)
    visit.run(3.0)
    assert screen_of(visit).edges[0] == at_ns - S // 2

    visit.choose("scope-trigger", "single")
    visit.frame()
    assert visit.found("scope-arm").visible
    visit.press("scope-arm")
    assert screen_of(visit).waiting


@shown(scope, "if1", after=1.5)
def test_the_value_and_signal_of_the_trigger(visit):
    visit.choose("scope-trigger", "auto")
    visit.choose("scope-trigger-signal", "if1.Y.pulses")
    visit.choose("scope-value", 500)
    trigger = screen_of(visit).trigger
    assert (trigger.signal, trigger.value) == ("if1.Y.pulses", 500)


@shown(scope, "if1")
def test_cursors_by_clicks_keys_and_buttons_and_what_they_measure(visit):
    visit.choose("scope-signals", "if1.input1")
    visit.press("scope-show")
    visit.run(4)
    visit.bench["if1"].pins["input1"].drive(True)
    visit.run(1.0)  # now 5 s, of which the latest 2 s are visible
    visit.choose("scope-snap", False)
    visit.choose("scope-measures", True)
    screen_of(visit).span_ns = 2 * S
    tell(visit, do="click", place=0.25)
    tell(visit, do="click", place=0.75)
    cursors = screen_of(visit).cursors
    assert (cursors.a_ns, cursors.b_ns) == (3.5 * S, 4.5 * S)

    visit.press("scope-pause")
    tell(visit, do="key", key="a")
    tell(visit, do="key", key="ArrowRight", shift=True)
    assert cursors.a_ns == 3.5 * S + 2 * S // 800
    tell(visit, do="drag", which="b", place=1.0)
    tell(visit, do="click", place=0.0, other=True)
    assert (cursors.a_ns, cursors.b_ns) == (3 * S, 5 * S)
    visit.press("scope-cursor-a")
    visit.press("scope-next-edge")
    assert cursors.a_ns == 4 * S
    for _ in range(5):
        visit.frame()
    assert (
        "A: Input 1 pressed at 4.000 s   B: 5.000 s   B − A 1 s   1/(B − A) 1 Hz   A moves"
        in visit.found("scope-times").text
    )
    visit.press("scope-edge-before")
    assert cursors.a_ns == 0
    for _ in range(5):
        visit.frame()
    (row,) = visit.found("scope-readout").rows
    assert row == {
        "name": "Input 1", "key": "if1.input1", "unit": "", "at": "–", "now": "pressed", "a": "off", "b": "pressed",
        "d": "1", "low": "off", "high": "pressed", "mean": "0.2",
    }  # fmt: skip

    tell(visit, do="key", key="Escape")
    assert (cursors.a_ns, cursors.b_ns) == (None, None)


@shown(scope, "if1", after=1.5)
def test_wheel_fingers_and_keys_zoom_and_move(visit):
    screen = screen_of(visit)
    screen.span_ns = 2 * S
    tell(visit, do="zoom", factor=0.5, place=1.0)
    assert screen.span_ns == S
    tell(visit, do="key", key="-")
    assert screen.span_ns == 2 * S
    tell(visit, do="pan", part=-0.5)
    assert screen.frozen is not None
    before = screen.edges
    tell(visit, do="key", key="ArrowLeft")
    assert screen.edges[0] < before[0]
    tell(visit, do="key", key=" ")
    assert screen.frozen is None
    tell(visit, do="key", key="Home")
    assert screen.edges == (0, visit.bench.now)


@shown(scope, "if1", after=1.5)
def test_the_wheel_keeps_the_time_under_the_pointer_while_the_bench_is_paused(visit):
    screen = screen_of(visit)
    screen.span_ns = 2 * S
    under_ns = screen.time_at(0.25)
    tell(visit, do="zoom", factor=0.1, place=0.25)
    assert screen.span_ns == 0.2 * S and screen.time_at(0.25) == under_ns
    assert visit.found("scope-state").text == "frozen"


@shown(scope, "if1")
async def test_a_restart_ends_the_view_of_the_deleted_recording(visit):
    visit.run(5)
    screen = screen_of(visit)
    visit.press("scope-pause")
    await visit.context.session.go_to(3.0)
    visit.frame()
    assert screen.frozen is not None, "the recording still exists"
    visit.context.session.restart()
    visit.context.session.pause()
    visit.frame()
    assert screen.frozen is None


@shown(scope, "if1")
async def test_it_says_since_when_it_records(visit):
    visit.run(6)
    visit.choose("scope-signals", "if1.led")
    visit.press("scope-show")
    visit.press("scope-all")
    visit.frame()
    assert visit.found("scope-state").text.startswith("recorded from 6 s on: to see earlier changes, go back to 0")
    await visit.context.session.go_to(2.0)
    visit.frame()
    assert visit.found("scope-state").text == ""


@shown(scope, "if1", after=1.5)
def test_a_click_tells_its_lane(visit):
    visit.choose("scope-signals", "if1.input1, if1.input2")
    visit.press("scope-show")
    pins, screen = visit.bench["if1"].pins, screen_of(visit)
    pins["input1"].drive(True)
    first_ns = visit.bench.now
    visit.run(0.01)
    pins["input2"].drive(True)
    visit.run(1.0)
    place = (first_ns + 8_000_000 - screen.edges[0]) / screen.span_ns
    tell(visit, do="click", place=place, lane=0)
    assert screen.cursors.a_ns == first_ns
    tell(visit, do="click", place=place, lane=1)
    assert screen.cursors.b_ns == first_ns + 10_000_000
    tell(visit, do="drag", which="b", place=place, lane=0)
    assert screen.cursors.b_ns == first_ns


@pytest.mark.parametrize("what", [
    {}, {"do": "zoom", "factor": "x"}, {"do": "zoom", "factor": None}, {"do": "size", "pixels": 1e300},
    {"do": "key", "key": None}, {"do": "click", "place": -7}])  # fmt: skip
@shown(scope, "if1", after=1.5)
def test_whatever_a_browser_says_does_no_harm(visit, what):
    tell(visit, **what)
    assert screen_of(visit).pixels in (800, 4096)


@shown(scope, "if1", after=1.5)
def test_a_picture_is_sent_when_there_is_another_one_and_somebody_can_see_it(visit, monkeypatch):
    sent, outbox = [], visit.user.client.outbox
    monkeypatch.setattr(outbox, "enqueue_message", lambda kind, data, _: sent.append(data["code"]))
    visit.frame()
    assert not sent
    visit.run(0.1)
    begin, _, picture = sent.pop().partition(",")
    assert begin.startswith("axistwinScope.draw(")
    assert [signal["name"] for signal in json.loads(picture[:-1])["signals"]] == list(screen_of(visit).names)
    tell(visit, do="seen", seen=False)
    visit.run(0.1)
    assert not sent


def test_it_is_as_it_was_when_somebody_comes_back_and_others_have_their_own():
    people, common = People(), Common(Session(bench_of("if1"), None))

    def visited(who):
        return show_to(Context(common, people, people[who]), scope, lambda visit: visit.found("scope-signals").value)

    visited("one")
    people["one"].settings["scope"].show(("if1.led",))
    assert visited("one") == "if1.led" and visited("other").startswith("if1.X.pulses")
    assert "if1.led" in common(Scopes).recorder.record.tracks


@pytest.mark.parametrize(("mark", "begins"), [
    ("seen.csv", b"# axistwin:"), ("all.vcd", b"$comment"), ("all.parquet", b"PAR1"), ("seen.svg", b"<?xml")
])  # fmt: skip
def test_it_is_saved_as_a_file(mark, begins):
    async def play(visit):
        visit.run(1.5)
        visit.press(f"scope-save-{mark}")
        answer = await visit.user.download.next(timeout=300)
        return answer.content

    assert show(bench_of("if1"), scope, play).startswith(begins)


@shown(scope, build=with_unit)
def test_a_signal_has_one_name_in_lanes_lists_and_measurements(visit):
    screen = screen_of(visit)
    screen.show(["if1.X.velocity", "if1.input2"])
    visit.choose("scope-measures", True)
    for _ in range(5):
        visit.frame()
    assert [row["name"] for row in visit.found("scope-readout").rows] == ["X velocity", "Input 2 from output 1"]
    assert [(lane["title"], lane["note"]) for lane in frame(screen)["signals"]] == [
        ("X velocity", ""), ("Input 2", "from output 1")]  # fmt: skip
    assert visit.found("scope-trigger-signal").options == {
        "": "", "if1.X.velocity": "X velocity", "if1.input2": "Input 2 from output 1"}  # fmt: skip
    visit.choose("scope-search", "input 2 from")
    assert visit.found("scope-box-if1.input2").text == "Input 2 from output 1"


@shown(scope, build=with_unit)
def test_a_level_has_the_word_of_its_switch(visit):
    screen = screen_of(visit)
    screen.show(["if1.estop", "if1.input1", "if1.input2"])
    pins, words = visit.bench["if1"].pins, []
    for on in (False, True):
        pins["estop"].drive(not on)
        pins["input1"].drive(on)
        pins["input2"].drive(on)
        visit.run(1.0)
        words.append([(lane["title"], lane["now"]) for lane in frame(screen)["signals"]])
    assert words == [
        [("Emergency stop", "released"), ("Input 1", "off"), ("Input 2", "off")],
        [("Emergency stop", "pressed"), ("Input 1", "pressed"), ("Input 2", "on")]]  # fmt: skip


@shown(scope, "if1")
def test_a_click_that_snaps_says_to_what(visit):
    screen = screen_of(visit)
    screen.show(["if1.input1", "if1.X.pulses"])
    visit.run(3)
    visit.bench["if1"].pins["input1"].drive(True)
    visit.bench["if1"].axes["X"].start(Profile([Segment(Fraction(1), Fraction(1))]), 1)  # one pulse, a second later
    visit.run(2.0)
    screen.span_ns = 4 * S  # 1 s to 5 s

    def told(place):
        tell(visit, do="click", place=place)
        for _ in range(5):
            visit.frame()
        return visit.found("scope-times").text

    assert told(0.501) == "A: Input 1 pressed at 3.000 s"
    screen.cursors.active = "a"
    assert told(0.749).startswith("A: X position 1 pulses at 4.000 s")
    screen.cursors.active = "a"
    assert told(0.25) == "A: 2.000 s"
    screen.span_ns = S // 1000  # a millisecond: a pixel is about a microsecond
    tell(visit, do="click", place=0.5)
    for _ in range(5):
        visit.frame()
    assert "B: 4.999500 s" in visit.found("scope-times").text
