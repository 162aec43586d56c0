"""Parameter types of the commands."""

from pathlib import Path
from typing import Any

import click

from axistwin.numbers import NumberError, real

FILE = click.Path(dir_okay=False, path_type=Path)
"""A file."""
MOST_S = 1e9
"""Longest accepted time in seconds, about thirty years; a longer time is refused as a typing error."""


class Number(click.FloatRange):
    """A finite number within limits.  Unlike the base class, this type refuses nan and numbers of thousands of
    digits.
    """

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the text as a number."""
        try:
            number = real(value) if isinstance(value, str) else value
        except NumberError as error:
            self.fail(f"{error}.", param, ctx)
        found: float = super().convert(number, param, ctx)
        return found


class Seconds(Number):
    """A number of seconds, from 0 to `MOST_S`."""

    def __init__(self) -> None:
        super().__init__(min=0, max=MOST_S)
