"""`axistwin check`: diagnostics of programs and scenes, with line, column and the manual's chapter."""

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

import click

from axistwin.bench import is_model, product
from axistwin.cli.common.completing import complete_checked
from axistwin.cli.common.working import working
from axistwin.controllers.diagnostics import Diagnostic, Severity
from axistwin.controllers.product import Product
from axistwin.core.errors import PlacedError, ProgramError, UsageError
from axistwin.core.storage import STANDARD_INPUT
from axistwin.scenes.diagnostics import codes
from axistwin.scenes.diagnostics import fix as check_fix
from axistwin.scenes.diagnostics.checking import (
    SCENE,
    as_diagnostic,
    check_kind,
    diagnose,
    diagnose_named,
    diagnose_text,
    kind_of,
    load,
    product_for,
)
from axistwin.scenes.diagnostics.formats import Checked, as_github, as_json, as_sarif, as_text

__all__ = ["check", "diagnose"]

FORMATS = ("text", "json", "sarif", "github")


@click.command()
@click.argument("arguments", nargs=-1, metavar="[MODEL] FILE...", shell_complete=complete_checked)
@click.option("--format", "form", type=click.Choice(FORMATS), default="text", help="Output format; text if left out.")
@click.option("--json", "as_json_", is_flag=True, help="The same as --format json.")
@click.option("--fix", is_flag=True, help="Apply every fix that is unambiguous; FILE.bak keeps the old program.")
@click.option("--diff", is_flag=True, help="Show what --fix would change, and write nothing.")
@click.option("--strict", is_flag=True, help="Count warnings as errors.")
@click.option("--codes", "code", is_flag=False, flag_value="", metavar="[CODE]", help="Explain one code, or all codes.")
def check(
    arguments: tuple[str, ...], form: str, as_json_: bool, fix: bool, diff: bool, strict: bool, code: str | None
) -> int:
    """Find errors and probable mistakes in programs and scenes, without running the programs.

    A FILE is a conversation (.talk; the host's lines are checked), IF1/IF2 command lines as typed at a terminal (.if1),
    commands for an 1810 or 1811 in hex or by name (.181x), a SmartMotor's source (.sms), or a scene or a sweep
    (.toml).  With a MODEL the file may have any other name, and `-` is the standard input.  MODEL may be left out if
    the file gives the model: a conversation by `; model: if1`, other files by their suffix (.if1 is checked for an IF1,
    .181x for an 1811).  With a scene, all programs, hosts and conversations that the scene names are checked.  One line
    is printed for each diagnostic:

    \b
      moves.if1:3:5: error: unknown character 'x': … (manual: Full command list) [DP101]
      bench.toml → moves.if1:3:5: error: …

    The controller refuses an error.  It executes or ignores a warning, but probably not as intended.  All codes are in
    docs/diagnostics.md.

    Exit code 0: no errors.  1: errors, or with --strict warnings.  2: wrong usage.

    \b
    Examples:
      axistwin check if1 moves.if1
      axistwin check if2 tests/*.talk --format github
      axistwin check home.sms --diff
      axistwin check home.sms --fix
      axistwin check bench.toml
      axistwin check --codes DP301
    """
    form = "json" if as_json_ else form
    if code is not None:
        _explain(code, form)
        return 0
    made, files = _targets(arguments)
    if fix and not diff and any(file is STANDARD_INPUT for file in files):
        raise UsageError("the standard input cannot be fixed: expected a file, or --diff instead of --fix")
    with working(f"checking {len(files)} file{'s' * (len(files) != 1)}"):
        look = _look(fix, diff, quiet=form != "text")
        checked = [one for file in files for one in _check(file, made, look)]
    _print(checked, made, form)
    worst = [each for one in checked for each in one.found if strict or each.severity is Severity.ERROR]
    return 1 if worst else 0


def _targets(arguments: Sequence[str]) -> tuple[Product | None, list[Path]]:
    first = arguments[0] if arguments else ""
    named = is_model(first) or not (Path(first).suffix or first == "-")
    made = product(first) if arguments and named else None
    files = [STANDARD_INPUT if argument == "-" else Path(argument) for argument in arguments[named:]]
    if not files:
        raise UsageError("nothing to check: expected a program or a scene, e.g. axistwin check if1 moves.if1")
    if made is not None and made.check is None:
        raise UsageError(f"programs for {made.model} cannot be checked: expected a model with a checker, e.g. if1")
    return made, files


Look = Callable[[Path, str, Callable[[str], list[Diagnostic]]], tuple[str, list[Diagnostic]]]
"""Checks the text of a file, perhaps fixes it, and returns the text and what is wrong in it."""


def _look(fix: bool, diff: bool, quiet: bool) -> Look:
    if diff:
        return partial(_shown, quiet=quiet)
    return partial(_fixed, quiet=quiet) if fix else lambda file, text, diagnose_it: (text, diagnose_it(text))


def _check(file: Path, made: Product | None, look: Look) -> Iterator[Checked]:
    kind = kind_of(file, made)
    if kind == SCENE:
        # Import `sweep_file` only for a .toml file, because the import is slow.
        from axistwin.sweeps.sweep_file import is_sweep_file

        yield from [_check_sweep(file)] if is_sweep_file(file) else _check_scene(file, look)
        return
    try:
        text = load(file, made)
    except ProgramError as error:  # The checked file is not a text file.
        yield Checked(file, "", [as_diagnostic(error)])
        return
    target = made or product_for(kind, text)
    check_kind(file, target)
    diagnose_it = partial(diagnose_text, suffix=kind, made=target, file=str(file))
    yield Checked(file, *look(file, text, diagnose_it), target.model)


def _check_sweep(file: Path) -> Checked:
    from axistwin.scenes.source import read_text
    from axistwin.sweeps import sweep_file

    text = read_text(file)
    try:
        sweep_file.check(file)
    except PlacedError as error:
        return Checked(file, text, [as_diagnostic(error)])
    return Checked(file, text, [])


def _check_scene(scene: Path, look: Look) -> Iterator[Checked]:
    # Only the check of a scene imports these modules, because these modules load slowly.
    from axistwin.scenes.diagnostics.scenes import diagnose_scene, is_of_program, named_programs
    from axistwin.scenes.source import read_text

    named = []
    for endpoint, file, models in named_programs(scene):
        try:
            text = load(file)
        except ProgramError:  # `diagnose_scene` reports each program file that is unreadable.
            continue
        diagnose_it = partial(diagnose_named, suffix=kind_of(file), endpoint=endpoint, models=models, file=str(file))
        model = models[endpoint].model if endpoint in models else ""
        named.append(Checked(file, *look(file, text, diagnose_it), model, scene))
    found = diagnose_scene(scene)
    own = [each for each in found if not any(one.found and is_of_program(each, one.file) for one in named)]
    yield Checked(scene, read_text(scene), own)
    yield from named


def _fixed(
    file: Path, text: str, diagnose_it: Callable[[str], list[Diagnostic]], quiet: bool
) -> tuple[str, list[Diagnostic]]:
    """Apply all unambiguous fixes to a file, and keep its old contents beside it."""
    exact, rest, encoding = check_fix.read_exactly(file)
    better, done = _better(exact, text, diagnose_it)
    if not done:
        return text, diagnose_it(text)
    backup = check_fix.replace(file, better, rest, encoding)
    for each in done:
        assert each.fix is not None
        click.echo(f"{file}:{each.line}:{each.column}: fixed {each.code}: {each.fix.title}", err=quiet)
    kept = backup if file.is_symlink() else file.with_name(backup.name)
    click.echo(f"{file}: the old program is in {kept}", err=quiet)
    text = load(file)
    return text, diagnose_it(text)


def _shown(
    file: Path, text: str, diagnose_it: Callable[[str], list[Diagnostic]], quiet: bool
) -> tuple[str, list[Diagnostic]]:
    exact, _, _ = check_fix.read_exactly(file)
    for line in check_fix.difference(file, exact, _better(exact, text, diagnose_it)[0]):
        click.echo(line, err=quiet)
    return text, diagnose_it(text)


def _better(exact: str, text: str, diagnose_it: Callable[[str], list[Diagnostic]]) -> tuple[str, Sequence[Diagnostic]]:
    """Fix a text, but only if it means the same as the text that is checked, whose line ends are different."""
    if diagnose_it(exact) != diagnose_it(text):
        return exact, []
    return check_fix.fix_text(exact, diagnose_it)[:2]


def _print(checked: Sequence[Checked], made: Product | None, form: str) -> None:
    if form in ("json", "sarif"):
        model = made.model if made is not None else checked[0].model or None
        click.echo(as_sarif(checked) if form == "sarif" else as_json(checked, model))
        return
    for each in checked:
        for line in as_github(each) if form == "github" else as_text(each, excerpts=sys.stdout.isatty()):
            click.echo(line)
    given = [each.file for each in checked if each.scene is None]
    name = str(given[0]) if len(given) == 1 else f"{len(given)} files"
    click.echo(f"axistwin: {name}: {_summary([found for each in checked for found in each.found])}", err=True)


def _summary(found: Iterable[Diagnostic]) -> str:
    listed = list(found)
    errors = sum(each.severity is Severity.ERROR for each in listed)
    counts = [(errors, "error"), (len(listed) - errors, "warning")]
    told = [f"{count} {noun}{'s' * (count != 1)}" for count, noun in counts if count]
    sure = sum(each.fix is not None and each.fix.sure for each in listed)
    note = f" ({sure} can be fixed by --fix)" if sure else ""
    return (", ".join(told) or "nothing wrong") + note


def _explain(code: str, form: str) -> None:
    if form not in ("text", "json"):
        raise UsageError(f"invalid --format {form} for --codes: expected text or json")
    found = codes.select(code)
    if form == "json":
        click.echo(json.dumps([codes.as_dict(rule) for rule in found], ensure_ascii=False))
        return
    for rule in found:
        for line in codes.explained(rule):
            click.echo(line)
