"""A number of seconds on the command line."""

from typing import Any

import click

MOST_S = 1e9
"""Some thirty years; more is a slip of the pen."""


class Seconds(click.FloatRange):
    """From 0 to `MOST_S`; unlike its base it does not take nan."""

    def __init__(self) -> None:
        super().__init__(min=0, max=MOST_S)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """What has been written, as a number."""
        number: float = super().convert(value, param, ctx)
        if number != number:  # nan alone is not what it is
            self.fail(f"{value!r} is no number of seconds.", param, ctx)
        return number
