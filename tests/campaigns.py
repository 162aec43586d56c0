"""The scripts in `benchmarks/robustness`, of which tests run small instances."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

ROBUSTNESS = Path(__file__).parents[1] / "benchmarks" / "robustness"


def campaign(name: str) -> ModuleType:
    """Import a script, not another module of the same name."""
    spec = spec_from_file_location(f"robustness_{name}", ROBUSTNESS / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look up a module
    spec.loader.exec_module(module)
    return module
