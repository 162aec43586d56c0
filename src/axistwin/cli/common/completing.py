"""Completion of values in shells: models, scenes, programs, traces, pages and examples."""

import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import click

MODELS = ("if1", "if2", "1810", "1811", "smartmotor")
SCENES = (".toml",)
PROGRAMS = (".if1", ".181x", ".sms", ".talk")
TRACES = (".csv", ".vcd", ".parquet")
MOST_DEEP, MOST_SEEN = 3, 2000  # Limits of a search for files: depth below the typed folder, and number of files.

Complete = Callable[[click.Context, click.Parameter, str], list[str]]


def _of(names: Iterable[str], suffixes: tuple[str, ...] = ()) -> Complete:
    def complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:  # noqa: ARG001
        found = [name for name in names if name.startswith(incomplete.lower())]
        return found + (sorted(_files(incomplete, suffixes)) if suffixes else [])

    return complete


complete_model = _of(MODELS)
complete_target = _of(MODELS, SCENES)
complete_program = _of((), PROGRAMS)
complete_checked = _of(MODELS, (*PROGRAMS, *SCENES))
complete_trace = _of((), TRACES)


def complete_example(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:  # noqa: ARG001
    from axistwin.ui.guide.shipped import examples

    return [name for name in examples() if name.startswith(incomplete)]


def complete_page(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:  # noqa: ARG001
    from axistwin.ui.guide.pages import names

    return [name for name in names() if name.startswith(incomplete)]


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
