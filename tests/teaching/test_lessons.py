"""The lessons: no step is done before its solution, and each step is done after its solution."""

import pytest

from axistwin.bench.actions import action
from axistwin.bench.hosts import host_of
from axistwin.errors import UsageError
from axistwin.programs import stored_programs
from axistwin.teaching import Pupil, course

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


def test_no_lessons_for_an_unknown_model():
    with pytest.raises(UsageError, match="no lessons for 'if9': expected one of if1, if2"):
        course("if9")
