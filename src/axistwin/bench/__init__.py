"""The bench, and the names by which its parts are reached, controlled and observed."""

from axistwin.bench.bench import FAMILIES, Bench, Controller, line_format, product

__all__ = ["FAMILIES", "Bench", "Controller", "line_format", "product"]
