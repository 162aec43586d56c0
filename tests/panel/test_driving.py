"""The toolbars that control virtual time."""

import io
import zipfile

from nicegui import ui

from axistwin import Bench
from axistwin.bench.programs import stored_programs
from axistwin.ui.panel.actions import State
from axistwin.ui.panel.views.driving import OFFERED, driving

from .showing import shown


def state(visit):
    return visit.found("state").text


def type_into(visit, mark, text):
    visit.choose(mark, text)
    visit.trigger(mark, "keydown.enter")


@shown(driving, "if1")
async def test_run_and_pause(visit):
    assert (state(visit), visit.found("run").text) == ("Paused", "Run")
    visit.press("run")
    assert (state(visit), visit.found("run").text)[1] == "Pause"
    visit.press("run")
    assert (state(visit), visit.found("run").text) == ("Paused", "Run")


@shown(driving, "if1")
async def test_a_step_goes_to_the_next_event_and_one_that_never_comes_is_told(visit):
    visit.press("step-event")
    await visit.until(lambda: visit.context.session.seconds > 0 and state(visit) == "Paused")
    assert visit.context.session.seconds == 1.0  # the lamp goes out at the end of the self-test
    visit.press("step-statement")
    await visit.until(lambda: visit.messages)
    assert visit.messages == ["no such event within 60 virtual seconds: a line of a program begins"]


def with_a_program():
    bench = Bench()
    motor = bench.add("smartmotor", "motor")
    stored_programs.store(b"UCI UDI ZS BRKRLS OFF\nA=1000 V=100000 P=5000 MP\nG\nTWAIT\nEND\n", "turn.sms", motor)
    return bench


@shown(driving, build=with_a_program)
async def test_steps_of_a_motor_with_a_program(visit):
    times = [0.0]
    for kind in ("event", "statement", "statement", "move"):
        visit.press(f"step-{kind}")
        await visit.until(lambda: visit.context.session.seconds > times[-1] and state(visit) == "Paused")
        times.append(visit.context.session.seconds)
    assert not visit.messages


@shown(driving, "if1")
async def test_speed_by_menu_and_field(visit):
    session = visit.context.session
    assert visit.found("speed-box").value == "max"
    for speed in OFFERED:
        text = "max" if speed is None else f"{speed:g}"
        visit.press(f"speed-{text}")
        assert (session.speed, visit.found("speed-box").value) == (speed, text)
    type_into(visit, "speed-box", "30")
    assert (session.speed, visit.found("speed-words").text) == (30.0, "Speed \u00d730")
    type_into(visit, "speed-box", "-1")
    assert visit.messages == ["invalid speed '-1': expected `max` or a number up to 1000000, e.g. 1 for real time"]
    assert visit.found("speed-box").value == "30"


@shown(driving, "if1")
async def test_who_does_not_drive_changes_nothing(visit):
    visit.context.people.driver = visit.context.people["another"]
    visit.press("run")
    visit.press("speed-0.1")
    type_into(visit, "until", "if1.led falls")
    assert (visit.context.session.running, visit.context.session.speed) == (False, None)
    assert visit.found("speed-words").text == "Speed max"
    assert visit.messages == ["visitor 2 drives: press Drive to take over"] * 3


@shown(driving, "if1")
async def test_back_in_time_and_live_from_there(visit):
    session = visit.context.session
    type_into(visit, "until", "if1.led falls")
    await visit.until(lambda: not session.running)
    assert state(visit) == "Paused: if1.led falls"
    type_into(visit, "moment", "0.5")
    await visit.until(lambda: session.seconds == 0.5 and not session.busy)
    assert state(visit) == "Replay at 0.5 s"
    for _ in range(10):
        visit.frame()
    assert (visit.found("timeline").value, visit.found("timeline").props["max"]) == (0.5, 1.0)
    visit.press("forget")
    assert (state(visit), session.recorded_seconds) == ("Paused", 0.5)
    type_into(visit, "moment", "tomorrow")
    await visit.until(lambda: visit.messages)
    assert visit.messages == ["invalid time 'tomorrow': expected seconds, e.g. 1.5"]


@shown(driving, "if1")
async def test_a_step_back_ends_at_0(visit):
    session = visit.context.session
    type_into(visit, "until", "if1.led falls")
    await visit.until(lambda: not session.running)
    assert 0 < session.seconds < 10
    visit.press("step-back")
    await visit.until(lambda: session.seconds == 0 and not session.busy)


@shown(driving, "if1")
def test_the_menu_has_what_a_narrow_header_leaves_out(visit):
    visit.press("if1-power-more")
    assert not visit.bench["if1"].powered
    assert visit.found("restart-more").text == "Restart"
    assert visit.found("timeline-more").props["max"] > 0


@shown(driving, "if1")
async def test_a_frame_does_not_move_a_slider_that_the_user_holds(visit):
    session, slider = visit.context.session, visit.found("timeline")
    type_into(visit, "until", "if1.led falls")
    await visit.until(lambda: not session.running)
    visit.trigger("timeline", "pointerdown")
    slider.value = 0.25  # the browser reports the value before the user releases the slider
    for _ in range(20):
        visit.frame()
    assert slider.value == 0.25
    visit.trigger("timeline", "change", 0.25)
    await visit.until(lambda: session.seconds == 0.25 and not session.busy)
    visit.trigger("timeline", "pointerdown")
    visit.trigger("timeline", "pointercancel")
    slider.value = 0.75
    for _ in range(20):
        visit.frame()
    assert slider.value == 0.25


@shown(driving, "if1")
async def test_acts_during_a_move_are_performed_after_it_in_their_order(visit):
    session, actions = visit.context.session, visit.context.actions
    type_into(visit, "until", "if1.led falls")
    await visit.until(lambda: actions.state is State.QUIET)
    type_into(visit, "moment", "0.25")
    assert (actions.state, visit.found("run").text) == (State.BUSY, "Stop")
    visit.press("step-event")
    visit.trigger("run", "click", "Run")  # the button in the browser still shows Run
    assert not session.running
    await visit.until(lambda: session.running)
    assert session.seconds >= 1.0  # the run has begun after the step
    visit.trigger("run", "click", "Pause")
    assert (state(visit), actions.state, visit.messages) == ("Paused", State.QUIET, [])


@shown(driving, "if1")
async def test_stop_drops_the_acts_that_wait(visit):
    session, actions = visit.context.session, visit.context.actions
    type_into(visit, "until", "if1.led falls")
    await visit.until(lambda: actions.state is State.QUIET)
    type_into(visit, "moment", "0.5")
    visit.press("step-event")
    visit.trigger("run", "click", "Run")
    visit.trigger("run", "click", "Stop")
    await visit.until(lambda: actions.state is State.QUIET)
    assert (session.running, session.busy, visit.messages) == (False, False, [])
    assert session.seconds <= 0.5  # both the step and the run have been cancelled


@shown(driving, "if1")
async def test_an_error_of_an_act_that_has_waited_is_shown(visit):
    actions = visit.context.actions
    type_into(visit, "until", "if1.led falls")
    await visit.until(lambda: actions.state is State.QUIET)
    type_into(visit, "moment", "0.5")
    type_into(visit, "new-break", "nobody falls")
    assert visit.messages == []
    await visit.until(lambda: visit.messages)
    assert "nobody" in visit.messages[0]


@shown(driving, "if1")
async def test_breaks_are_added_switched_off_and_removed(visit):
    session = visit.context.session
    type_into(visit, "new-break", "if1.led falls")
    assert [each.sentence for each in session.breaks] == ["if1.led falls"]
    visit.press("run")
    await visit.until(lambda: not session.running)
    assert (session.seconds, state(visit)) == (1.0, "Paused: break: if1.led falls")
    visit.user.find("once")
    with visit.user.client:
        visit.user.find(ui.checkbox).elements.pop().value = False
    visit.frame()
    assert [each.on for each in session.breaks] == [False]
    visit.user.find(content="delete").click()
    visit.frame()
    assert session.breaks == []
    type_into(visit, "new-break", "nobody falls")
    assert "nobody" in visit.messages[-1]


@shown(driving, "if1")
async def test_a_session_is_saved_as_a_zip(visit):
    visit.press("save")
    (response,) = [await visit.user.download.next()]
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        assert "scene.toml" in archive.namelist()
