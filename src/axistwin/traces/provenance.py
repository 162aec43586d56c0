"""Provenance of a trace, written into its file: version, scene, models, options and seed.

The provenance does not depend on time, place or user, so equal runs give equal files.
"""

import json

from axistwin.bench import Bench
from axistwin.version import VERSION


def provenance(bench: Bench) -> dict[str, str]:
    """Return the provenance by key: `axistwin`, the bench's origin (`scene`, `seed`), controllers, shared lines."""
    found = {"axistwin": VERSION, **bench.origin}
    for name, controller in bench.controllers.items():
        given = json.dumps(controller.given, sort_keys=True, default=str) if controller.given else ""
        found[f"controller {name}"] = f"{controller.product.model} {given}".rstrip()
    for name, line in bench.lines.items():
        found[f"line {name}"] = " ".join(motor.name for motor in line.motors)
    return found
