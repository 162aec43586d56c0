"""The lessons: each step is open until its solution is typed, and then done."""

import pytest

from axistwin.bench import action, host_of
from axistwin.bench.programs import stored_programs
from axistwin.core.errors import UsageError
from axistwin.ui.teaching.lessons import course
from axistwin.ui.teaching.pupil import Pupil

from .test_tutor import Learner

LESSONS = [(model, number) for model in ("if1", "1811", "smartmotor") for number in range(6)]


def solve(learner: Learner, line: str) -> None:
    """Perform a line of a solution, as the terminal does."""
    command, _, words = line.partition(" ")
    if command == ":wait":
        learner.bench.run(float(words))
    elif command == ":drive":
        pin, _, value = words.partition(" ")
        action(learner.controller, pin, value)()
    elif command == ":store":
        stored_programs.run(stored_programs.as_sent(words), "typed.sms", learner.controller)
    else:
        language = learner.controller.product.language
        with host_of(learner.controller) as host:
            host.subscribe_received(lambda _: None)
            host.write(language.read(line) if language is not None else f"{line}\r".encode())
            learner.bench.run(0.5)


@pytest.mark.parametrize(("model", "number"), LESSONS)
def test_each_step_is_done_by_its_solution_only(model, number):
    learner, lesson = Learner(model), course(model)[number]
    if lesson.initialised and model == "if1":
        learner.initialise()
    pupil = Pupil(lesson, learner.bench)
    for step in range(len(lesson.steps)):
        assert not pupil.check(), lesson.steps[step].task
        assert pupil.task.startswith(f"{step + 1}. ")
        for line in lesson.steps[step].solution:
            solve(learner, line)
        assert pupil.check(), lesson.steps[step].task
    assert pupil.finished
    pupil.close()


@pytest.mark.parametrize("lines", [("X2000$", ":wait 6", "X1000$"), ("X400$", ":wait 3", "X600$")])
def test_a_wrong_move_is_remarked_and_the_task_can_still_be_done(lines):
    learner, lesson = Learner("if1").initialise(), course("if1")[1]
    pupil = Pupil(lesson, learner.bench)
    *wrong, right = lines
    for line in wrong:
        solve(learner, line)
        assert not pupil.check()
    assert pupil.remark() == f"X has moved by {lines[0][1:-1]}: the task is not done yet" and pupil.remark() == ""
    solve(learner, right)
    learner.bench.run(3)
    assert pupil.check() and pupil.task.startswith("2. ")
    pupil.close()


def test_no_lessons_for_an_unknown_model():
    with pytest.raises(UsageError, match="no lessons for 'if9': expected one of if1, if2"):
        course("if9")
