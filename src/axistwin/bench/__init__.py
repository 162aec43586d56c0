"""The bench, with functions to control and observe its parts by name."""

from typing import TYPE_CHECKING

from axistwin.bench.line_format import line_format
from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.bench.acts import Comment, Do, Expect, Hear, Say, Wait
    from axistwin.bench.bench import Bench
    from axistwin.bench.codec import CHARACTERS
    from axistwin.bench.control_characters import show_controls
    from axistwin.bench.controller import Controller
    from axistwin.bench.models import FAMILIES, product
else:  # lazy import: a server needs only some of these modules
    __getattr__ = lazy(
        __name__,
        acts="Comment Do Expect Hear Say Wait",
        bench="Bench",
        codec="CHARACTERS",
        control_characters="show_controls",
        controller="Controller",
        models="FAMILIES product",
    )

__all__ = [
    "CHARACTERS", "FAMILIES", "Bench", "Comment", "Controller", "Do", "Expect", "Hear", "Say", "Wait", "line_format",
    "product", "show_controls",
]  # fmt: skip
