"""Checks of a program before a user loads it into a controller."""

import re
from collections.abc import Mapping
from pathlib import Path

from axistwin.bench import Bench
from axistwin.controllers.diagnostics import Severity
from axistwin.core.errors import ProgramError, UsageError
from axistwin.scenes.diagnostics.checking import check_kind, diagnose_text
from axistwin.scenes.hosting import SENT, STORED

OFF_S = 0.1  # Time for which a controller is switched off before a load; its serial lines become idle in this time.


def checked(bench: Bench, name: str, filename: str, text: str, known: Mapping[str, str]) -> str:
    """Check a program, and return the name under which the program will be stored.

    The name is the file name, or a numbered name if the file name is in use.  Raises ProgramError with file, line and
    column; UsageError.
    """
    file, controller = Path(filename), bench[name]
    if file.suffix.lower() not in (STORED, *SENT):
        raise UsageError(f"cannot load {filename}: expected SmartMotor source (.sms) or command lines (.if1, .181x)")
    check_kind(file, controller.product)
    if controller.product.attend is None and name not in bench.ports:
        raise UsageError(
            f"cannot load a program into {name}, because {name} has no serial line of its own: "
            "select a controller with its own serial line"
        )
    for found in diagnose_text(text, file.suffix.lower(), controller.product, filename):
        if found.severity is Severity.ERROR:
            raise ProgramError(
                message=found.message, file=filename, line=found.line, column=found.column, code=found.code
            )
    return _free(file.name, text, known)


def _free(name: str, text: str, known: Mapping[str, str]) -> str:
    path = Path(re.sub(r"[^\w.-]", "_", name))
    names = (path.name if n == 1 else f"{path.stem}-{n}{path.suffix}" for n in range(1, len(known) + 2))
    return next(each for each in names if known.get(each, text) == text)
