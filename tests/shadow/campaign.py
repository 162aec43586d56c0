"""The campaign `benchmarks/shadow.py`, of which these tests run small instances."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

PATH = Path(__file__).parents[2] / "benchmarks" / "shadow.py"


def _load():
    spec = spec_from_file_location("shadow_campaign", PATH)
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look up a module
    spec.loader.exec_module(module)
    return module


campaign = _load()
