"""Reports of `axistwin probe --report FILE.json` on real controllers: what has been seen on real hardware.

A report is a JSON file in `docs/hardware`.  Only cases with the verdict *same* count.
"""

import json
import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from axistwin.bench import product

CODE = re.compile(r"[^\s:,]+")
"""The command at the beginning of the name of a case."""


@dataclass
class Hardware:
    """Number of cases in which a real controller and its twin were the same."""

    reports: int = 0
    sections: Counter[tuple[str, str]] = field(default_factory=Counter)
    """By family and section of the manual."""
    commands: Counter[tuple[str, str]] = field(default_factory=Counter)
    """By family and code of the command."""


def seen(directory: Path) -> Hardware:
    """Return what the reports in the directory contain.  Ends the program if a file is no report of a probe."""
    found = Hardware()
    for file in sorted(directory.glob("*.json")):
        try:
            _add(found, json.loads(file.read_text(encoding="utf-8")))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise SystemExit(
                f"{file} is no report of a probe ({error!r}): write it by axistwin probe PORT --report {file.name}"
            ) from None
        found.reports += 1
    return found


def _add(found: Hardware, report: dict) -> None:  # type: ignore[type-arg]
    family = product(report["model"]).family
    for section, number in report["seen_on_real_hardware"].items():
        found.sections[family, section] += int(number)
    for result in report["results"]:
        code = CODE.match(result["name"])
        if result["verdict"] == "same" and code:
            found.commands[family, code[0]] += 1
