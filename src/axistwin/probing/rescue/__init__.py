"""Read the contents of a controller without motion, and start a twin with the same contents."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.probing.rescue.contents import Contents
    from axistwin.probing.rescue.finding import Found, find
    from axistwin.probing.rescue.saving import Rescue, rescue
else:
    __getattr__ = lazy(__name__, contents="Contents", finding="Found find", saving="Rescue rescue")

__all__ = ["Contents", "Found", "Rescue", "find", "rescue"]
