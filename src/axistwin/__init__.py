"""axistwin runs legacy motion controllers without the hardware, in deterministic virtual time.

from axistwin import Bench

bench = Bench()
if1 = bench.add("if1")
bench.run(1.5)                       # the controller has just been switched on
if1.serial.write(b"(")
bench.run(0.1)
assert if1.serial.read() == b"U\\r"
"""

from typing import TYPE_CHECKING

from axistwin.core.lazy import lazy
from axistwin.core.version import VERSION

if TYPE_CHECKING:
    from axistwin.bench import Bench
    from axistwin.bench.faults.injector import Fault
    from axistwin.bench.talk.player import play
    from axistwin.bench.talk.recorder import recording
    from axistwin.core.errors import AxistwinError
    from axistwin.records.traces.trace import tracing
    from axistwin.scenes.scene import Scene
    from axistwin.scenes.sessions.session import Session
    from axistwin.testing.twin import serve
else:  # Load each module at its first use, so that `import axistwin` is fast.
    __getattr__ = lazy(
        __name__,
        **{
            "bench": "Bench",
            "bench.faults.injector": "Fault",
            "bench.talk.player": "play",
            "bench.talk.recorder": "recording",
            "core.errors": "AxistwinError",
            "records.traces.trace": "tracing",
            "scenes.scene": "Scene",
            "scenes.sessions.session": "Session",
            "testing.twin": "serve",
        },
    )

__all__ = ["AxistwinError", "Bench", "Fault", "Scene", "Session", "play", "recording", "serve", "tracing"]
__version__ = VERSION
