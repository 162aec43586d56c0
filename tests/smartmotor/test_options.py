"""The options of a SmartMotor: both ends of each range are accepted; for other values the error names the option."""

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

RANGES = [
    ("statements_per_sample", 1, 100, 1), ("boot_window_s", 0.0, 10.0, 0.001), ("debounce_samples", 1, 100, 1),
    ("reset_below_v", 0.0, 100.0, 0.001), ("host_buffer", 2, 4096, 1), ("program_bytes", 256, 1048576, 1),
    ("data_bytes", 256, 1048576, 1), ("index_at", 0, 1048576, 1),
]  # fmt: skip
CHOICES = [("cam_multiplier", ["master", "table"]), ("stop_buffers", ["position", "same"]), ("load_block", [8, 32])]


@pytest.mark.parametrize(("name", "low", "high", "step"), RANGES)
def test_the_ends_of_an_option(name, low, high, step):
    for value in (low, high):
        Bench().add("smartmotor", **{name: value})
    for value in (low - step, high + step, True, "5", None):
        with pytest.raises(UsageError, match=name):
            Bench().add("smartmotor", **{name: value})


@pytest.mark.parametrize(("name", "choices"), [*CHOICES, ("array_overlay", [True, False]), ("brake", [True, False])])
def test_the_choices_of_an_option(name, choices):
    for value in choices:
        Bench().add("smartmotor", **{name: value})
    for value in ("neither", 16, 1.0, None):
        with pytest.raises(UsageError, match=name):
            Bench().add("smartmotor", **{name: value})
