"""`axistwin probe`: compare a real controller with a twin."""

import json
import sys
from pathlib import Path

import click

from axistwin.bench import line_format, product
from axistwin.cli.common.completing import complete_model
from axistwin.cli.common.parameters import FILE
from axistwin.core.storage import write_file
from axistwin.real.hosts.real_time import open_end
from axistwin.real.probing.cases import dialect
from axistwin.real.probing.comparing import Motion, Probe, Settings, Verdict
from axistwin.real.probing.comparing import probe as compare
from axistwin.real.probing.report import html


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("port")
@click.option("--model", required=True, metavar="MODEL", shell_complete=complete_model, help="Model of the controller.")
@click.option("--motion", type=click.Choice([str(motion) for motion in Motion]), default="none", show_default=True,
              help="none: nothing moves and no output switches. small: short moves, and outputs.")  # fmt: skip
@click.option("--memory", is_flag=True,
              help="Programs and data are written to the memory of a SmartMotor, and restored.")  # fmt: skip
@click.option("--plug", is_flag=True, help="A test plug connects outputs to inputs; see the page on probes.")
@click.option("--as-new", is_flag=True, help="The controller has just been switched on, without wiring of a machine: "
              "positions, inputs and gains are compared too.")  # fmt: skip
@click.option("--line", metavar="FORMAT",
              help="Line format of the controller, e.g. '9600 8N2'; default: its usual format.")  # fmt: skip
@click.option("--report", type=FILE, metavar="FILE", help="Write a report, as HTML or JSON by its suffix.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
def probe(
    port: str, model: str, motion: str, memory: bool, plug: bool, as_new: bool, line: str | None, report: Path | None,
    as_json: bool,
) -> int:  # fmt: skip
    """Compare the real controller at PORT with its virtual twin, in 150 to 300 test cases.

    PORT is a serial device, tcp://HOST:PORT, rfc2217://HOST:PORT, bus://HOST:PORT or a URL of pyserial.  The verdict
    of each case is same, differs or inconclusive; the exit code is 1 if a case differs.

    A probe changes settings such as speeds and variables.  Save them first with `axistwin rescue`, and switch the
    controller off and on after the probe.  A controller that is moving is refused; one that is busy or has a program
    is only read.

    \b
    axistwin probe /dev/ttyUSB0 --model if1
    axistwin probe tcp://terminalserver:4001 --model smartmotor --line "9600 8N1" --report motor.html
    axistwin probe bus://127.0.0.1:1811 --model 1811 --motion small
    """
    made = product(model)
    dialect(made)  # Raises UsageError before the port is opened.
    fmt = None if made.line is None else line_format(line, made.line)[0]
    if report is not None and report.suffix not in (".html", ".json"):
        raise click.UsageError(f"invalid file name {report.name!r}: expected a name that ends in .html or .json")
    end = open_end(port, fmt)
    try:
        settings = Settings(Motion(motion), as_new, fmt, report=_progress, memory=memory, plug=plug)
        found = compare(model, end, settings)
    finally:
        end.close()
        _progress(0, 0)
    if report is not None:
        write_file(report, html(found) if report.suffix == ".html" else _json(found))
    if as_json:
        click.echo(_json(found), nl=False)
    else:
        _print(found)
    return 1 if found.of(Verdict.DIFFERS) or found.not_restored else 0


def _json(found: Probe) -> str:
    return json.dumps(found.as_dict(), indent=1, ensure_ascii=False) + "\n"


def _progress(done: int, total: int) -> None:
    if sys.stderr.isatty():
        click.echo(f"\r{done}/{total} cases" if total else "\r\x1b[K", nl=False, err=True)


def _print(found: Probe) -> None:
    for name, text in found.condition.facts.items():
        click.echo(f"{name}: {repr(text)[1:-1]}")
    for result in found.of(Verdict.DIFFERS):
        click.echo(f"differs: {result.case.name} ({result.case.section}): {result.reason}")
        for said, twin, real in zip(result.case.says, result.expected, result.received, strict=True):
            if twin.data != real.data:
                click.echo(f"  sent {said!r}: the twin answers {twin.data!r}, the controller {real.data!r}")
    reasons = [result.reason for result in found.of(Verdict.INCONCLUSIVE)]
    for reason in dict.fromkeys(reasons):
        click.echo(f"inconclusive: {reasons.count(reason)} cases: {reason}")
    if found.not_restored:
        click.echo(f"not restored: {found.not_restored}")
    for text in found.fits:
        click.echo(f"fits option {text}")
    if not found.times_judged:
        click.echo("times are not compared: the port does not keep real time")
    click.echo(", ".join(f"{len(found.of(verdict))} {verdict}" for verdict in Verdict))
