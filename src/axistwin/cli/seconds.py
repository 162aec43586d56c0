"""A number on the command line, such as a number of seconds."""

from typing import Any

import click

from axistwin.numbers import NumberError, real

MOST_S = 1e9
"""Some thirty years; more is a slip of the pen."""


class Number(click.FloatRange):
    """A finite number within limits; unlike its base it takes neither nan nor thousands of digits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """What has been written, as a number."""
        try:
            number = real(value) if isinstance(value, str) else value
        except NumberError as error:
            self.fail(f"{error}.", param, ctx)
        found: float = super().convert(number, param, ctx)
        return found


class Seconds(Number):
    """From 0 to `MOST_S`."""

    def __init__(self) -> None:
        super().__init__(min=0, max=MOST_S)
