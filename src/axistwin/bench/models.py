"""The models of controllers, and their options."""

from collections.abc import Mapping
from dataclasses import fields
from importlib import import_module
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Union

from axistwin.controllers.product import Product
from axistwin.controllers.registry import OURS, Place, check_name, names, places
from axistwin.core.errors import UsageError, most_similar
from axistwin.core.numbers import NumberError, check_values

if TYPE_CHECKING:
    from axistwin.devices.device import Device

Model = Union[str, Product, "type[Device]"]
"""A model by its name, a class of a device, or a product."""

LOAD = "load the file of another device, axistwin --device FILE.py …, or install its package"


def models() -> tuple[str, ...]:
    """Return the names of all models: ours, and those of loaded files and installed packages."""
    return names()


def is_model(name: object) -> bool:
    return isinstance(name, str) and bool(places(name))


def product(model: "Model") -> Product:
    """Return a controller model by its name, e.g. "1811", or of a class that derives from `Device`.

    The code of a model is imported now.  Raises UsageError for an unknown name, or if the code cannot be imported.
    """
    if isinstance(model, type):
        return _checked(_product(model), f"class {model.__name__}")
    if isinstance(model, Product):
        return _checked(model, "the product")
    found = places(str(model)) if is_model(model) else ()
    if not found:
        raise UsageError(f"no model {model!r}: expected one of {', '.join(models())}; {_remedy(str(model))}")
    if len(found) > 1:
        both = " and ".join(place.where for place in found)
        raise UsageError(f"two devices have the name {model!r}, {both}: rename one, or leave one of them out")
    return _at(found[0], model.lower())


def _at(place: Place, model: str) -> Product:
    module, _, name = place.object.partition(":")
    if model in OURS:
        ours: Product = getattr(import_module(module), name)
        return ours
    try:
        found = attrgetter(name)(import_module(module))
    except (Exception, SystemExit) as error:  # noqa: BLE001  # of another package
        raise UsageError(
            f"the model {model!r} cannot be imported from {place.where} ({type(error).__name__}: {error}): "
            "correct or remove this package"
        ) from None
    made = _checked(found if isinstance(found, Product) else _product(found), place.where)
    if made.model != model:
        raise UsageError(f"{place.where} is the model {made.model!r}, not {model!r}: give both the same name")
    return made


def _product(kind: Any) -> Product:
    # Imported here, because only the devices of others need it.
    from axistwin.bench.device_checker import checked_product
    from axistwin.devices.device import Device

    a_device = isinstance(kind, type) and issubclass(kind, Device)
    if not a_device:
        name = getattr(kind, "__name__", repr(kind))
        raise UsageError(f"{name} is not a device: expected a class that derives from axistwin.devices.Device")
    return checked_product(kind)


def _checked(made: Product, what: str) -> Product:
    if made.model not in OURS or made is not product(made.model):
        check_name(made.model, what)
    return made


def _remedy(model: str) -> str:
    near = most_similar("".join(filter(str.isalnum, model.lower())), models())
    return f"did you mean {near!r}?" if near else LOAD


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
