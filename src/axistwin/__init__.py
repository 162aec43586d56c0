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

from axistwin.lazy import lazy
from axistwin.version import VERSION

if TYPE_CHECKING:
    from axistwin.bench import Bench
    from axistwin.conversations.player import play
    from axistwin.conversations.recorder import recording
    from axistwin.errors import AxistwinError
    from axistwin.fault_injection.injector import Fault
    from axistwin.scenes.scene import Scene
    from axistwin.sessions.session import Session
    from axistwin.testing.twin import serve
    from axistwin.traces.trace import tracing
else:  # Load each module at its first use, so that `import axistwin` is fast.
    __getattr__ = lazy(
        __name__,
        **{
            "bench": "Bench",
            "conversations.player": "play",
            "conversations.recorder": "recording",
            "errors": "AxistwinError",
            "fault_injection.injector": "Fault",
            "scenes.scene": "Scene",
            "sessions.session": "Session",
            "testing.twin": "serve",
            "traces.trace": "tracing",
        },
    )

__all__ = ["AxistwinError", "Bench", "Fault", "Scene", "Session", "play", "recording", "serve", "tracing"]
__version__ = VERSION
