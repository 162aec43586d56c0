"""`axistwin tune`: find the best values for the settings of a scene, such as gains."""

import json
from pathlib import Path
from typing import Any

import click

from axistwin.cli.common.parameters import FILE, Number
from axistwin.cli.common.working import counting
from axistwin.cli.sweeping.sweep import COUNT, named, path_and_values
from axistwin.core.errors import UsageError
from axistwin.sweeps import study_picture
from axistwin.sweeps.designs import DESIGNS
from axistwin.sweeps.study import Study, Trial, load
from axistwin.sweeps.sweep import Design
from axistwin.sweeps.tuning import Tuning
from axistwin.sweeps.workers import LIMIT_S


@click.command()
@click.argument("scene", metavar="SCENE.toml", type=FILE)
@click.option("--change", metavar="PATH=VALUES", multiple=True,
              help="A value to choose and its range, e.g. knife.KP=10..400.")  # fmt: skip
@click.option("--minimise", metavar="EXPRESSION", help="The measure to minimise, e.g. 'energy knife.shaft'.")
@click.option("--maximise", metavar="EXPRESSION", help="The measure to maximise.")
@click.option("--subject-to", metavar="NAME:EXPRESSION", multiple=True, help="A claim that must hold in every run.")
@click.option("--vary", metavar="PATH=VALUES", multiple=True,
              help="A value that scatters; of its runs, the worst counts.")  # fmt: skip
@click.option("--trials", type=COUNT, default=100, show_default=True, help="Number of trials of the study.")
@click.option("--out", "-o", type=FILE, help="The study: FILE.db.  The same command continues an interrupted study.")
@click.option("--plot", type=FILE, help="Draw the study: FILE.svg or FILE.png.")
@click.option("--for", "seconds", type=Number(min=0, min_open=True), help="Virtual time of each run.")
@click.option("--design", type=click.Choice(list(DESIGNS)), default="grid", help="Design of the varied values; grid.")
@click.option("--runs", type=COUNT, help="Number of runs of a random design, or of random draws per grid point.")
@click.option("--seed", type=click.IntRange(min=0), default=0, help="Seed of the trials and of random values; 0.")
@click.option("--program", type=FILE, help="A program or conversation that is part of every run.")
@click.option("--host", metavar="MODULE:FUNCTION", help="A Python host, called with the bench of each run.")
@click.option("--workers", type=click.IntRange(min=0), help="Number of processes; 0: run in this process.")
@click.option("--scheduler", metavar="tcp://HOST:PORT", help="Run on the Dask cluster of this scheduler.")
@click.option(
    "--limit", type=Number(min=0, min_open=True), default=LIMIT_S, show_default=True,
    help="Longest real time of a run, in seconds.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def tune(scene: Path, out: Path | None, plot: Path | None, trials: int, as_json: bool, **options: Any) -> int:
    """Find the best values for the settings of a scene, such as gains.

    Each trial chooses the values of --change, and runs the scene once for each point of the --vary values.  The score
    of a trial is its worst run.  The result is compared with the scene as delivered, in the same runs.  The study is
    an SQLite file of Optuna; with more --trials, the same command continues a finished study.

    PATH, VALUES and EXPRESSION are those of `axistwin sweep`.

    Exit code 0: the best trial is better than the scene as delivered.  1: no trial is.  2: wrong usage.
    130: interrupted.

    \b
    Examples:
      axistwin tune scene.toml --change knife.KP=10..400 --change knife.KD=100..4000 --for 2 \\
          --vary knife.shaft.load.inertia_kg_m2=1.6e-4..2.4e-4:3 \\
          --minimise 'rms knife.shaft.following_error' --out gains.db --plot gains.svg
      axistwin tune scene.toml --change table.X.limits.1=5000..20000 --maximise 'max table.X.velocity' \\
          --subject-to 'whole: max |table.X.lost| = 0' --trials 50 --out limits.db
      axistwin plot gains.db -o gains.svg
    """
    if out is None:
        raise UsageError("the file for the study is missing: add --out, e.g. --out gains.db")
    made = _made(scene, options)
    design = Design(options["design"], options["runs"], options["seed"])
    try:
        with counting("trials", "") as show:
            study = made.run(
                out, trials=trials, seed=options["seed"], design=design, seconds=options["seconds"],
                workers=options["workers"], limit=options["limit"], scheduler=options["scheduler"],
                tell=lambda words: click.echo(f"axistwin: {words}", err=True),
                progress=show and (lambda done, every, *trials: show(done, every, _compared(*trials))),
            )  # fmt: skip
    except KeyboardInterrupt:
        done = len(load(out)[2]) if out.exists() else 0
        click.echo(f"axistwin: interrupted after {done:,} trials: the same command continues from there", err=True)
        return 130
    if plot is not None:
        study_picture.save(*load(out), plot, out.name)
    return _show(study, made, as_json=as_json)


def _made(scene: Path, options: dict[str, Any]) -> Tuning:
    goals = [options[name] for name in ("minimise", "maximise") if options[name]]
    if len(goals) != 1:
        raise UsageError("the goal is missing: expected --minimise or --maximise, e.g. --minimise 'energy knife.shaft'")
    maximise = bool(options["maximise"])
    made = Tuning(scene, goals[0], maximise=maximise, program=options["program"], host=options["host"])
    for each in options["change"]:
        made.change(*path_and_values("change", each))
    for each in options["vary"]:
        made.vary(*path_and_values("vary", each))
    for each in options["subject_to"]:
        made.subject_to(*named("subject-to", each))
    return made


def _show(study: Study, made: Tuning, *, as_json: bool) -> int:
    delivered, found = study.delivered, study.best
    assert delivered is not None, "the scene as delivered has been run"
    lines = [] if found is None else list(made.lines(found.values))
    sign = -1 if made.maximises else 1
    better = found is not None and (not delivered.feasible or sign * found.score < sign * delivered.score)
    if as_json:
        told = {
            "goal": made.goal, "trials": len(study.trials), "delivered": _data(delivered),
            "best": found and {**_data(found), "values": found.values}, "better": better, "lines": lines,
        }  # fmt: skip
        click.echo(json.dumps(told, ensure_ascii=False))
        return 0 if better else 1
    click.echo(f"{made.goal}: the worst of {len(delivered.results)} runs, {len(study.trials)} trials")
    click.echo(f"    delivered  {_words(delivered)}")
    click.echo(f"    best       {'no trial meets the claims' if found is None else _words(found)}")
    for line in lines:
        click.echo(line)
    if not better:
        click.echo(
            "axistwin: no trial is better than the scene as delivered: try other ranges or more trials", err=True
        )
    return 0 if better else 1


def _data(trial: Trial) -> dict[str, Any]:
    return {"score": trial.score, "results": trial.results, "feasible": trial.feasible}


def _words(trial: Trial) -> str:
    if "result" in trial.violations:
        return f"no result: {trial.notes}"
    failing = [name for name, violation in trial.violations.items() if violation > 0]
    return f"{trial.score:.6g}" + (f", but {', '.join(failing)} fails" if failing else "")


def _compared(found: Trial | None, delivered: Trial) -> str:
    return f"best {'-' if found is None else f'{found.score:.6g}'}, delivered {delivered.score:.6g}"
