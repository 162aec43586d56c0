"""Completion of values in shells: models, scenes, programs, traces, pages and examples."""

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from axistwin.controllers.registry import names

if TYPE_CHECKING:
    import ast

SCENES = (".toml",)
PROGRAMS = (".if1", ".181x", ".sms", ".talk")
TRACES = (".csv", ".vcd", ".parquet")
MOST_DEEP, MOST_SEEN = 3, 2000  # Limits of a search for files: depth below the typed folder, and number of files.

Complete = Callable[[click.Context, click.Parameter, str], list[str]]


def _of(suffixes: tuple[str, ...] = (), *, models: bool = False) -> Complete:
    def complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:  # noqa: ARG001
        named = dict.fromkeys((*names(), *_in_files(ctx.find_root().params.get("devices") or ()))) if models else ()
        found = [name for name in named if name.startswith(incomplete.lower())]
        return found + (sorted(_files(incomplete, suffixes)) if suffixes else [])

    return complete


complete_model = _of(models=True)
complete_target = _of(SCENES, models=True)
complete_program = _of(PROGRAMS)
complete_checked = _of((*PROGRAMS, *SCENES), models=True)
complete_trace = _of(TRACES)
complete_device = _of((".py",))


def complete_example(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:  # noqa: ARG001
    from axistwin.ui.guide.shipped import examples

    return [name for name in examples() if name.startswith(incomplete)]


def complete_page(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:  # noqa: ARG001
    from axistwin.ui.guide import pages

    return [name for name in pages.names() if name.startswith(incomplete)]


def _in_files(files: Iterable[str]) -> Iterator[str]:
    """Yield the models that the classes of Python files name, without running them."""
    for file in files:
        import ast

        with suppress(OSError, ValueError, SyntaxError, RecursionError):
            for kind in ast.parse(Path(file).read_bytes()).body:
                for line in kind.body if isinstance(kind, ast.ClassDef) else ():
                    if isinstance(line, ast.Assign):
                        yield from _models(line.targets[0], line.value)
                    elif isinstance(line, ast.AnnAssign) and line.value is not None:
                        yield from _models(line.target, line.value)


def _models(target: "ast.expr", value: "ast.expr") -> Iterator[str]:
    import ast

    match target, value:
        case ast.Name("model"), ast.Constant(str(name)):
            yield name
        case ast.Tuple(targets), ast.Tuple(values):
            for each, assigned in zip(targets, values, strict=False):
                yield from _models(each, assigned)


def _files(incomplete: str, suffixes: tuple[str, ...]) -> Iterator[str]:
    folder, _, begin = incomplete.rpartition("/" if "/" in incomplete else os.sep)
    above = incomplete[: len(incomplete) - len(begin)]
    seen = 0
    root = Path(folder or above or ".")
    for place, folders, files in os.walk(root):
        inside = Path(place).relative_to(root)
        deep = len(inside.parts)
        folders[:] = [name for name in sorted(folders) if name[0] not in "._" and (deep or name.startswith(begin))]
        if deep >= MOST_DEEP or seen > MOST_SEEN:
            folders.clear()
        seen += len(files)
        for name in files:
            if name.lower().endswith(suffixes) and (deep or name.startswith(begin)):
                yield above + (inside / name).as_posix()
