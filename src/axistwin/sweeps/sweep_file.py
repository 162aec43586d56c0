"""A sweep file: the options of `axistwin sweep` in TOML.

scene = "scene.toml"
for = 10
design = "sobol"
runs = 256

[vary]
"table.X.load.torque" = "0.05..0.4"

[measure]
cycle = "from table.output1 rises to table.output1 falls"

[claim]
safe = "never table.X passes 12000 while table.output1 high"
"""

import re
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from axistwin.core.errors import AxistwinError, PlacedError, SceneError
from axistwin.scenes.source import read_text
from axistwin.scenes.toml_places import place_of, places
from axistwin.sweeps.sentences import CLAIMS, MEASURES, Form
from axistwin.sweeps.sweep import Design, Sweep


def _told(forms: tuple[Form, ...]) -> str:
    return "; ".join(f"{form.form}: {form.meaning}" for form in forms)


class SweepFile(BaseModel):
    """Contents of a sweep file: the options of `axistwin sweep`."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True, populate_by_name=True, strict=True)

    scene: str
    """The scene, relative to this file."""
    program: str | None = None
    """A program or conversation that is part of every run, relative to this file."""
    host: Annotated[str, Field(pattern=r"^[\w.]+:\w+$")] | None = None
    """A Python host, MODULE:FUNCTION, that is called with the bench of each run."""
    seconds: float | None = Field(default=None, alias="for", gt=0)
    """Virtual time of each run in seconds; if left out, a run ends when nothing moves and no event is due."""
    design: Literal["grid", "zip", "random", "lhs", "sobol", "saltelli"] = "grid"
    """Design: the combinations of values that are run."""
    runs: Annotated[int, Field(ge=1)] | None = None
    """Number of runs of a random design, or number of runs for each point of a grid."""
    seed: Annotated[int, Field(ge=0)] = 0
    """Seed of random values."""
    search: Annotated[int, Field(ge=1)] | None = None
    """Number of runs of a search for the worst point; replaces the design."""
    vary: Annotated[dict[str, Any], Field(min_length=1)]
    """Values by path: "0.05..0.4:8", "normal(1, 0.1)", [1, 2, 4]."""
    measure: Annotated[dict[str, str], Field(description=f"Measures by name.  {_told(MEASURES)}")] = {}
    claim: Annotated[dict[str, str], Field(description=f"Claims by name.  {_told(CLAIMS)}")] = {}

    def sweep(self, file: Path) -> Sweep:
        """Return the sweep of the file.  Raises SceneError with file, line and column of an invalid value."""
        text = read_text(file)
        program = None if self.program is None else file.parent / self.program
        made: Sweep = _placing(file, text, ("scene",), lambda: Sweep(file.parent / self.scene, program, self.host))
        for key, table, add in (
            ("vary", self.vary, made.vary), ("measure", self.measure, made.measure), ("claim", self.claim, made.claim),
        ):  # fmt: skip
            for name, value in table.items():
                _placing(file, text, (key, name), partial(add, name, value))
        return made

    def chosen(self) -> Design:
        return Design(self.design, self.runs, self.seed, self.search)


def is_sweep_file(file: Path) -> bool:
    """True if a TOML file is a sweep file: it has the key `scene` and no [[controller]]."""
    try:
        data = tomllib.loads(read_text(file))
    except (ValueError, RecursionError):
        return False
    return "scene" in data and "controller" not in data


def load(file: Path) -> SweepFile:
    """Read a sweep file.  Raises SceneError with the file, line and column of the first error."""
    text = read_text(file)
    try:
        return SweepFile.model_validate(tomllib.loads(text))
    except ValueError as error:
        if not isinstance(error, ValidationError):
            raise SceneError(f"invalid TOML ({error}): expected a sweep file", file=str(file)) from None
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"]))
        raise _placed(f"invalid key {key}: {first['msg'].lower()}", file, text, first["loc"]) from None


def check(file: Path) -> None:
    """Raise SceneError with file, line and column if the sweep in the file cannot run."""
    contents, text = load(file), read_text(file)
    made = contents.sweep(file)
    try:
        made.check(contents.chosen(), contents.seconds)
    except PlacedError:
        raise
    except AxistwinError as error:
        tables = ((key, name) for key in ("vary", "measure", "claim") for name in getattr(contents, key))
        at = next((keys for keys in tables if _names(str(error), keys[1])), ("design",))
        raise _placed(str(error), file, text, at) from None


def _names(message: str, name: str) -> bool:
    return re.search(rf"(?<![\w.]){re.escape(name)}(?![\w.])", message) is not None


def _placing(file: Path, text: str, keys: tuple[str, ...], do: Callable[[], Any]) -> Any:
    try:
        return do()
    except PlacedError:
        raise
    except AxistwinError as error:
        raise _placed(str(error), file, text, keys) from None


def _placed(message: str, file: Path, text: str, keys: tuple[str | int, ...]) -> SceneError:
    line, column = place_of(keys, places(text))
    return SceneError(message, file=str(file), line=line, column=column)
