"""`axistwin check` accepts exactly the scenes that can be built, and finds the same errors."""

import random
import re
import shutil
import tomllib
from pathlib import Path

import pytest

from axistwin import Scene
from axistwin.core.errors import AxistwinError
from axistwin.scenes.diagnostics.scenes import diagnose_scene

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENES = ("xy-table.toml", "drill/scene.toml", "winder/scene.toml", "cut-to-length/scene.toml")
CHAIN = """[[controller]]
model = "smartmotor"
name = "left"
[[controller]]
model = "smartmotor"
name = "right"
{more}
[[chain]]
motors = ["left"]
[[script]]
at = 1
on = "{on}"
do = "load a.sms"
"""


def complaints(scene: Path) -> tuple[list[str], list[str]]:
    checked = [f"{each.line}:{each.column}: {each.message}" for each in diagnose_scene(scene)]
    try:
        Scene.load(scene).build()
    except AxistwinError as error:
        return checked, [str(error)]
    return checked, []


@pytest.fixture
def scene(tmp_path):
    def write(text: str) -> Path:
        (tmp_path / "s.toml").write_text(text)
        return tmp_path / "s.toml"

    (tmp_path / "a.sms").write_text("a=1 " * 100 + "END\n")  # 404 bytes
    return write


def test_a_program_loaded_into_a_motor_of_a_chain(scene):
    checked, built = complaints(scene(CHAIN.format(on="left", more="")))
    told = "left shares its serial line with other motors: expected a motor with its own serial line"
    assert checked == [f"13:6: {told}"] and [error.endswith(f"s.toml:13:1: {told}") for error in built] == [True]
    assert complaints(scene(CHAIN.format(on="right", more=""))) == ([], [])


@pytest.mark.parametrize(("more", "message"), [
    ("options.program_bytes = 256", "too many for the program memory of the motor"),
    ('line = "1200 7E1"', "check that the motor uses the line format 1200 7E1")])  # fmt: skip
def test_a_program_that_the_motor_refuses(scene, more, message):
    checked, built = complaints(scene(CHAIN.format(on="right", more=more)))
    assert len(checked) == len(built) == 1 and message in checked[0]
    assert message in built[0]


@pytest.mark.parametrize(("wires", "message"), [
    ([("b.output1", "a.home"), ("b.output2", "a.home_enable")],
     "a.home_enable and a.home are two names of one terminal, which can have only one wire: remove a wire"),
    ([("a.home", "b.home"), ("b.home_enable", "a.home_enable")], "form a loop through a.home_enable"),
    ([("b.output1", "a.home"), ("b.output1", "a.trigger1")], "")])  # fmt: skip
def test_a_terminal_of_two_names(scene, wires, message):
    """`home` and `home_enable` of an 1811 are the same pin."""
    boards = "".join(f'[[controller]]\nmodel = "1811"\nname = "{name}"\n' for name in "ab")
    ends = "".join(f'[[wire]]\nfrom = "{source}"\nto = "{target}"\n' for source, target in wires)
    checked, built = complaints(scene(boards + ends))
    if not message:
        assert (checked, built) == ([], [])
        return
    assert checked[0].startswith("12:6: ") and message in checked[0]
    assert message in built[0]


def values(text: str) -> list[str]:
    """Return the words and numbers of a file, which mutations exchange for one another."""
    return re.findall(r'"[^"\n]*"|[\w.-]+', text)


def mutated(text: str, chance: random.Random) -> str:
    lines = text.splitlines()
    at = chance.randrange(len(lines))
    match chance.randrange(4):
        case 0:
            del lines[at]
        case 1:
            lines.insert(at, chance.choice(lines))
        case 2:
            lines[at] = lines[at].replace(chance.choice(values(lines[at]) or ["="]), chance.choice(values(text)), 1)
        case _:
            numbers = ("-1", "0", "1e400", "9" * 20, "nan", "inf", "1e12", "true", '"x"', "[]", "0.5", "{}", '""')
            lines[at] = re.sub(r"=\s*[^\s\[{]+", lambda _: f"= {chance.choice(numbers)}", lines[at], count=1)
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", SCENES)
def test_mutated_examples(name, tmp_path):
    """For 25 mutations of each example, check and build report the same errors at the same places."""
    directory = tmp_path / "scene"
    shutil.copytree((EXAMPLES / name).parent, directory)
    file = directory / Path(name).name
    text, chance, accepted = file.read_text(encoding="utf-8"), random.Random(name), 0
    for _ in range(25):
        file.write_text(mutated(text, chance), encoding="utf-8")
        checked, built = complaints(file)
        assert bool(checked) == bool(built), (checked, built, file.read_text(encoding="utf-8"))
        accepted += not checked
    assert 0 < accepted < 25 and tomllib.loads(text)
