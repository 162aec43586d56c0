"""The provenance of a trace, which its file contains: version, scene, models, options and seed.

The provenance does not contain dates, paths or users, so that equal runs produce equal files.
"""

import json

from axistwin.bench import Bench
from axistwin.core.version import VERSION


def provenance(bench: Bench) -> dict[str, str]:
    """Return the provenance as keys and values: version (`axistwin`), `scene`, `title`, `seed`, controllers, lines.

    `units NAME.AXIS`: the unit of an axis, as written by `MachineUnits`.
    """
    found = {"axistwin": VERSION, **bench.origin}
    for name, controller in bench.controllers.items():
        given = json.dumps(controller.given, sort_keys=True, default=str) if controller.given else ""
        units = {axis: each.units for axis, each in controller.axes.items() if each.units is not None}
        found |= {f"units {name}.{axis}": str(unit) for axis, unit in units.items()}
        found[f"controller {name}"] = f"{controller.product.model} {given}".rstrip()
    for name, line in bench.lines.items():
        found[f"line {name}"] = " ".join(motor.name for motor in line.motors)
    return found
