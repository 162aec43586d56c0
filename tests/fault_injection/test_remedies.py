"""A remedy leads out: an example in the message about a fault, taken literally, is accepted in its place."""

import pytest

from axistwin import Bench
from axistwin.bench import read_options
from axistwin.bench.faults import sentences
from axistwin.core.errors import AxistwinError

from ..told import bare, examples

FAULTS = (
    ("{}", ""),
    ("jam {}", ""),
    ("stuck {} low", ""),
    ("encoder_slips X {}", "5"),
    ("stall smartmotor.shaft{}", ""),
    ("lose serial {}", "probability=0.5"),
    ("lose serial probability=0.5 {}", ""),
    ("flip serial {}", "mask=0"),
    ("handshake {} dtr", "smartmotor.serial"),
    ("{} smartmotor.shaft", "drive_fault"),
    *(
        ("jam X {}", bad)
        for bad in ("at=x", "at=1e300", "duration=x", "duration=1e300", "nth=0", "nth=x", "seed=x", "when='x")
    ),
    *(
        ("jam X when='{}'", bad)
        for bad in (
            "x", "X goes", "X passes x", "input1 rises x", "if1 hears", "if1 says", "1811 hears", "1811 says zz",
            "smartmotor runs x", "1811 runs x", "X passes 1 parsec",
        )
    ),
)  # fmt: skip


def error_of(fault: str, *options: str) -> str:
    bench = Bench()
    given = read_options(options)
    bench.add("if1", **{name: value for name, value in given.items() if name != "shaft"})
    bench.add("1811")
    bench.add("smartmotor", **{name: value for name, value in given.items() if name == "shaft"})
    try:
        sentences.read(fault, bench.faults, "if1")()
    except AxistwinError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(("form", "bad"), FAULTS)
def test_an_example_in_a_message_about_a_fault_is_accepted(form: str, bad: str) -> None:
    message = error_of(form.format(bad))
    assert message
    for example in examples(message):
        if " = " in example or example.startswith("motor="):  # an option of the axis
            assert error_of(form.format(bad), f"{'shaft' if 'shaft' in form else 'X'}.{example}") == "", message
        else:
            assert error_of(form.format(example if "=" in example else bare(example))) == "", message
