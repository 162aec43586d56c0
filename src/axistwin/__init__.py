"""axistwin runs legacy motion controllers without the hardware, in deterministic virtual time.

from axistwin import Bench

bench = Bench()
if1 = bench.add("if1")
bench.run(1.5)                       # it has just been switched on
if1.serial.write(b"(")
bench.run(0.1)
assert if1.serial.read() == b"U\\r"
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from axistwin.version import VERSION

if TYPE_CHECKING:
    from axistwin.bench import Bench
    from axistwin.errors import AxistwinError
    from axistwin.fault_injection.injector import Fault
    from axistwin.scenes.scene import Scene
    from axistwin.testing.twin import serve

__all__ = ["AxistwinError", "Bench", "Fault", "Scene", "serve"]
__version__ = VERSION

_HOMES = {
    "AxistwinError": "axistwin.errors",
    "Bench": "axistwin.bench",
    "Fault": "axistwin.fault_injection.injector",
    "Scene": "axistwin.scenes.scene",
    "serve": "axistwin.testing.twin",
}
"""Where each name lives; imported when it is asked for: a pytest plug-in must cost nothing to who does not use it."""


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'axistwin' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
