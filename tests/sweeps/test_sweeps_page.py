"""The examples and tables of `docs/sweeps.md` are correct and complete, and those of `docs/tuning.md` are correct."""

import re
import shlex
from pathlib import Path

import pytest

from axistwin.sweeps import CLAIMS, MEASURES

from ..command import run
from ..test_tutorials import acts, files

pytest.importorskip("pyarrow", reason="the extra [traces] is not installed")
PAGES = Path(__file__).parents[2] / "docs"
PAGE = (PAGES / "sweeps.md").read_text(encoding="utf-8")


def table(forms):
    rows = (
        f"| `{form.form.replace('|', '¦')}` | {form.meaning} | `{form.example.replace('|', '¦')}` |" for form in forms
    )
    return "\n".join(["| EXPRESSION | meaning | example |", "| --- | --- | --- |", *rows]).replace("¦", r"\|")


@pytest.mark.parametrize("forms", [MEASURES, CLAIMS], ids=["measures", "claims"])
def test_the_tables_have_every_form(forms):
    assert table(forms) in PAGE


def test_the_page_does_what_it_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, body in files(PAGE).items():
        Path(name).write_text(body)
    ((command, shown),) = acts(PAGE)
    done = run(*shlex.split(command)[1:], "--workers", 0)
    assert done.out + done.err == shown
    (program,) = re.findall(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    exec(compile(program, "docs/sweeps.md", "exec"), {})
    study = next(
        body for body in re.findall(r"^```toml\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE) if "[vary]" in body
    )
    Path("study.toml").write_text(study)
    assert run("check", "study.toml").code == 0


@pytest.mark.slow
def test_the_page_of_tuning_does_what_it_shows(tmp_path, monkeypatch):
    pytest.importorskip("optuna", reason="the extra [tune] is not installed")
    monkeypatch.chdir(tmp_path)
    page = (PAGES / "tuning.md").read_text(encoding="utf-8")
    for name, body in files(page).items():
        Path(name).write_text(body)
    ((command, shown),) = acts(page)
    done = run(*shlex.split(command)[1:], "--workers", 0)
    assert done.out + done.err == shown
    (program,) = re.findall(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    exec(compile(program, "docs/tuning.md", "exec"), {})
