"""The models of controllers, and their options."""

from collections.abc import Mapping
from dataclasses import fields
from importlib import import_module
from typing import Any

from axistwin.controllers.product import Product
from axistwin.core.errors import UsageError, most_similar
from axistwin.core.numbers import NumberError, check_values

OURS = {
    "if1": "axistwin.controllers.digiplan.card:IF1",
    "if2": "axistwin.controllers.digiplan.card:IF2",
    "1810": "axistwin.controllers.compumotor.card:BOARD_1810",
    "1811": "axistwin.controllers.compumotor.card:BOARD_1811",
    "smartmotor": "axistwin.controllers.smartmotor.card:SMARTMOTOR",
}
"""Our models, in the notation of entry points; the module is imported when the model is first used."""


def models() -> tuple[str, ...]:
    return tuple(OURS)


def is_model(name: object) -> bool:
    return isinstance(name, str) and name.lower() in OURS


def product(model: str | Product) -> Product:
    """Return the controller model with the given name, e.g. "1811".  Raises UsageError for an unknown name."""
    if isinstance(model, Product):
        return model
    if not is_model(model):
        raise UsageError(f"no model {model!r}: expected one of {', '.join(models())}{_similar(str(model))}")
    module, _, name = OURS[model.lower()].partition(":")
    found: Product = getattr(import_module(module), name)
    return found


def _similar(model: str) -> str:
    near = most_similar("".join(filter(str.isalnum, model.lower())), models())
    return f"; did you mean {near!r}?" if near else ""


def check_options(given: Mapping[str, Any]) -> None:
    """Raise UsageError if a whole number in the options, at any depth, has more than 64 bits."""
    try:
        check_values(given)
    except NumberError as error:
        raise UsageError(f"invalid option {'.'.join(map(str, error.path))}: {error}") from None


def model_options(made: Product, given: Mapping[str, Any]) -> Any:
    """Check the options of a controller model, and return them.  Raises UsageError for an unknown option."""
    known = [field.name for field in fields(made.options)]
    for name in given:
        if name not in known:
            known_options = ", ".join((*made.axes, *known))
            raise UsageError(f"model {made.model} has no option {name!r}: expected one of {known_options}")
    return made.options(**given)


def axis_options(name: str, given: object) -> dict[str, Any]:
    """Return the options of an axis as a dict.  Raises UsageError if the argument `given` is not a dict."""
    if not isinstance(given, Mapping):
        raise UsageError(
            f"invalid value {given!r} for axis {name}: expected a table of options, "
            f"e.g. {name}={{ limits = [-100, 5000] }}"
        )
    return dict(given)
