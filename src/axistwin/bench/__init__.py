"""The bench, with functions to control and observe its parts by name."""

from axistwin.bench.acts import Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.bench import Bench
from axistwin.bench.codec import CHARACTERS
from axistwin.bench.control_characters import show_controls
from axistwin.bench.controller import Controller
from axistwin.bench.line_format import line_format
from axistwin.bench.models import FAMILIES, product

__all__ = [
    "CHARACTERS", "FAMILIES", "Bench", "Comment", "Controller", "Do", "Expect", "Hear", "Say", "Wait", "line_format",
    "product", "show_controls",
]  # fmt: skip
