"""The tutorials for hosts of the 1980s: the commands of each page are run, and must print what the page shows.

`axistwin serve` in a page runs at twenty times real time here, on a free port.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import axistwin

from .command import run
from .test_tutorials import CONSOLE, HOME, acts, files, page

SPEED = 20.0
"""Times real time.  The programs have time limits of seconds on their own clock."""
PATIENCE_S = 300
NEEDS = {"basic": [], "dos": ["nasm", "dosbox"], "qemu": ["nasm", "qemu-system-i386"], "c": ["gcc"]}
EXAMPLE = HOME / "examples" / "old-hosts"


@pytest.fixture(params=NEEDS)
def name(request):
    for program in NEEDS[request.param]:
        if not shutil.which(program):
            pytest.skip(f"{program} is not installed")
    if request.param == "basic":
        pytest.importorskip("pcbasic", reason="PC-BASIC is not installed")
    return request.param


def printed(commands, directory):
    """Return the standard output of the commands in one shell, without a display and with an open keyboard."""
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": str(HOME / "src"),
        "SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy", "HOME": str(directory),
    }  # fmt: skip
    keyboard, typist = os.pipe()
    try:
        done = subprocess.run(
            commands,
            shell=True,
            cwd=directory,
            env=environment,
            stdin=keyboard,
            capture_output=True,
            timeout=PATIENCE_S,
        )
    finally:
        os.close(keyboard)
        os.close(typist)
    return done.stdout.decode().replace("\r\n", "\n")


def own(text):
    """Return a command's output without the messages of the host's program about its own start."""
    return "".join(line for line in text.splitlines(keepends=True) if re.fullmatch(r"-?\d+\n", line))


def test_a_page_prints_what_it_shows(name, tmp_path):
    text = page(name)
    (copy, copied), (serve, ports) = acts(text)[:2]
    assert copy == "axistwin examples old-hosts hosts"
    assert run("examples", "old-hosts", tmp_path / "hosts").out.replace(f"{tmp_path}/", "") == copied

    scene = tmp_path / serve.removeprefix("axistwin serve ")
    declared = axistwin.Scene.load(scene).ports
    assert "".join(f"{controller} listening on {url}\n" for controller, url in declared) == ports
    with axistwin.serve(scene, speed=SPEED) as twin:
        free = {re.search(r"\d+$", url)[0]: str(twin.ports[controller].port) for controller, url in declared}

        def on_free_ports(words):
            return re.sub(r"(?<=[.\d]{9}:)\d+|(?<=port:)\d+", lambda port: free[port[0]], words)

        for file in (tmp_path / "hosts").glob("*.conf"):
            file.write_text(on_free_ports(file.read_text()))
        block = CONSOLE.findall(text)[1]
        shown = "".join(output for _, output in acts(f"```console\n{block}```\n"))
        script = "\n".join(command for command, _ in acts(f"```console\n{block}```\n"))
        assert own(printed(on_free_ports(script), tmp_path)) == shown
        where = {"if1": twin.bench["if1"].axes["X"].position, "1811": twin.bench["1811"].axes["motor"].position}
    assert where == ({"if1": 0, "1811": 25000} if name == "c" else {"if1": 1000, "1811": 0})


@pytest.mark.parametrize("name", ["basic", "dos", "c"])
def test_the_files_of_a_page_are_those_of_the_example(name):
    shown = files(page(name))
    assert shown
    for file, body in shown.items():
        assert (EXAMPLE / Path(file).name).read_bytes().decode("cp437").replace("\r\n", "\n") == body
