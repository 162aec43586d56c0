"""The bench, and the names by which its parts are reached, controlled and observed."""

from axistwin.bench.bench import Bench
from axistwin.bench.controller import Controller
from axistwin.bench.line_format import line_format
from axistwin.bench.models import FAMILIES, product

__all__ = ["FAMILIES", "Bench", "Controller", "line_format", "product"]
