"""Tuning: the worst case is minimised, claims hold, and an interrupted study continues with the same trials."""

import json

import pytest

from axistwin import AxistwinError
from axistwin.sweeps import Tuning, load

from ..command import run
from .scenes import motor, stepper

pytest.importorskip("optuna", reason="the extra [tune] is not installed")
WORDS = ("--change", "table.X.limits.1=5000..9000", "--vary", "table.X.load.torque=[0.1, 0.4]", "--for", 3)


class StoppedError(Exception):
    pass


def tuning(directory):
    """Return a study of a move that a limit switch ends; if the switch is late, the claim is violated."""
    made = Tuning(stepper(directory), "mean table.X.position", maximise=True)
    made.change("table.X.limits.1", "100..2500").change("script.0.at", [0.5, 0.75])
    made.vary("table.X.load.torque", "[0.1, 0.3]")
    return made.subject_to("low", "max table.X.position <= 2300")


@pytest.mark.slow
def test_the_same_trials_after_an_interruption_and_the_worst_case_counts(tmp_path):
    whole = tuning(tmp_path).run(tmp_path / "a.db", trials=7, seconds=4, workers=0)
    assert len({json.dumps(trial.values) for trial in whole.trials}) > 4
    for trial in (*whole.trials, whole.delivered):
        assert (trial.score, len(trial.results)) == (min(trial.results), 2)
        assert trial.feasible == (trial.violations["low"] <= 0)
    assert any(not trial.feasible for trial in whole.trials)
    assert whole.best.score == max(trial.score for trial in whole.trials if trial.feasible)

    def stop(done, every, best, delivered):
        assert (every, delivered.values) == (7, {})
        if done == 5:
            raise StoppedError

    with pytest.raises(StoppedError):
        tuning(tmp_path).run(tmp_path / "b.db", trials=7, seconds=4, workers=0, progress=stop)
    assert len(load(tmp_path / "b.db")[2]) == 5
    assert tuning(tmp_path).run(tmp_path / "b.db", trials=7, seconds=4, workers=0).trials == whole.trials
    with pytest.raises(AxistwinError, match="seed = 0 instead of 1"):
        tuning(tmp_path).run(tmp_path / "b.db", trials=7, seconds=4, workers=0, seed=1)


@pytest.mark.slow
def test_the_command_prints_lines_for_the_program_and_draws_the_study(tmp_path):
    words = ("tune", motor(tmp_path), "--for", 0.1, "--trials", 2, "--workers", 0, "--out", tmp_path / "g.db")
    words += ("--change", "knife.program.KP=100..200", "--change", "knife.KI=[50]", "--change", "shaft.motor.kv=5..6")
    done = run(*words, "--minimise", "rms knife.shaft.following_error", "--json")
    found = json.loads(done.out)
    values = found["best"]["values"]
    assert found["lines"] == [
        "in knife.sms:", f"    KP={values['knife.program.KP']} F", "in the program of knife:", "    KI=50 F",
        "in the scene:", f"    shaft.motor.kv = {values['shaft.motor.kv']}",
    ]  # fmt: skip
    assert done.code == (0 if found["better"] else 1)
    drawn = run("plot", tmp_path / "g.db", "-o", tmp_path / "g.svg")
    assert (drawn.code, "delivered" in (tmp_path / "g.svg").read_text()) == (0, True)


@pytest.mark.parametrize(("words", "told"), [
    (["--minimise", "max table.X.position"], "the search has no value to change"),
    ([*WORDS], "expected --minimise or --maximise"), ([*WORDS, "--minimise", "max table.X.positon"], "did you mean"),
    ([*WORDS, "--minimise", "max table.X.position", "--change", "table.X.load.torque=1..2"], "twice"),
    (["--change", "seed=normal(1, 2)", "--minimise", "count table.input1 rises"], "expected a range or a list"),
    ([*WORDS, "--minimise", "max table.X.position", "--out", "gains.txt"], "ends in .db"),
    ([*WORDS, "--minimise", "max table.X.position", "--out", "nowhere/gains.db"], "cannot write the study"),
    ([*WORDS, "--minimise", "max table.X.position", "--subject-to", "low"], "expected a name and an expression")
])  # fmt: skip
def test_errors_are_reported_before_the_first_run(tmp_path, words, told):
    done = run("tune", stepper(tmp_path), "--out", tmp_path / "x.db", *words)
    assert (done.code, done.out, len(done.err.splitlines())) == (2, "", 1) and told in done.err
    assert not (tmp_path / "x.db").exists()
