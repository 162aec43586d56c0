"""The page "A device of your own": each block and command of it is executed."""

import re
import shlex
import sys
import tomllib
from pathlib import Path
from struct import pack, unpack
from textwrap import indent

import pytest

from axistwin.controllers.registry import GROUP
from axistwin.devices import add8
from axistwin.testing import device_checks

from ..command import ended, listening, run, running
from ..test_tutorials import acts, files, lay_out, printed
from .made import ask, on_a_bench

PAGE = (Path(__file__).parents[2] / "docs" / "devices.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
METHODS = [body for kind, body in BLOCKS if kind == "python" and body not in files(PAGE).values()]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    lay_out(PAGE, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def made(name, text):
    """Return a class of this text; the checks ask for the module of a class."""
    module = type(sys)(f"page_{name.lower()}")
    sys.modules[module.__name__] = module
    exec(compile(text, f"{module.__name__}.py", "exec"), vars(module))
    return getattr(module, name)


@pytest.fixture(scope="module")
def whole():
    """Return the device of the page with all methods of the page."""
    return made("Stage", "\n".join((files(PAGE)["stage.py"], *(indent(body, "    ") for body in METHODS))))


def test_each_block_is_executed():
    assert [kind for kind, _ in BLOCKS] == ["python", "talk", "console", "toml", *["python"] * 7, "toml"]
    assert len(METHODS) == 5 and len(PAGE.split()) <= 1200


def test_the_first_files(folder):
    for command, expected in acts(PAGE):
        assert printed(command, folder) == expected
    assert re.match(r"\.{3}s?\.", printed("pytest -qq", folder))


@pytest.mark.slow
def test_the_commands(folder):
    words = re.findall(r"^\| `(\w.*?)` \|", PAGE.split("… | |")[1].split("\n\n")[0], re.MULTILINE)
    assert words == ["commands stage", "term stage", "serve stage --tcp :5001 --panel 8080", "check stage first.talk"]
    axistwin = ["--device", "stage.py"]
    assert printed("axistwin --device stage.py commands stage", folder).count("\n") == 4
    assert printed("axistwin --device stage.py check stage first.talk", folder) == ""
    assert printed("axistwin --device stage.py check scene.toml && echo fine", folder) == "fine\n"
    with running(*axistwin, *shlex.split(words[2].replace("5001", "0").replace("8080", "0")), cwd=folder) as program:
        assert program.stdout.readline().startswith("panel on http://127.0.0.1:")
        assert listening(program)[0] == "stage"
        ended(program)
    with running(*axistwin, *words[1].split(), "--speed", "max", stdin=-1, cwd=folder) as program:
        out, _ = program.communicate("1PA50\n1TP\n", timeout=300)
    assert "< P50<CR>" in out
    assert run("new", folder / "new", "--device", "--yes").code == 0 and "`axistwin new stage --device`" in PAGE


def test_the_methods_of_the_page(whole):
    made = on_a_bench(whole, delay=0.5, **{"1": {"home": (300, 400)}})
    controller = made[1]
    assert ask(*made, b"1PA10000\r1OR\r", 5.11) == b"OK\r"  # in motion: refused
    assert ask(*made, b"TE\rTE\r1TP\r") == b"30\r0\rP10000\r"
    assert ask(*made, b"1OR\r", 20) == b"HOMED\r"  # the switch is left at 401, and the axis moves on by 100
    assert (controller.axes["1"].position, ask(*made, b"1TP\r")) == (501, b"P100\r")
    assert ask(*made, b"1VA5001\rTE\rNONSENSE\rTE\r") == b"7\r6\r"
    assert ask(*made, b"1PA1.5\rTE\r3PA1\rTE\r") == b"8\r8\r"
    assert ask(*made, b"2VA50\r2TP\r", 0.51) == b"P0\r"  # it waits for the velocity, and its answer comes first
    assert ask(*made, b"SM\r", 0.1) == b"OK\r" and controller.store.load() == b'{"1": 2000, "2": 50}'
    controller.pins["gate"].drive(True)
    assert ask(*made, b"") == b"" and ask(*made, b"TS\r") == b"S018\r"
    assert ask(*made, b"", 2) == b"PART\r"  # 100 at 50, with ramps of 0.01 s
    assert (controller.pins["lamp"].level, controller.read("status"), controller.axes["2"].position) == (True, 16, 100)
    controller.power_cycle()
    assert ask(*made, b"2PA50\r", 1.01) == b"OK\r" and controller.axes["2"].position == 150  # at 50/s


@pytest.mark.parametrize("check", ["repeated", "power", "distance", "apart", "reachable"])
def test_the_whole_device_keeps_what_every_device_keeps(whole, check):
    next(one for one in device_checks(whole) if one.id == check).values[0]()


def test_the_module():
    module = on_a_bench(made("Module", files(PAGE)["module.py"]))

    def asked(code, motor, value=0, seconds=0.01):
        data = pack(">BBi", code, motor, value)
        return unpack(">BBix", ask(*module, data + add8(data), seconds))

    assert asked(4, 0, 500, 0.61) == (4, 0, 0)
    assert [asked(6, 0), asked(6, 1), asked(7, 0)] == [(6, 0, 500), (6, 2, 0), (7, 2, 0)]


def test_the_entry_point_is_in_the_group():
    scene, text = (tomllib.loads(body) for kind, body in BLOCKS if kind == "toml")
    assert scene["controller"] == [{"model": "stage", "axes": {"1": {"limits": [-500, 20_000], "home": [300, 400]}}}]
    assert text == {"project": {"entry-points": {GROUP: {"stage": "my_stage:Stage"}}}}
