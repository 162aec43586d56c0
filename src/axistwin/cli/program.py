"""The command line: `axistwin COMMAND`.  The module of a command is imported when the command is used.

Results go to stdout, messages to stderr; with --json an error is a JSON object on stderr.  Exit codes: 0 done, 1 errors
in the checked or executed program, 2 wrong usage (a missing file or port too), 130 interrupted.
"""

import errno
import os
import sys
from importlib import import_module
from io import TextIOWrapper
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from axistwin.core.errors import AxistwinError, LinkError, PlacedError, UsageError, one_line, unknown
from axistwin.core.version import VERSION

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem


class Command(NamedTuple):
    """Description of a command of `axistwin`: its name, the folder of its module, and its summary."""

    name: str
    folder: str
    summary: str

    @property
    def module(self) -> str:
        return self.name.replace("-", "_")

    def load(self) -> click.Command:
        loaded: click.Command = getattr(import_module(f"{__package__}.{self.folder}.{self.module}"), self.module)
        return loaded


GROUPS = {
    "Begin": (
        Command("learn", "serving", "Six short lessons for a model, in the terminal."),
        Command("examples", "start", "List the examples, or copy one."),
        Command("new", "start", "Write a new scene, or a device of your own, from a few answers."),
        Command("docs", "start", "Open the pages of the documentation."),
        Command("completion", "start", "Completion of commands, models and files, for shells."),
    ),
    "Run programs and scenes": (
        Command("demo", "runs", "A short session that needs nothing but the package."),
        Command("run", "runs", "Run a program or a conversation at full speed."),
        Command("plot", "runs", "Draw a trace."),
        Command("diff", "runs", "Find the first difference between two traces."),
        Command("fmu", "runs", "Write a scene as an FMU for Simulink, Dymola or OpenModelica."),
    ),
    "Run a scene many times": (
        Command("sweep", "sweeping", "Run a scene with other values; measure, and test claims."),
        Command("tune", "sweeping", "Search for the gains or values that make the worst run best."),
    ),
    "Connect hosts and controllers": (
        Command("serve", "serving", "Put controllers on real ports: TCP, pty, RFC2217, serial, bus."),
        Command("term", "serving", "An interactive terminal on a virtual or a real controller."),
        Command("stand-in", "serving", "Let a legacy host drive real motors through a motion board."),
        Command("boards", "serving", "List the motion boards that are connected."),
        Command("record", "serving", "Record the conversation of a host with a real controller."),
        Command("shadow", "serving", "A twin beside a real controller says what differs while the machine works."),
        Command("probe", "serving", "Compare a real controller with a virtual one, case by case."),
        Command("rescue", "serving", "Save what a real controller contains, and start a twin."),
        Command("replay", "serving", "Compare a virtual controller with a recording of a real one."),
    ),
    "Serve axes to laboratories and plants": (
        Command("ioc", "serving", "Serve axes as motor records of EPICS."),
        Command("opcua", "serving", "Serve axes as an OPC UA address space."),
    ),
    "Write programs and scenes": (
        Command("check", "authoring", "Find errors in programs and scenes."),
        Command("commands", "authoring", "List every command of a model."),
        Command("faults", "authoring", "List every fault that a scene can contain."),
        Command("schema", "authoring", "The JSON Schema of a scene file, for editors."),
        Command("lsp", "authoring", "The language server, for editors."),
    ),
}
"""All commands, by task."""
COMMANDS = {command.name: command for commands in GROUPS.values() for command in commands}

OUTPUT_ERRORS = {errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EBADF}  # Errors of a full or broken output device.
NAME_ERRORS = {errno.ENAMETOOLONG, errno.ELOOP}  # Error numbers for the name of a file that no file can have.


class LazyGroup(click.Group):
    """The commands of `axistwin`; the module of a command is imported only when it is needed."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        return COMMANDS[cmd_name].load() if cmd_name in COMMANDS else None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find a command by its name.  Raises UsageError, which suggests a similar name, for an unknown word."""
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            raise unknown(kind="command", name=args[0], names=COMMANDS)
        return super().resolve_command(ctx, args)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> "list[CompletionItem]":
        """Return the commands that begin with the typed text, without importing the commands."""
        from click.shell_completion import CompletionItem

        found = [command for command in COMMANDS.values() if command.name.startswith(incomplete)]
        options = super(click.Group, self).shell_complete(ctx, incomplete) if incomplete.startswith("-") else []
        return [CompletionItem(command.name, help=command.summary) for command in found] + options

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """Write the help text of all commands, without importing the modules of the commands."""
        width = max(map(len, COMMANDS))
        formatter.write_paragraph()
        formatter.write_heading("Commands")
        for title, commands in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(command.name.ljust(width), command.summary) for command in commands])


def _complete_device(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    from axistwin.cli.common.completing import complete_device

    return complete_device(ctx, param, incomplete)


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--device", "devices", multiple=True, metavar="FILE.py", shell_complete=_complete_device,
              help="Load the devices of a Python file, for this command.")  # fmt: skip
@click.version_option(VERSION, "--version", prog_name="axistwin")
def axistwin(devices: tuple[str, ...]) -> None:
    """Run legacy motion controllers without the hardware.

    \b
    Begin here:
    axistwin demo                      a short session with each family
    axistwin learn if1                 six short lessons in the terminal
    axistwin examples                  machines to copy and change
    axistwin docs                      the documentation, without a network

    \b
    Then:
    axistwin run if1 moves.if1         run command lines at full speed
    axistwin serve if1 --tcp :5001     serve an IF1 to a host program
    """
    for file in devices:
        # Imported here, because only devices of others need it.
        from axistwin.devices.loading import load

        load(file)


def main(arguments: list[str] | None = None) -> None:
    sys.exit(execute(arguments))


def execute(arguments: list[str] | None = None) -> int:
    if sys.stdout is None:  # The program was started without a standard output.
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  # open until the program ends
    _prepare_output()
    as_json = "--json" in (sys.argv[1:] if arguments is None else arguments)
    try:
        result: Any = axistwin.main(arguments, prog_name="axistwin", standalone_mode=False)
        sys.stdout.flush()
    except (click.exceptions.Abort, KeyboardInterrupt):  # The library click raises Abort after Ctrl-C.
        print("axistwin: interrupted", file=sys.stderr)
        return 130
    except click.ClickException as error:
        if isinstance(error, click.NoSuchOption) and error.option_name == "--device":
            return _tell(UsageError("--device is before the command: axistwin --device FILE.py COMMAND …"), as_json)
        if as_json:
            _print_error(error.format_message(), error.exit_code)
        else:
            error.show()
        return error.exit_code
    except BrokenPipeError:  # The program that reads the output has ended, e.g. head in "axistwin models | head".
        _discard_output()
        return 1
    except OSError as error:
        if error.errno in NAME_ERRORS:
            return _tell(
                UsageError(f"{error.filename}: {os.strerror(error.errno).lower()}: choose another name"), as_json
            )
        if error.errno not in OUTPUT_ERRORS or error.filename is not None:
            raise
        _discard_output()
        print(f"axistwin: the output cannot be written: {os.strerror(error.errno).lower()}", file=sys.stderr)
        return 1
    except AxistwinError as error:
        return _tell(error, as_json)
    return result if isinstance(result, int) else 0


def _tell(error: AxistwinError, as_json: bool) -> int:
    code = 2 if isinstance(error, UsageError | LinkError) else 1
    if as_json:
        _print_error(str(error), code, error if isinstance(error, PlacedError) else None)
    else:
        print(f"axistwin: {one_line(str(error))}", file=sys.stderr)
    return code


def _print_error(message: str, code: int, place: PlacedError | None = None) -> None:
    import json

    found: dict[str, object] = {"error": one_line(message), "exit_code": code}
    if place is not None:
        found |= {"error": place.message, "file": place.file, "line": place.line, "column": place.column}
    print(json.dumps(found, ensure_ascii=False), file=sys.stderr)


def _prepare_output() -> None:
    """Set the encoding of stdout and stderr: UTF-8 for a pipe on Windows, else `?` for what it lacks."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper) and stream.encoding.lower() != "utf-8":
            piped = sys.platform == "win32" and not stream.isatty()
            stream.reconfigure(encoding="utf-8" if piped else None, errors="replace")


def _discard_output() -> None:
    """Redirect stdout to the null device after a failed write, because Python writes the rest at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
