"""The examples and pages that come with axistwin."""

import json
import re
import webbrowser
from pathlib import Path

import pytest

from ..command import refused, run

NAMES = ["cut-to-length", "devices", "drill", "gains", "old-hosts", "stand-in", "winder", "xy-table"]


def test_the_examples_are_listed():
    assert [line.split()[0] for line in run("examples").out.splitlines()[1:]] == NAMES
    listed = json.loads(run("examples", "--json").out)["examples"]
    assert [one["name"] for one in listed] == NAMES
    assert listed[2] == {"name": "drill", "title": "An X-Y table with a drill", "scene": "scene.toml"}


@pytest.mark.parametrize("name", [name for name in NAMES if name != "devices"])
def test_a_copied_example_has_no_errors(tmp_path, name):
    done = run("examples", name, tmp_path / "mine")
    command, scene = re.search(r"next: axistwin (.*) (\S+)\n", done.err).groups()
    assert command == ("stand-in --dry-run" if name == "stand-in" else "run")
    assert Path(scene).parent == tmp_path / "mine"
    assert set(done.out.split()) == {str(path) for path in (tmp_path / "mine").rglob("*") if path.is_file()}
    assert run("check", scene).code == 0


def test_nothing_is_overwritten(tmp_path):
    mine = tmp_path / "drill.if1"
    mine.write_text("mine")
    assert refused("examples", "drill", tmp_path) == (
        2, f"axistwin: {mine} exists already: choose another directory\n",
    )  # fmt: skip
    assert [path.name for path in tmp_path.iterdir()] == ["drill.if1"]
    assert mine.read_text() == "mine"


@pytest.mark.parametrize(("words", "message"), [
    (["examples", "dril", "x"], "no example 'dril': did you mean drill?"),
    (["examples", "zzz", "x"],
     "no example 'zzz': expected cut-to-length, devices, drill, gains, old-hosts, stand-in, winder, xy-table"),
    (["examples", "drill"],
     "the directory for the example is missing: expected e.g. 'axistwin examples drill my-drill'"),
    (["docs", "prots"], "no page 'prots': did you mean ports?")])  # fmt: skip
def test_wrong_arguments_are_refused(words, message):
    assert refused(*words) == (2, f"axistwin: {message}\n")


def test_json_is_for_the_list_only():
    assert json.loads(run("docs", "--json").err)["exit_code"] == 2


def test_a_directory_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").touch()
    assert refused("examples", "drill", tmp_path / "file" / "x")[0] == 2
    assert refused("docs", "--out", tmp_path / "file" / "x")[0] == 2


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    place = tmp_path_factory.mktemp("pages")
    done = run("docs", "scenes", "--out", place)
    assert (done.code, done.out) == (0, (place / "docs" / "scenes.html").as_uri() + "\n")
    return place


def test_every_link_of_the_pages_has_a_target(site):
    texts = {page.resolve(): page.read_text(encoding="utf-8") for page in site.rglob("*.html")}
    dead = []
    for page, text in texts.items():
        for link in re.findall(r'(?:href|src)="(?![a-z]+:)([^"]+)"', text):
            path, _, anchor = link.partition("#")
            target = (page.parent / path).resolve() if path else page
            if not target.exists() or (anchor and f'id="{anchor}"' not in texts[target]):
                dead.append((page.name, link))
    assert dead == []


def test_every_page_of_the_list_is_written_with_its_title(site):
    listed = json.loads(run("docs", "--list", "--json").out)["pages"]
    assert len(listed) > 30
    for page in listed:
        assert "<h1" in (site / "docs" / f"{page['name']}.html").read_text(encoding="utf-8")
    assert [line.split()[0] for line in run("docs", "--list").out.splitlines()[1:]] == [page["name"] for page in listed]


def test_a_page_is_opened_in_the_browser(tmp_path, monkeypatch):
    opened = []
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or len(opened) == 1)
    first, second = run("docs", "ports"), run("docs")
    assert opened == [first.out.strip(), second.out.strip()] and first.err == ""
    assert second.err.startswith("axistwin: no browser was found")


def test_a_page_is_printed_as_text():
    assert run("docs", "scenes.md", "--text").out.startswith("# Scenes\n")
    assert "{include}" not in run("docs", "diagnostics", "--text").out
