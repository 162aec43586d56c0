"""Runs on a Dask cluster give the same rows; a cluster that cannot be used is refused before the first run."""

import socket

import pytest

from axistwin.core.errors import UsageError
from axistwin.sweeps import Sweep, Tuning, cluster, digest, read

from ..command import run
from .scenes import stepper


@pytest.fixture
def scheduler():
    distributed = pytest.importorskip("distributed", reason="the extra [cluster] is not installed")
    options = {"processes": False, "dashboard_address": None, "n_workers": 1, "threads_per_worker": 1}
    with distributed.LocalCluster(**options, protocol="tcp", host="127.0.0.1") as local:
        yield local.scheduler_address
        cluster.end_processes()


def sweep(directory):
    return Sweep(stepper(directory)).vary("table.X.load.torque", "0.1..0.6:3").measure("lost", "final table.X.lost")


@pytest.mark.slow
def test_a_cluster_gives_the_rows_of_this_process(tmp_path, scheduler, monkeypatch):
    found = sweep(tmp_path).run(tmp_path / "a.parquet", seconds=3, scheduler=scheduler)
    assert digest(found) == digest(sweep(tmp_path).run(seconds=3, workers=0))
    assert {worker.partition(":")[0] for worker in found["worker"].to_pylist()} == {"tcp"}
    monkeypatch.setattr(cluster, "VERSION", "0.0.1")
    with pytest.raises(UsageError, match=r"but this computer has axistwin 0\.0\.1: install the same version"):
        sweep(tmp_path).run(tmp_path / "b.parquet", scheduler=scheduler)


def test_another_program_at_the_address_is_refused(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="the extra [cluster] is not installed")
    monkeypatch.setattr(cluster, "CONNECT_S", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(UsageError, match=f"no scheduler answers at {address}"):
            sweep(tmp_path).run(tmp_path / "a.parquet", scheduler=address)
    assert not (tmp_path / "a.parquet.parts").exists()


@pytest.mark.slow
def test_a_lost_scheduler_ends_a_sweep_that_can_be_continued(tmp_path):
    distributed = pytest.importorskip("distributed", reason="the extra [cluster] is not installed")
    options = {"processes": False, "dashboard_address": None, "n_workers": 1, "threads_per_worker": 1}
    local = distributed.LocalCluster(**options, protocol="tcp", host="127.0.0.1")
    out, made = tmp_path / "a.parquet", sweep(tmp_path)
    with pytest.raises(UsageError, match="the same command continues the sweep"):
        made.run(out, seconds=3, scheduler=local.scheduler_address, progress=lambda *_: local.close())
    cluster.end_processes()
    kept, left = read(out).num_rows, []
    found = sweep(tmp_path).run(out, seconds=3, workers=0, progress=lambda done, *_: left.append(done))
    assert (left, found.num_rows) == ([*range(kept + 1, 4)], 3)
    assert digest(found) == digest(sweep(tmp_path).run(seconds=3, workers=0))


@pytest.mark.slow
def test_a_study_runs_on_a_cluster(tmp_path, scheduler):
    pytest.importorskip("optuna", reason="the extra [tune] is not installed")
    made = Tuning(stepper(tmp_path), "max table.X.velocity", maximise=True).change("table.X.load.torque", "0.1..0.4")
    on_a_cluster = made.run(tmp_path / "a.db", trials=2, seconds=3, scheduler=scheduler)
    assert on_a_cluster.trials == made.run(tmp_path / "b.db", trials=2, seconds=3, workers=0).trials


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nowhere"])
def test_a_missing_scheduler_is_refused_before_the_first_run(tmp_path, address):
    pytest.importorskip("distributed", reason="the extra [cluster] is not installed")
    words = ("sweep", stepper(tmp_path), "--vary", "seed=1..2", "--out", tmp_path / "x.parquet")
    done = run(*words, "--scheduler", address)
    assert (done.code, done.out, len(done.err.splitlines())) == (2, "", 1)
    assert f"no scheduler answers at {address}" in done.err
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith("x.")] == []
