"""Drawings of machines with moving parts, and listings with marked lines.

A drawing is sent to the browser once.  After that, one message per frame contains the changes.
"""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.panel.drawings.picture import Picture
else:
    __getattr__ = lazy(
        __name__,
        picture="Picture",
    )

__all__ = ["Picture"]
