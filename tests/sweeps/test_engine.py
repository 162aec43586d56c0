"""Runs of a sweep: workers, interrupted sweeps, scenes of failing runs, search, the command and the sweep file."""

import asyncio
import json
import os
import signal

import pytest

from axistwin import AxistwinError, Scene
from axistwin.scenes.sessions.session import Session
from axistwin.sweeps import Design, Runner, Sweep, ThisProcess, Workers, digest, read, workers

from ..command import run
from .scenes import stepper

pytest.importorskip("pyarrow", reason="the extra [traces] is not installed")


def study(directory, torque="[0.1, 0.6]", limits="5000..7000:2"):
    return (
        Sweep(stepper(directory))
        .vary("table.X.load.torque", torque)
        .vary("table.X.limits.1", limits)
        .measure("lost", "final table.X.lost")
        .measure("none", "from table.input3 rises to table.input3 falls")
        .claim("near", "never table.X passes 2750")
    )


def test_one_row_a_run(tmp_path):
    rows = study(tmp_path).run(tmp_path / "found.parquet", workers=0).to_pylist()
    assert [row["run"] for row in rows] == [0, 1, 2, 3]
    first, last = rows[0], rows[-1]
    assert (first["lost"], first["near"], first["near.robustness"], first["ended"]) == (0, False, -250, "rest")
    assert (last["table.X.load.torque"], last["table.X.limits.1"], last["near"]) == (0.6, 7000, True)
    assert last["lost"] > 0 and "none: no event 'table.input3 rises'" in first["notes"]
    kept = tmp_path / "found-failing" / "run-0" / "scene.toml"
    scene, at_s = Scene.load(kept), first["near.at_s"]
    assert f"--panel 8080 --to {at_s:.9f}" in kept.read_text()

    async def replayed():
        session = Session(scene.build, scene=scene)
        await session.advance_to(at_s)
        return session.bench["table"].axes["X"].position, session.seconds, session.running

    assert asyncio.run(replayed()) == (2750, at_s, False)


@pytest.mark.slow
def test_workers_and_this_process_agree_even_if_a_worker_is_killed(tmp_path):
    runner, points = study(tmp_path, "0.1..0.6:4").check()
    told = []
    with Workers(runner, 2, tell=told.append) as workers:
        rows = []
        for row in workers.map(enumerate(points)):
            if len(rows) == 1:
                os.kill(workers.processes[0], signal.SIGKILL)
            rows.append(row)
    assert sorted(row["run"] for row in rows) == list(range(8))
    with ThisProcess(runner) as here:
        alone = {row["run"]: row for row in here.map(enumerate(points))}
    apart = {"wall_s", "worker", "version"}
    for row in rows:
        assert {k: v for k, v in row.items() if k not in apart} == {
            k: v for k, v in alone[row["run"]].items() if k not in apart
        }


SWEEP_HOST = """
import os
from threading import Event


def host(bench):
    print("said by a host")
    match bench.origin["seed"]:
        case "1":
            os._exit(1)
        case "2":
            raise ValueError("broken")
        case "4":
            Event().wait()
"""


@pytest.mark.slow
def test_a_run_has_a_time_limit_and_a_failed_run_has_its_reason(tmp_path, monkeypatch):
    """The first run kills its worker, the second one fails, and the last one never ends; the other one goes on."""
    (tmp_path / "sweephost.py").write_text(SWEEP_HOST)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(workers, "TRIES", 1)
    scene = stepper(tmp_path)
    rows = Sweep(scene, host="sweephost:host").vary("seed", "1..4").run(workers=1, limit=0.8).to_pylist()
    assert [(row["run"], row["ended"], row["notes"]) for row in rows] == [
        (0, "killed", "the worker was killed"), (1, "error", "ValueError: broken"),
        (2, "rest", None), (3, "limit", "not finished after 0.8 s of real time"),
    ]  # fmt: skip
    (row,) = Sweep(scene, host="sweephost:host").vary("seed", "2").run(workers=0).to_pylist()
    assert (row["ended"], row["notes"]) == ("error", "ValueError: broken")
    with pytest.raises(AxistwinError, match="MODULE:FUNCTION"):
        Sweep(scene, host="nowhere:at").vary("seed", "1").run(workers=0)


def test_drawn_values_are_checked_as_drawn(tmp_path):
    def made(text):
        return Sweep(stepper(tmp_path)).vary("table.X.load.torque", text)

    made("normal(0.15, 0.02)").check(Design("lhs", 5))
    with pytest.raises(AxistwinError, match=r"cannot set table\.X\.load\.torque to -0\."):
        made("normal(0.02, 0.02)").check(Design("lhs", 20))


class StoppedError(Exception):
    pass


def test_an_interrupted_sweep_is_resumed_without_repeated_runs(tmp_path):
    expected = digest(study(tmp_path, "0.1..0.6:4").run(workers=0))

    def stop(done, every, failing):
        assert every == 8
        if done in (3, 5):
            raise StoppedError

    for _ in range(2):
        with pytest.raises(StoppedError):
            study(tmp_path, "0.1..0.6:4").run(tmp_path / "a.parquet", workers=0, progress=stop)
    assert read(tmp_path / "a.parquet").num_rows == 5
    with pytest.raises(AxistwinError, match="another sweep, with varied = "):
        study(tmp_path).run(tmp_path / "a.parquet", workers=0)
    seen = []
    found = study(tmp_path, "0.1..0.6:4").run(tmp_path / "a.parquet", workers=0, progress=lambda n, *_: seen.append(n))
    assert (seen, digest(found), found.num_rows) == ([6, 7, 8], expected, 8)
    assert not (tmp_path / "a.parquet.parts").exists()
    study(tmp_path, "0.1..0.6:4").run(tmp_path / "a.parquet", workers=0, progress=stop)  # all runs are done already


def test_a_conversation_is_part_of_every_run(tmp_path):
    scene = stepper(tmp_path)
    scene.write_text(scene.read_text().replace('host = "go.if1"\n', ""))
    talk = tmp_path / "hello.talk"
    talk.write_text("; model: if2\n+1.5\n> (\n< U\\r\n= X.position 1\n")
    rows = Sweep(scene, talk).vary("seed", "0..1").measure("end", "final table.X.position").run(workers=0).to_pylist()
    assert [row["end"] for row in rows] == [0, 0] and all("X.position" in row["difference"] for row in rows)


def test_a_search_finds_a_failure_and_is_resumed(tmp_path):
    pytest.importorskip("cmaes", reason="the extra [sweeps] is not installed")

    def made():
        return (
            Sweep(stepper(tmp_path))
            .vary("script.0.at", "0.0..5.0")
            .claim("off", "never table.input2 rises while table.X.position > 1500")
        )

    first = made().run(workers=0, seconds=4, design=Design(search=30))
    assert first.num_rows == 30 and False in first["off"].to_pylist()
    again = tmp_path / "b.parquet"
    with pytest.raises(StoppedError):
        made().run(again, workers=0, seconds=4, design=Design(search=30), progress=stop_at(11))
    assert digest(made().run(again, workers=0, seconds=4, design=Design(search=30))) == digest(first)


def stop_at(number):
    def stop(done, _, __):
        if done == number:
            raise StoppedError

    return stop


def test_the_command(tmp_path):
    scene, out = stepper(tmp_path), tmp_path / "r.parquet"
    told = ("sweep", scene, "--vary", "table.X.load.torque=[0.1, 0.2]", "--measure", "end: final table.X.position")
    done = run(*told, "--vary", "wire.0.delay_ms=1..2", "--out", out, "--workers", 0, "--json")
    found = json.loads(done.out)
    assert (done.code, found["runs"], found["measures"]["end"]["max"]) == (0, 4, 1500)
    assert "axistwin: wire.0.delay_ms changed no measure and no claim in any run" in done.err
    assert run("sweep", out).out.startswith("4 runs (ended: 4 rest)")
    drawn = run("plot", out, "-o", tmp_path / "r.svg")
    assert (drawn.code, "<svg" in (tmp_path / "r.svg").read_text()) == (0, True)
    assert run("plot", out, "--from", 1).code == 2
    failing = run(*told, "--claim", "low: max table.X.position < 500", "--out", tmp_path / "f.parquet", "--workers", 0)
    assert failing.code == 1 and "low fails in 2 of 2 runs" in failing.err


@pytest.mark.parametrize(("words", "told"), [
    (["--vary", "seed"], "expected PATH=VALUES"), (["--vary", "seed=5..1"], "expected the lower value first"),
    (["--vary", "table.Q.load=1"], "is not in the scene"),
    (["--vary", "tabel.X.load.torque=1"], "did you mean 'table'?"),
    (["--vary", "seed=1", "--program", "missing.talk"], "missing.talk cannot be read"),
    (["--vary", "table.X.load.torqe=1"], "did you mean 'torque'?"),
    (["--vary", "table.X.load.torque=-1"], "cannot set table.X.load.torque to -1"),
    (["--vary", "seed=1", "--measure", "final table.X.lost"], "expected a name and an expression"),
    (["--vary", "seed=1", "--measure", "a: final table.X.lots"], "did you mean 'table.X.lost'?"),
    (["--vary", "seed=1", "--measure", "a: from table.inptu1 rises to table.input1 falls"], "scene: unknown pin"),
    (["--vary", "seed=1", "--measure", "seed: final table.X.lost"], "a column with the name 'seed' exists already"),
    (["--vary", "seed=1", "--vary", "seed=2"], "the setting seed is given twice"),
    (["--vary", "seed=1", "--search", "5"], "needs a claim (a condition for each run): add e.g. --claim"),
    (["--vary", "seed=1", "--out", "x.csv"], "ends in .parquet"), ([], "the sweep varies no value")])  # fmt: skip
def test_errors_are_reported_before_the_first_run(tmp_path, words, told):
    done = run("sweep", stepper(tmp_path), "--out", tmp_path / "x.parquet", *words)
    assert (done.code, done.out, len(done.err.splitlines())) == (2, "", 1) and told in done.err
    assert not (tmp_path / "x.parquet").exists() and not (tmp_path / "x.parquet.parts").exists()


STUDY = """
scene = "scene.toml"
for = 4
[vary]
"table.X.load.torque" = [0.1, 0.9]
[measure]
lost = "final table.X.lost"
[claim]
safe = "always table.X.lost < 100000"
"""


def test_a_sweep_file_is_run_and_checked(tmp_path):
    stepper(tmp_path)
    file = tmp_path / "study.toml"
    file.write_text(STUDY)
    assert run("check", file).code == 0
    done = run("sweep", file, "--out", tmp_path / "s.parquet", "--workers", 0, "--summary")
    assert (done.code, done.out.splitlines()[0][:6]) == (0, "2 runs")
    assert run("sweep", file, "--out", tmp_path / "s.parquet", "--seed", 3).err.endswith(
        f"set these values in {file}\n"
    )
    for old, wrong, line in (
        ("final table.X.lost", "final table.X.lots", 7),
        ("final table.X.lost", "finally", 7),
        ("[0.1, 0.9]", "[-1, 0.9]", 5),
        ("[0.1, 0.9]", '"0.1..0.9"', 5),
        ("load.torque", "limits.5", 5),
        ("load.torque", "lod.torque", 5),
    ):
        file.write_text(STUDY.replace(old, wrong))
        checked = run("check", file)
        assert checked.code == 1 and f"study.toml:{line}:1: error:" in checked.out
    file.write_text(STUDY.replace("for = 4", "four = 4"))
    assert "study.toml:3:1: error: invalid key four:" in run("check", file).out


def test_the_schema_of_a_sweep_file_has_every_form():
    schema = json.loads(run("schema", "--sweep").out)
    assert "from EVENT to EVENT [first|last|each]" in schema["properties"]["measure"]["description"]
    assert "for" in schema["properties"]


def test_a_runner_needs_the_scene_file_only_once(tmp_path):
    runner = Runner(study(tmp_path)._job(None))
    stepper(tmp_path).unlink()
    assert runner.row(0, (0.1, 7000))["ended"] == "rest"
