"""Run the program `axistwin` in tests: in this process, or in a separate one for signals and real output."""

import io
import re
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from typing import NamedTuple
from unittest.mock import patch

from axistwin.cli.program import main
from axistwin.links.urls import PortUrl, parse

PATIENCE_S = 300
"""A test that waits longer than this has failed."""
PROGRAM = (sys.executable, "-c", "from axistwin.cli.program import main; main()")
AT_ONCE = ("--speed", "max", "--line", "instant")
LISTENING = re.compile(r"(\S+) listening on (\S+)")

Running = subprocess.Popen[str]


class Finished(NamedTuple):
    """The end of a run: exit code, standard output, standard error."""

    code: int
    out: str
    err: str


def run(*arguments: object, typed: str = "") -> Finished:
    """Run the program in this process, with a file of the typed lines as its standard input."""
    out, err, threads = io.StringIO(), io.StringIO(), set(threading.enumerate())
    with tempfile.TemporaryFile("w+") as lines, patch.object(sys, "stdin", lines):
        lines.write(typed)
        lines.seek(0)
        with redirect_stdout(out), redirect_stderr(err):
            try:
                main([str(argument) for argument in arguments])
            except SystemExit as end:
                code = end.code
        for thread in set(threading.enumerate()) - threads:  # the thread that reads the file
            thread.join(PATIENCE_S)
    assert isinstance(code, int)
    return Finished(code, out.getvalue(), err.getvalue())


def refused(*arguments: object) -> tuple[int, str]:
    """Return the exit code and the message of a run in this process that prints no result."""
    done = run(*arguments)
    assert done.out == ""
    return done.code, done.err


@contextmanager
def running(*arguments: object, **options: object) -> Iterator[Running]:
    """Start the program in a separate process, and kill it at the end of the block."""
    words = [*PROGRAM, *map(str, arguments)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options) as program:
        try:
            yield program
        finally:
            program.kill()


@contextmanager
def serving(*arguments: object, command: str = "serve", ports: int = 1, **options: object):
    """Start a server; yield the program and its ports, by the names of their controllers."""
    with running(command, *arguments, **options) as program:
        yield program, [listening(program) for _ in range(ports)]


def listening(program: Running) -> tuple[str, PortUrl]:
    """Read the line of a port: the controller's name and the URL."""
    line = program.stdout.readline().strip()
    found = LISTENING.fullmatch(line)
    assert found, line + program.stderr.read()
    return found[1], parse(found[2])


def ended(program: Running, number: int = signal.SIGTERM) -> tuple[int, str]:
    """Send a signal to the program; return its exit code and its messages until its end."""
    program.send_signal(number)
    _, messages = program.communicate()
    return program.returncode, messages
