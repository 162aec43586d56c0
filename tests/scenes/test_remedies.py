"""A remedy leads out: an example in the message about a scene, taken literally, is accepted in its place."""

import re
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from axistwin import Scene
from axistwin.core.errors import AxistwinError

from ..told import examples, value

Place = tuple[str | int, ...]
SCENES: tuple[dict[str, Any], ...] = (
    {
        "seed": 3,
        "controller": [
            {"model": "if2", "name": "desk", "line": "9600 8N2", "state": "kept", "ports": ["tcp://127.0.0.1:0"],
             "axes": {"X": {"limits": [-100, 20000], "units": {"per": 80, "of": "mm"},
                            "encoder": {"counts_per_rev": 4000, "backlash": 3}, "load": {"torque": 0.1},
                            "motor": {"torque": [[0, 1.2], [5000, 0.4]], "inertia": 1e-5}}}},
            {"model": "1811", "name": "board", "options": {"part_number": "94-003657-01A", "buffer_bytes": 600},
             "axes": {"motor": {"home": [0, 2000], "encoder": {"counts_per_rev": 4000}}}},
        ],
        "wire": [{"from": "desk.output1", "to": "desk.input1", "delay_ms": 2.5}],
        "fault": [{"kind": "lose", "on": "desk.serial", "at": 0.01, "count": 3},
                  {"kind": "jam", "on": "desk.X", "when": "desk.X passes 10", "duration": 0.5}],
        "script": [{"at": 0.02, "on": "desk", "do": ["input1 high", "X.load 0.2"]}],
        "operator": {"button": [{"name": "go", "pin": "desk.input2"}],
                     "lamp": [{"name": "on", "pin": "desk.output2"}],
                     "selector": [{"name": "way", "positions": {"a": "desk.input3", "b": ""}}]},
    },
    {
        "controller": [
            {"model": "smartmotor", "name": "left", "history": 1000, "variables": {"a": 3, "KP": 50},
             "axes": {"shaft": {"motor": "frame17", "limits": [-5000, 5000], "load": {"inertia_kg_m2": 1e-5}}}},
            {"model": "smartmotor", "name": "right", "options": {"statements_per_sample": 2, "index_at": 5},
             "master": "left.shaft", "master_ratio": [1, 2]},
        ],
        "chain": [{"motors": ["left", "right"], "name": "line"}],
        "script": [{"at": 0.02, "on": "left", "do": ["A 2.5V", "ambient 40"]}],
    },
)  # fmt: skip
BAD = ("x", "", -1, 0, 1e30, 2.5, [], [5, 1], {"a": 1}, "a.b", "12 parsec")
ASSIGNED = re.compile(r"([a-z_]+) ?= ?(.+)")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """State directories are made in the working directory."""
    monkeypatch.chdir(tmp_path)


def places(table: Any, before: Place = ()) -> Iterator[Place]:
    keys = list(table) if isinstance(table, dict) else range(len(table)) if isinstance(table, list) else ()
    for key in keys:
        yield (*before, key)
        yield from places(table[key], (*before, key))


def inside(scene: Any, place: Place) -> Any:
    for key in place:
        scene = scene[key]
    return scene


def with_value(scene: dict[str, Any], place: Place, given: Any) -> dict[str, Any]:
    changed = deepcopy(scene)
    inside(changed, place[:-1])[place[-1]] = given
    return changed


def error_of(scene: dict[str, Any]) -> str:
    try:
        return next((str(error) for error in Scene.given(deepcopy(scene)).build_errors()), "")
    except AxistwinError as error:
        return str(error)


def told_place(message: str, default: Place) -> Place:
    found = re.match(r"the scene, (\S+): ", message)
    named = [int(word) if word.isdecimal() else word for word in re.findall(r"[^.\[\]]+", found[1])] if found else []
    place = tuple(named[: len(default)]) if named else default
    return (*place[:-1], "on") if "needs the name of" in message else place


def after(scene: dict[str, Any], place: Place, bad: Place, told: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the scene after each example in turn; all keys of an example such as `a=1 and b=2` are set together.

    `place`: where the message is; `bad`: where the bad value is, perhaps in the list that the message names.
    """
    assigned = [ASSIGNED.fullmatch(each) for each in told]
    if not all(assigned) or not told:
        for each in map(value, told):
            item = isinstance(inside(scene, place), list) and not isinstance(each, list)
            yield with_value(scene, bad if item else place, each)
        return
    table = place
    while not isinstance(inside(scene, table), dict):
        table = table[:-1]
    changed = scene
    for each in assigned:
        assert each is not None
        changed = with_value(changed, (*table, each[1]), value(each[2]))
    yield changed


PLACES = [pytest.param(scene, place, id=".".join(map(str, place))) for scene in SCENES for place in places(scene)]


@pytest.mark.parametrize(("scene", "place"), PLACES)
def test_an_example_in_a_message_about_a_scene_is_accepted(scene: dict[str, Any], place: Place) -> None:
    for bad in BAD:
        wrong = with_value(scene, place, bad)
        message = error_of(wrong)
        told = [each for each in examples(message) if not each.startswith("bus:")]  # the controllers have serial lines
        for mended in after(wrong, told_place(message, place), place, told):
            assert error_of(mended) == "", message


MISSPELT = re.compile(r"'([^']*)': did you mean '([^']*)'\?")


@pytest.mark.parametrize(("scene", "place"), PLACES)
def test_a_name_that_is_meant_is_accepted(scene: dict[str, Any], place: Place) -> None:
    given = inside(scene, place)
    for name in re.findall(r"\w{4,}", given) if isinstance(given, str) else []:
        wrong = given.replace(name, name[:-2] + name[:-3:-1], 1)
        message = error_of(with_value(scene, place, wrong))
        if (meant := MISSPELT.search(message)) and told_place(message, place) == place:
            mended = wrong.replace(meant[1], meant[2])
            assert error_of(with_value(scene, place, mended)) == "", message
