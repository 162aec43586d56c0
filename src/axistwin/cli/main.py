"""The command line: `axistwin COMMAND`.  A command's module is imported when the command is asked for.

Results go to stdout, words for people to stderr.  Exit codes: 0 done, 1 the thing asked about has errors, 2 wrong
usage, 130 interrupted.
"""

import errno
import os
import sys
from importlib import import_module
from typing import Any

import click

from axistwin.errors import AxistwinError, LinkError, UsageError, one_line
from axistwin.version import VERSION

COMMANDS = {
    "demo": "A short session that needs nothing but the package.",
    "serve": "Put controllers on real ports: TCP, pty, RFC2217, serial, bus.",
    "record": "Between a host and a real controller, write what they say and when.",
    "replay": "Let a virtual controller answer a recorded host, and tell where it differs.",
    "run": "Run a program or a conversation at full speed.",
    "plot": "Draw a trace.",
    "diff": "Find the first difference between two traces.",
    "check": "Find what is wrong with programs and scenes.",
    "commands": "List every command of a model.",
    "faults": "List every fault that a bench can have.",
    "schema": "The JSON Schema of a scene file, for editors.",
    "lsp": "The language server, for editors.",
    "term": "An interactive terminal on a virtual or a real controller.",
}
"""Each is the click command of that name in the module `axistwin.cli.<name>`."""

UNWRITABLE = {errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EBADF}
"""What can be wrong with the place that the output goes to."""


class LazyGroup(click.Group):
    """A group that knows its commands by name, and imports the one that is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        """In the order in which people meet them."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """Import the command, or None if there is none of this name."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = getattr(import_module(f"axistwin.cli.{cmd_name}"), cmd_name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """The list of commands, without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(VERSION, "--version", prog_name="axistwin")
def axistwin() -> None:
    """Legacy motion controllers without the hardware.

    \b
    axistwin demo                      see it work
    axistwin serve if1 --tcp :5001     an IF1 for your host program
    axistwin run if1 moves.if1         what would these lines do?
    """


def main(arguments: list[str] | None = None) -> None:
    """The program `axistwin`."""
    sys.exit(_run(arguments))


def _run(arguments: list[str] | None) -> int:
    if sys.stdout is None:  # it was closed
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  # for as long as the program runs
    try:
        result: Any = axistwin.main(arguments, prog_name="axistwin", standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.Abort:  # what click makes of Ctrl-C
        return 130
    except KeyboardInterrupt:
        return 130
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except BrokenPipeError:  # whoever read the output has gone
        _give_up_output()
        return 1
    except OSError as error:
        if error.errno not in UNWRITABLE or error.filename is not None:
            raise
        _give_up_output()
        print(f"axistwin: the output cannot be written: {os.strerror(error.errno).lower()}", file=sys.stderr)
        return 1
    except AxistwinError as error:
        print(f"axistwin: {one_line(str(error))}", file=sys.stderr)
        return 2 if isinstance(error, UsageError | LinkError) else 1
    return result if isinstance(result, int) else 0


def _give_up_output() -> None:
    """Python would complain when it flushes at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
