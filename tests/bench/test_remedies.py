"""A remedy leads out: an example in the message about an option, taken literally, is accepted in its place."""

from dataclasses import fields
from itertools import product as product_of

import pytest

from axistwin import Bench
from axistwin.bench import product, read_options
from axistwin.controllers.registry import OURS
from axistwin.core.errors import AxistwinError

from ..told import bare, examples

BAD = ("x", "", "-1", "2.5", "1e30", "[]", "[5, 1]", "{}", "{ a = 1 }", "true", "'12 parsec'")
STEPPER = ("limits", "home", "units", "encoder", "encoder.counts_per_rev", "motor",
           "motor.torque", "motor.inertia", "motor.pull_in", "load", "load.torque", "load.inertia")  # fmt: skip
SERVO = ("limits", "units", "motor", "load", "load.inertia_kg_m2")


def names(model: str) -> list[str]:
    made = product(model)
    of_an_axis = SERVO if model == "smartmotor" else STEPPER
    return [
        "line", "history", made.axes[0], *(field.name for field in fields(made.options)),
        *(f"{made.axes[0]}.{each}" for each in of_an_axis),
    ]  # fmt: skip


def error_of(model: str, options: dict[str, str]) -> str:
    try:
        Bench().add(model, **read_options([f"{name}={value}" for name, value in options.items()]))
    except AxistwinError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("model", OURS)
def test_the_examples_in_messages_lead_to_an_option_that_is_accepted(model: str) -> None:
    """A value may be invalid, and a table then incomplete; no message comes twice."""
    for name, bad in product_of(names(model), BAD):
        follow(model, name, bad)


def follow(model: str, name: str, bad: str) -> None:
    options, told = {name: bad}, [""]
    while (message := error_of(model, options)) and (found := examples(message)):
        assert message not in told, (name, bad)
        told.append(message)
        for example in found:
            key, equals, value = example.partition("=")
            if not equals or not key.strip().isidentifier():
                options = {name: bare(example)}
            elif key == name:
                options = {name: value}
            elif name.endswith(f".{key.strip()}"):
                options[name] = value.strip()
            else:
                options[f"{name.rpartition('.')[0] if name.count('.') > 1 else name}.{key.strip()}"] = value.strip()
