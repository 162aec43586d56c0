"""The chapters of the IF1/IF2 manual, one module each."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.digiplan.chapters.data_format import BAUD_RATES, read_format
    from axistwin.controllers.digiplan.chapters.terminals import CABLES, TERMINALS
else:
    __getattr__ = lazy(__name__, data_format="BAUD_RATES read_format", terminals="CABLES TERMINALS")

__all__ = ["BAUD_RATES", "CABLES", "TERMINALS", "read_format"]
