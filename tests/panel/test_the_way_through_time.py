"""The panel guides through a scene: the first visitor, planned actions, the end, restart and undo."""

import pytest

from axistwin import Session
from axistwin.scenes.scene import Scene
from axistwin.ui.panel.context import Common, Context, together
from axistwin.ui.panel.people import People
from axistwin.ui.panel.views.darkness import MODES
from axistwin.ui.panel.views.driving import driving as header
from axistwin.ui.panel.views.state import MOST_BUTTONS, SELDOM, next_line

from .showing import shown

SCENE = """
title = "A gate"
panel = { wait = true }
[[controller]]
model = "if1"
name = "gate"
[[script]]
at = 10
do = "input1 high"
[[script]]
at = 36000.5
on = "gate"
do = ["input1 low", "power off"]
"""


def driving(context):
    return together(header(context), next_line(context))


@pytest.fixture
def context(tmp_path):
    (tmp_path / "gate.toml").write_text(SCENE)
    scene = Scene.load(tmp_path / "gate.toml")
    session, people = Session(scene.build, None, scene=scene), People()
    return Context(Common(session), people, people["somebody"])


def text(visit, mark):
    return visit.found(mark).text


def seen(visit, mark):
    try:
        return visit.found(mark).visible
    except AssertionError:
        return False


async def arrived(visit, seconds):
    session = visit.context.session
    await visit.until(lambda: session.seconds >= seconds and not visit.context.actions.busy)


@shown(driving)
def test_a_scene_that_waits_is_paused_at_0_until_a_visitor_comes(visit, context):
    assert context.session._scene.waits
    context.session.wait()
    visit.frame()
    assert text(visit, "state") == "Paused at 0 s until a browser or a host connects"
    context.session.welcome()
    visit.frame()
    assert not text(visit, "state").startswith("Paused")


@shown(driving)
async def test_planned_actions_are_shown_and_gone_to_until_the_scene_has_finished(visit, context):
    session = context.session
    assert text(visit, "scene-title") == "A gate"
    assert text(visit, "next-words") == "Press Run. Script: input1 high at 10 s"
    visit.press("go-planned")
    await arrived(visit, 10)
    assert visit.bench["gate"].pins["input1"].level
    assert text(visit, "next-words") == "Press Run. Script: gate input1 low, power off at 36,000.5 s"
    session.speed = 1000
    visit.press("run")
    visit.press("go-planned")
    await arrived(visit, 36_000.5)
    await visit.until(lambda: session.running)
    for _ in range(SELDOM):
        visit.frame()
    assert not visit.bench["gate"].powered
    assert text(visit, "planned") == "" and not seen(visit, "go-planned")
    assert text(visit, "state") == "Power off", "which holds the machine, although the scene has ended"


@shown(driving)
async def test_a_restart_can_be_undone_for_ten_seconds(visit, context):
    session = context.session
    visit.press("go-planned")
    await arrived(visit, 10)
    session.do("gate", "input2", "high")
    visit.run(1)
    assert not seen(visit, "undo")
    session.speed = 0.1
    visit.press("restart")
    assert session.running and session.seconds < 1 and list(session.journal) == []
    assert seen(visit, "undo") and text(visit, "undo").startswith("Undo Restart (")
    visit.press("undo")
    await visit.until(lambda: not session.running and len(list(session.journal)) == 1)
    visit.frame()
    assert session.recorded_seconds > 10 and not seen(visit, "undo")


@shown(driving)
def test_an_undo_that_comes_too_late_is_not_offered(visit, context, monkeypatch):
    monkeypatch.setattr("axistwin.scenes.sessions.session.UNDO_S", -1.0)
    visit.press("restart")
    assert not seen(visit, "undo")


@shown(driving, "if1")
def test_the_speed_is_told(visit):
    assert text(visit, "speed-words") == "Speed max"
    visit.choose("speed-box", "2.5")
    visit.trigger("speed-box", "keydown.enter")
    assert text(visit, "speed-words") == "Speed \u00d72.5"


@shown(driving, "if1")
def test_the_colours_are_selected_in_turn_and_kept_for_the_user(visit):
    found = []
    for _ in MODES:
        found.append(visit.found("darkness").text)
        visit.press("darkness")
    assert found == ["Colours: as the system", "Colours: dark", "Colours: light"]
    visit.press("darkness")
    assert visit.context.person.settings["dark"] is True


def offered(visit):
    return [text(visit, f"act-{place}") for place in range(MOST_BUTTONS) if seen(visit, f"act-{place}")]


@shown(driving, "if1", after=1.5)
async def test_the_next_line_offers_what_to_do_and_does_it(visit):
    session = visit.context.session
    visit.press("run")
    for _ in range(SELDOM):
        visit.frame()
    assert text(visit, "state") == "Waiting for a command" and offered(visit) == ["Initialise", "Lessons"]
    visit.press("act-0")
    await visit.until(lambda: visit.bench["if1"].registers["state"].read() == "ready" and not session.busy)
    session.pause()
    session.do("if1", "estop", "low")
    visit.frame()
    assert text(visit, "state") == "Stopped: emergency stop pressed (paused)"
    assert offered(visit)[0] == "Release estop" and "unelevated" in visit.found("act-0").props
    assert "unelevated" not in visit.found("run").props
    visit.press("act-0")
    await visit.until(lambda: visit.bench["if1"].pins["estop"].level)


@shown(driving, "if1")
def test_a_delay_is_shown_only_for_some_seconds(visit, monkeypatch):
    monkeypatch.setattr(Session, "running", True)
    delays = visit.context.session.pacer.delays

    def shown_after(frames):
        for _ in range(frames):
            visit.frame()
        return text(visit, "late")

    assert shown_after(10) == ""
    delays.count(0.067)
    assert shown_after(10) == "fell behind the wall clock once, by 67 ms at most"
    assert shown_after(90) == "fell behind the wall clock once, by 67 ms at most"
    assert shown_after(10) == "", "100 frames, 5 s"
    delays.count(0.05)
    assert shown_after(10) == "fell behind the wall clock 2 times, by 67 ms at most"
