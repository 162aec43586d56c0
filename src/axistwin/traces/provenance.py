"""What a trace is of, written into it: what made it, from which scene, with which models, options and seed.

Nothing in it depends on when, where or by whom a bench was run, so that the same run gives the same file.
"""

import json
from collections.abc import Mapping
from typing import Any

from axistwin.bench import Bench
from axistwin.version import VERSION


def provenance(bench: Bench) -> dict[str, str]:
    """By key, in order: `axistwin`, what the bench says of its origin (`scene`, `seed`), one for each controller."""
    found = {"axistwin": VERSION, **bench.origin}
    for name, controller in bench.controllers.items():
        found[f"controller {name}"] = " ".join((controller.product.model, *_options(controller.given)))
    for name, line in bench.lines.items():
        found[f"line {name}"] = " ".join(motor.name for motor in line.motors)
    return found


def _options(given: Mapping[str, Any]) -> tuple[str, ...]:
    return (json.dumps(given, sort_keys=True, default=str),) if given else ()
