"""Lessons and initialisation in a terminal of the panel."""

import pytest

from axistwin.ui.conversation.conversation import Conversation, by_hand
from axistwin.ui.panel.views.terminal import terminal
from axistwin.ui.teaching.lessons import course

from .showing import bench_of, shown


async def click(visit, mark):
    visit.user.find(marker=mark).click()
    visit.frame()
    await visit.until(lambda: not visit.context.actions.busy)


async def say(visit, line):
    """Type a line and Enter, and let virtual time pass."""
    name = next(iter(visit.bench.controllers))
    visit.choose(f"say-{name}", line)
    visit.trigger(f"say-{name}", "keydown.enter")
    await visit.until(lambda: not visit.context.actions.busy)
    visit.run(0.5)


@pytest.mark.parametrize(("model", "number"), [("if1", 2), ("if1", 5), ("1811", 2), ("smartmotor", 3)])
@shown(terminal)
async def test_a_lesson_is_done_by_what_the_controller_has_done(visit, model, number):
    lesson = course(model)[number - 1]
    visit.context.session.speed = None
    await click(visit, f"lesson-{model}-{number}")
    assert visit.context.session.running
    visit.context.session.pause()  # the test advances virtual time
    for step, task in enumerate(lesson.steps, start=1):
        assert visit.found(f"task-{model}").text == by_hand(f"{step}. {task.task}")
        assert f"step {step} of {len(lesson.steps)}" in visit.found(f"lesson-title-{model}").text
        visit.press(f"show-{model}")
        assert task.solution[0] in visit.told(model, 1)
        for line in task.solution:
            await say(visit, line)
    assert "done" in visit.found(f"lesson-title-{model}").text and visit.found(f"next-lesson-{model}").visible
    assert visit.context.person.settings[f"lessons {model}"] == str(number)
    assert "? Done" in visit.told(model)
    visit.press(f"end-lesson-{model}")
    assert visit.context.common(Conversation).lessons.of(model) is None


@shown(terminal, "if1")
async def test_a_lesson_is_continued_after_going_back_and_by_a_reload(visit):
    session = visit.context.session
    session.speed = None
    await click(visit, "lesson-if1-2")
    session.pause()
    began_s = session.seconds
    await say(visit, "X1000$")
    visit.run(3)
    assert visit.found("task-if1").text.startswith("2. ")
    await visit.context.move(lambda: session.go_to(began_s))
    visit.frame()
    assert visit.found("task-if1").text.startswith("2. "), "the step stays done"
    await visit.reload()
    assert visit.found("task-if1").text.startswith("2. ")
    visit.context.person.settings["lessons if1"] = "4"
    await visit.reload()
    titles = [visit.found(f"lesson-name-if1-{number}").text[:3] for number in range(3, 7)]
    assert titles == ["✓ 3", "✓ 4", "5  ", "6  "]


@shown(terminal, "smartmotor", build=bench_of("smartmotor", "smartmotor other"))
async def test_only_messages_of_this_controller_count_and_only_the_driver_begins(visit):
    visit.context.session.speed = None
    await click(visit, "lesson-smartmotor-1")
    visit.context.session.pause()
    visit.bench["other"].serial.write(b"RP ")
    visit.run(0.5)
    assert visit.found("task-smartmotor").text.startswith("1. ")
    await say(visit, "RP")
    assert visit.found("task-smartmotor").text.startswith("2. ")
    visit.context.people.driver = None
    visit.user.find(marker="lesson-smartmotor-2").click()
    visit.press("end-lesson-smartmotor")
    assert visit.found("task-smartmotor").text.startswith("2. ") and len(visit.messages) == 2


@shown(terminal, "if1")
async def test_initialise_performs_the_dialogue_once(visit):
    await click(visit, "init-if1")
    assert visit.bench["if1"].registers["state"].read() == "ready" and not visit.context.session.running
    await say(visit, ":init")
    assert visit.told("if1", 1) == "? Initialise\nthe controller is ready: no initialisation is needed"


COMMANDS = (
    (":why", "the self-test takes about a second"), (":next", "("), (":explain estop", "emergency stop"),
    (":task", "no lesson has begun"), (":show", "no lesson has begun"),
)  # fmt: skip


@shown(terminal, "if1")
async def test_commands_of_the_terminal_are_typed(visit):
    for line, text in COMMANDS:
        await say(visit, line)
        asked, *answer = visit.told("if1", 1).splitlines()
        assert asked == f"? {line}" and text in "\n".join(answer)
        visit.run(1.0)
    await say(visit, ":drive input1 high")
    assert visit.bench["if1"].pins["input1"].level
    before = visit.bench.now
    await say(visit, ":wait 2")
    assert visit.bench.now == before + 2_500_000_000, "two seconds, and half a second after each line"
    for line, message in (
        (":wait long", "invalid time 'long': expected seconds"),
        (":speed 3", "unknown command :speed: expected one of"),
        (":drive nothing high", "nothing"),
    ):  # fmt: skip
        await say(visit, line)
        assert message in visit.messages[-1]
    assert not visit.context.common(Conversation).lessons.of("if1")


def test_a_task_on_the_page_names_the_switch_to_click():
    assert by_hand("Open the plus limit: type  :drive limit_plus low") == (
        "Open the plus limit: click the switch limit_plus"
    )
    assert by_hand("Wait for input 1, then move: type  H1X300$  and then  :drive input1 high") == (
        "Wait for input 1, then move: type  H1X300$  and then  click the switch input1"
    )
