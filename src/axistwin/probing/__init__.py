"""Compare real controllers with virtual ones."""

from typing import TYPE_CHECKING

from axistwin.hosts.end import Answer, End
from axistwin.hosts.real_time import open_end
from axistwin.hosts.virtual_time import VirtualEnd
from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.probing.cases import dialect
    from axistwin.probing.comparing import Motion, Probe, Result, Settings, Twin, Verdict, other_values, probe
    from axistwin.probing.report import html
else:
    __getattr__ = lazy(
        __name__,
        cases="dialect",
        comparing="Motion Probe Result Settings Twin Verdict other_values probe",
        report="html",
    )

__all__ = [
    "Answer", "End", "Motion", "Probe", "Result", "Settings", "Twin", "Verdict", "VirtualEnd", "dialect", "html",
    "open_end", "other_values", "probe",
]  # fmt: skip
