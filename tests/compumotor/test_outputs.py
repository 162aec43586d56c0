"""Undefined states of 0Fh, the shutdown input, the STEP output, and the jumper of the test switch."""

from ..scripts import scripts
from .scripts import play


@scripts(
    {
        "a state that is not defined is ignored": "0F 03 08 01; 0F 05 01 01; output1 is high",
        "the shutdown input takes the say from the command":
        "13 01; 12 01; shutdown is low; shutdown_in low; shutdown is high; shutdown_in high; shutdown is low",
        "the step pin is high for half a period of the highest frequency: STEP is high for half a period of the "
        "highest frequency: in range 0, 546,133.3 Hz, this is 915 ns":
        "default 1000 at_once; 33 =2; idle; 33 =2; until moving; 0.001 s; step is high; 1e-06 s; step is low",
        "the test switch needs its jumper": "1811 test_switch=False; test_switch high; 1 s; at 0",
    }
)  # fmt: skip
def test_outputs(bench, script):
    play(bench, script)
