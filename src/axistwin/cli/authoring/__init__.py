"""Commands for authors of programs and scenes: errors, listings, editors."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.cli.authoring.check import diagnose
    from axistwin.cli.authoring.faults import rows
else:
    __getattr__ = lazy(
        __name__,
        check="diagnose",
        faults="rows",
    )

__all__ = ["diagnose", "rows"]
