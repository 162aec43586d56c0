"""The campaigns of `benchmarks`, of which these tests run small instances."""

import sys
from importlib import import_module
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
try:
    campaign, ports, hosts = (import_module(name) for name in ("shadow", "shadow_ports", "shadow_hosts"))
finally:
    sys.path.pop(0)
