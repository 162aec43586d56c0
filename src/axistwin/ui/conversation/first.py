"""What stands in place of the list before the first message: the first steps with a controller."""

from typing import NamedTuple

from axistwin.bench import Controller
from axistwin.scenes.reasons.compumotor import DEFAULTS


class FirstStep(NamedTuple):
    """A step: title, a sentence in the notation of the tutor's notes, and True if *Initialise* does it."""

    title: str
    words: str
    initialises: bool = False


HEAD = "No messages yet"
STEPS = {
    "digiplan": (
        FirstStep("Initialise", "Sends  (  and  U61,  so that it accepts commands.", True),
        FirstStep("Make X turn", "Type  X1000$  below and press Enter: 1000 steps."),
    ),
    "compumotor": (
        FirstStep("Give velocity and acceleration", f"Type  {DEFAULTS}  below and press Enter."),
        FirstStep("Make the motor turn", "Type  go_relative 25000  and press Enter: one turn."),
    ),
    "smartmotor": (
        FirstStep("Initialise", "Sends  UCI UDI ZS,  which clears the fault of open limit inputs.", True),
        FirstStep("Make the shaft turn", "Type  A=100 V=100000 P=4000 G  below and press Enter."),
    ),
}


def first_steps(controller: Controller) -> tuple[FirstStep, ...]:
    return STEPS.get(controller.product.family, ())


def about(controller: Controller) -> str:
    title = controller.product.indefinite.partition(" ")[2]
    return f"Messages between the host and the {title} appear here, with their times."
