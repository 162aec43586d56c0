"""Parameter types of the commands."""

from pathlib import Path
from typing import Any

import click

from axistwin.core.numbers import NumberError, real, shortened
from axistwin.core.storage import STANDARD_INPUT

FILE = click.Path(dir_okay=False, path_type=Path)  # A file.


class ProgramFile(click.Path):
    """Type of a parameter that is a file, or `-` for the standard input."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return STANDARD_INPUT if str(value) == "-" else super().convert(value, param, ctx)


PROGRAM = ProgramFile(dir_okay=False, path_type=Path)
MOST_S = 1e9  # Longest accepted time in seconds, about thirty years; a longer time is probably a typing error.
UNITS = {"kb": 1e3, "mb": 1e6, "gb": 1e9, "tb": 1e12, "": 1}
MOST_BYTES = 1e18
TRACE_LIMIT = "1GB"  # Default of `--trace-limit`.


class Number(click.FloatRange):
    """Type of a command-line parameter that is a finite number within limits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            number = real(value) if isinstance(value, str) else value
        except NumberError as error:
            self.fail(f"{error}.", param, ctx)
        found: float = super().convert(number, param, ctx)
        return found


class Size(click.ParamType[Any]):
    """Type of a command-line parameter that is a size in bytes, e.g. `500MB`, `2e6` or `none`."""

    name = "size"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        text = str(value).strip().lower()
        if text == "none":
            return None
        unit = next((unit for unit in UNITS if unit and text.endswith(unit)), "")
        try:
            size = real(text.removesuffix(unit).strip()) * UNITS[unit]
        except NumberError:
            size = 0
        if not 0 < size <= MOST_BYTES:
            self.fail(
                f"invalid size {shortened(str(value))}: expected a size or none, e.g. 200MB, 5GB or none", param, ctx
            )
        return int(size)


class Seconds(Number):
    """Type of a command-line parameter that is a time from 0 to `MOST_S` seconds."""

    def __init__(self) -> None:
        super().__init__(min=0, max=MOST_S)
