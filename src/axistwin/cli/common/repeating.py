"""Command lines in messages, which a user can repeat as they stand."""

import os
import shlex
from pathlib import Path

import click


def program(folder: Path | None = None) -> str:
    """Return the beginning of a command line in `folder`, or here, with the same devices: `axistwin --device a.py`."""
    context = click.get_current_context(silent=True)
    files = context.find_root().params.get("devices") or () if context is not None else ()
    paths = files if folder is None else [os.path.relpath(file, folder) for file in files]
    return " ".join(("axistwin", *(f"--device {shlex.quote(path)}" for path in paths)))
