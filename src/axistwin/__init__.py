"""axistwin runs legacy motion controllers without the hardware, in deterministic virtual time.

from axistwin import Bench

bench = Bench()
if1 = bench.add("if1")
bench.run(1.5)                       # it has just been switched on
if1.serial.write(b"(")
bench.run(0.1)
assert if1.serial.read() == b"U\\r"
"""

from axistwin.bench import Bench
from axistwin.errors import AxistwinError

__all__ = ["AxistwinError", "Bench", "Scene"]
__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    if name == "Scene":  # brings pydantic along, so only for those who ask
        from axistwin.apps.scene import Scene

        return Scene
    raise AttributeError(f"module 'axistwin' has no attribute {name!r}")
