"""Compare real controllers with virtual ones."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.probing.cases import dialect
    from axistwin.probing.comparing import Motion, Probe, Result, Settings, Twin, Verdict, other_values, probe
    from axistwin.probing.ends import Answer, End, VirtualEnd, open_end
    from axistwin.probing.report import html
else:
    __getattr__ = lazy(
        __name__,
        cases="dialect",
        comparing="Motion Probe Result Settings Twin Verdict other_values probe",
        ends="Answer End VirtualEnd open_end",
        report="html",
    )

__all__ = [
    "Answer", "End", "Motion", "Probe", "Result", "Settings", "Twin", "Verdict", "VirtualEnd", "dialect", "html",
    "open_end", "other_values", "probe",
]  # fmt: skip
