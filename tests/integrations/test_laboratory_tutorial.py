"""The tutorial for laboratories: its commands are run, and must print what it shows.

Commands with `&` run until the end.
"""

import re
import shlex
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from ..test_tutorials import acts, lay_out, page
from .conftest import environment, free_port

SECTIONS = {"A bluesky scan": ("bluesky", "ophyd_async"), "EPICS": ("caproto",), "OPC UA: ": ("asyncua",)}


def section(title):
    return next(part for part in re.split(r"^## ", page("laboratory"), flags=re.MULTILINE) if part.startswith(title))


class Shell:
    def __init__(self, directory, port, background):
        self.directory, self.background = directory, background
        self.environment = environment(port)

    def run(self, command, shown):
        """Run a command; return its output, or of a background command as many lines as are shown."""
        words = shlex.split(command.removesuffix("&"))
        program, *rest = words
        python = [sys.executable, "-W", "ignore"]
        if program == "axistwin":
            words = [*python, "-m", "axistwin", *rest]
        elif program == "python":
            words = [*python, *rest]
        else:
            words = [str(Path(sys.executable).parent / program), *rest]
        to = {"cwd": self.directory, "env": self.environment, "text": True, "stdout": subprocess.PIPE}
        if not command.endswith("&"):
            return subprocess.run(words, check=True, **to).stdout
        at = words.index(">") if ">" in words else len(words)
        process = subprocess.Popen(words[:at], **to)
        self.background.callback(self.end, process)
        lines = [process.stdout.readline() for _ in shown.splitlines() or [""]]
        return "".join(lines) if shown else ""

    def end(self, process):
        process.terminate()
        process.wait()
        process.stdout.close()


@pytest.mark.slow
@pytest.mark.parametrize("title", SECTIONS)
def test_a_section_prints_what_it_shows(title, tmp_path):
    for library in SECTIONS[title]:
        pytest.importorskip(library, reason=f"{library} is not installed")
    port = str(free_port())
    lay_out(page("laboratory").replace("4840", port), tmp_path)
    text = section(title).replace("127.0.0.1:5001", f"127.0.0.1:{port}").replace("4840", port)
    text = text.replace("axistwin opcua motor.toml", f"axistwin opcua motor.toml --port {port}")
    text = text.replace("--speed 5", "--speed 5 --option slide.timeout=60")  # the computer may be slow
    with ExitStack() as background:
        shell = Shell(tmp_path, int(port), background)
        ran = acts(text)
        for command, shown in ran:
            assert shell.run(command, shown) == shown, command
        assert len(ran) >= 2
