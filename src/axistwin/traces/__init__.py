"""Record the changes of signals on a bench to a file (a trace); read and compare traces."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.traces.differences import Tolerance, compare
    from axistwin.traces.files import VcdSink
    from axistwin.traces.memory import tracing_in_memory
    from axistwin.traces.reading import Trace, Track, read
    from axistwin.traces.signals import COUNT, EVERYTHING, LEVEL, TEXT, catalogue, choose
    from axistwin.traces.trace import tracing
else:
    __getattr__ = lazy(
        __name__,
        differences="Tolerance compare",
        files="VcdSink",
        memory="tracing_in_memory",
        reading="Trace Track read",
        signals="COUNT EVERYTHING LEVEL TEXT catalogue choose",
        trace="tracing",
    )

__all__ = [
    "COUNT", "EVERYTHING", "LEVEL", "TEXT", "Tolerance", "Trace", "Track", "VcdSink", "catalogue", "choose",
    "compare", "read", "tracing", "tracing_in_memory",
]  # fmt: skip
