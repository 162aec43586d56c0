"""Results of a sweep: check sums, the lock, and a small instance of `benchmarks/robustness/sweep_journals.py`."""

import pytest

from axistwin.core.errors import UsageError
from axistwin.sweeps import journal, read, study

from .. import campaigns
from ..command import refused, run
from .scenes import stepper

pytest.importorskip("pyarrow", reason="the extra [traces] is not installed")


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    pytest.importorskip("optuna", reason="the extra [tune] is not installed")
    return campaigns.campaign("sweep_journals").Campaign(tmp_path_factory.mktemp("campaign"), seed=1811)


@pytest.mark.slow
def test_damages_are_one_line_or_change_nothing(campaign):
    campaign.run(24)
    assert campaign.found == [] and campaign.ends[".parquet one line"] > 12


@pytest.mark.slow
def test_two_processes_with_one_sweep(campaign):
    campaign.pairs(1)
    assert campaign.found == []


@pytest.fixture
def command(tmp_path):
    return ("sweep", stepper(tmp_path), "--vary", "seed=1..2", "--for", 0.01, "--workers", 0, "--out")


def test_the_command_says_who_writes_the_results(tmp_path, command):
    out = tmp_path / "a.parquet"
    with journal.Journal(out, {}, {}):
        code, told = refused(*command, out)
    assert (code, len(told.splitlines())) == (2, 1)
    assert f"{out} is being written by process " in told and "choose another file with --out" in told
    assert run(*command, tmp_path / "b.parquet").code == 0
    assert run(*command, out).code == 0  # the other process has ended
    assert sorted(path.name for path in tmp_path.glob("*.parquet*")) == ["a.parquet", "b.parquet"]


def test_a_study_has_one_writer(tmp_path):
    second = study.reserved(tmp_path / "a.db")
    with (
        study.reserved(tmp_path / "a.db"),
        pytest.raises(UsageError, match=r"a\.db is being written by process \d+ \("),
    ):
        second.__enter__()
    assert list(tmp_path.iterdir()) == []


def test_a_changed_byte_is_seen_by_every_reader(tmp_path, command):
    out = tmp_path / "a.parquet"
    assert run(*command, out).code == 0
    data = bytearray(out.read_bytes())
    data[len(data) // 3] ^= 1
    out.write_bytes(data)
    message = f"{out} is damaged, or not written by 'axistwin sweep': delete the file, and run the sweep again"
    for words in ((*command, out), ("sweep", out)):
        code, told = refused(*words)
        assert (code, message in told, len(told.splitlines())) == (2, True, 1)
    code, told = refused("plot", out, "-o", tmp_path / "a.svg")
    assert (code > 0, "is damaged" in told, len(told.splitlines())) == (True, True, 1)
    out.unlink()
    assert run(*command, out).code == 0


def test_results_without_a_check_sum_are_read(tmp_path, command):
    """Version 0.2.0 wrote none."""
    import pyarrow.parquet as pq

    out = tmp_path / "a.parquet"
    assert run(*command, out).code == 0
    found = read(out)
    plan = {key: value for key, value in found.schema.metadata.items() if key != b"axistwin.sum"}
    pq.write_table(found.replace_schema_metadata(plan), out)
    assert read(out).num_rows == 2
    pq.write_table(found.replace_schema_metadata({**plan, b"axistwin.sweep": b"{}"}), out)
    with pytest.raises(UsageError, match="is damaged"):
        read(out)


def test_scenes_of_failing_runs_that_cannot_be_written_are_told(tmp_path, command):
    (tmp_path / "a-failing").write_text("a file in the place of the folder")
    done = run(*command, tmp_path / "a.parquet", "--claim", "never: max table.X.position < -1")
    assert done.code == 1
    assert done.err.startswith(f"axistwin: no scenes of failing runs: cannot write {tmp_path / 'a-failing'}: ")
