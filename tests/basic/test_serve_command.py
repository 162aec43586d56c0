"""Two separate programs: PC-BASIC with a listing of the manual, and `axistwin serve`."""

import asyncio
import csv
import sys
from asyncio.subprocess import DEVNULL, PIPE
from pathlib import Path

import pytest

from .interpreter import run_basic
from .listings import MANUAL, runnable, source

pytestmark = pytest.mark.skipif(not MANUAL.exists(), reason="the manual is not here")

AXISTWIN = ("-c", "from axistwin.cli.program import main; main()")


async def serve_while_basic_runs(program: int, directory: Path, *options: str) -> tuple[str, int | None]:
    """Return what the program has printed, and the exit code of the server after a request to end."""
    server = await asyncio.create_subprocess_exec(
        *(sys.executable, *AXISTWIN, "serve", "if1", "--tcp", "127.0.0.1:0", *options), stdout=PIPE, stderr=DEVNULL
    )
    assert server.stdout is not None
    try:
        ready = (await server.stdout.readline()).decode().split()
        assert ready[:3] == ["if1", "listening", "on"]
        address = ready[3].removeprefix("tcp://")
        screen = await run_basic(source(runnable(program)), f"SOCKET:{address}", {}, asyncio.Event().wait, directory)
    finally:
        if server.returncode is None:
            server.terminate()
        await server.wait()
    return screen, server.returncode


@pytest.mark.slow
def test_sample_7_moves_the_axes_of_a_served_if1(tmp_path):
    """At full speed; the trace contains every pulse of X forth, Y forth, X back and Y back."""
    trace = tmp_path / "moves.csv"
    options = ("--speed", "max", "--line", "2400 8N2", "--option", "self_test_s=0", "--trace", str(trace))

    screen, code = asyncio.run(serve_while_basic_runs(7, tmp_path, *options))

    assert code == 0
    assert "U" in screen.split() and "ERROR" not in screen
    with trace.open(newline="") as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        pulses = [row[1:] for row in rows if row[1].endswith(".pulses")]
    up, down = range(1, 1001), range(999, -1, -1)
    expected = [(axis, count) for axis, counts in (("X", up), ("Y", up), ("X", down), ("Y", down)) for count in counts]
    assert pulses[:3] == [[f"if1.{axis}.pulses", "0"] for axis in "XYZ"]
    assert pulses[3:] == [[f"if1.{axis}.pulses", str(count)] for axis, count in expected]
