"""`axistwin learn`."""

from functools import partial

import pytest

from axistwin.core.units import S
from axistwin.ui.teaching.lessons import course

from ..command import run

learn = partial(run, "learn")
DONE = "(\nU61\n:wait 1.5\nE\n"


def test_a_lesson_is_resumed_after_the_last_one_that_is_done(tmp_path):
    progress = ("--progress", tmp_path / "done.json")
    first = learn("if1", *progress, typed="E\n:show\n:task\n")
    assert "type  (\n" in first.out and "is done" not in first.out
    second = learn("IF1", *progress, typed=DONE)
    assert "done.  2. Choose 8 data bits" in second.out
    assert second.out.endswith("axistwin: lesson 1 is done: axistwin learn if1 begins lesson 2\n")
    assert learn("if1", *progress, typed="").out.startswith("axistwin: if1, lesson 2 of 6: A move\n")
    assert learn("if1", "--list", *progress).out.splitlines()[:2] == ["done  1  The first command", "      2  A move"]


@pytest.mark.parametrize(("model", "number"), [("if1", 6), ("1811", 6), ("smartmotor", 6)])
def test_the_last_lesson_is_solved_in_the_terminal(tmp_path, monkeypatch, model, number):
    monkeypatch.setattr("axistwin.ui.terminal.virtual.PATIENCE_NS", S)  # the program of the SmartMotor never ends
    solution = "\n".join(line for step in course(model)[number - 1].steps for line in step.solution)
    end = learn(model, "--lesson", number, "--progress", tmp_path / "done.json", typed=f"{solution}\n").out
    assert end.endswith("axistwin: lesson 6 is done: this was the last lesson\n")


def test_wrong_uses(tmp_path):
    assert learn("if9").err == "axistwin: no lessons for 'if9': expected one of if1, if2, 1810, 1811, smartmotor\n"
    (tmp_path / "done.json").write_text("{")
    spoilt = learn("if1", "--progress", tmp_path / "done.json")
    assert spoilt.code == 2 and "delete the file" in spoilt.err
    assert (
        ":task works only in a lesson: start a lesson with axistwin learn MODEL"
        in run("term", "if1", "--speed", "max", typed=":task\n").out
    )
