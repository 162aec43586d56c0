"""The examples in `docs/begin.md` are correct."""

import json
import re
import shlex
from pathlib import Path

from ..command import run

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "begin.md").read_text(encoding="utf-8")


def test_the_examples_of_the_page_are_correct(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    consoles = re.findall(r"^```console\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    acts = [
        act for block in consoles for act in re.findall(r"^\$ axistwin (.*)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE)
    ]
    assert [run(*shlex.split(words)).out for words, _ in acts] == [shown for _, shown in acts] and len(acts) == 5


def test_the_error_in_json_is_that_of_the_page():
    (shown,) = re.findall(r"^\{.*\}$", PAGE, re.MULTILINE)
    assert json.loads(run("rnu", "--json").err) == json.loads(shown)


def test_no_page_names_a_package_index():
    docs = [page for page in (ROOT / "docs").rglob("*.md") if "generated" not in page.parts]
    pages = [ROOT / "README.md", *docs, *(ROOT / "src").rglob("*.py")]
    named = re.compile(r"pip install \\?[\"']?axistwin(?![\w./-]*\.whl)")
    assert [page.name for page in pages if named.search(page.read_text(encoding="utf-8"))] == []
