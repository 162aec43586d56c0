"""The bench, and the names by which what stands on it is reached, acted on and observed."""

from axistwin.bench.bench import FAMILIES, Bench, Controller, line_format, product

__all__ = ["FAMILIES", "Bench", "Controller", "line_format", "product"]
