"""Compare real controllers with virtual ones."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.probing.comparing import Motion, Probe, Result, Settings, Twin, Verdict, probe
    from axistwin.probing.ends import Answer, End, VirtualEnd, open_end
    from axistwin.probing.report import html
else:
    __getattr__ = lazy(
        __name__,
        ends="Answer End VirtualEnd open_end",
        comparing="Motion Probe Result Settings Twin Verdict probe",
        report="html",
    )

__all__ = [
    "Answer", "End", "Motion", "Probe", "Result", "Settings", "Twin", "Verdict", "VirtualEnd", "html", "open_end",
    "probe",
]  # fmt: skip
