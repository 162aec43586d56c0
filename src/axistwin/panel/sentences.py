"""Beginnings of sentences for breakpoints: see `fault_injection/triggers.py`."""

from axistwin.bench import Bench, endpoints


def stems(bench: Bench) -> list[str]:
    """Return the beginnings for every axis, pin, endpoint and controller of the bench."""
    found = []
    for name, controller in bench.controllers.items():
        found += [f"{name}.{axis} passes 0" for axis in controller.axes]
        found += [f"{name}.{pin} {verb}" for pin in controller.pins for verb in ("rises", "falls", "changes")]
        if controller.alarms is not None:
            found += [f"{name} raises {flag}" for flag in controller.alarms.names]
        found += [f"{name} runs 1"] if controller.programs else []
    for name in endpoints.names(bench):
        found += [f"{name} hears ", f"{name} says "]
    return found + [f"{fault} {verb}" for fault in bench.faults.names for verb in ("begins", "ends")]
