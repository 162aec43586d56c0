"""The bench, with functions to control and observe its parts by name."""

from typing import TYPE_CHECKING

from axistwin.core.lazy import lazy
from axistwin.sim.line_format import line_format

if TYPE_CHECKING:
    from axistwin.bench.actions import action
    from axistwin.bench.acts import Comment, Do, Expect, Hear, Say, Wait
    from axistwin.bench.bench import Bench
    from axistwin.bench.codec import CHARACTERS, codec_of, show_controls
    from axistwin.bench.controller import Controller
    from axistwin.bench.events import LineBreak, Sent, terminals
    from axistwin.bench.hosts import host_at, host_of
    from axistwin.bench.models import is_model, product
    from axistwin.bench.options import read_options
else:
    __getattr__ = lazy(
        __name__, actions="action", acts="Comment Do Expect Hear Say Wait", bench="Bench",
        codec="CHARACTERS codec_of show_controls", controller="Controller", events="LineBreak Sent terminals",
        hosts="host_at host_of", models="is_model product", options="read_options",
    )  # fmt: skip

__all__ = [
    "CHARACTERS", "Bench", "Comment", "Controller", "Do", "Expect", "Hear", "LineBreak", "Say", "Sent", "Wait",
    "action", "codec_of", "host_at", "host_of", "is_model", "line_format", "product", "read_options",
    "show_controls", "terminals",
]  # fmt: skip
