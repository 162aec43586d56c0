"""Chapter 6, and 12 of the base language: what the seven user pins are used for, and the AniLink bus.

    A, B   inputs; encoder or step and direction          E, F   RS-485 (channel 1), AniLink or inputs and outputs
    C, D   limit switches (UCP, UDM in limits.py)         G      synchronous go (UG)

At power-up all of them are inputs, which 5 kΩ resistors pull up.  A value written to a pin is kept in its latch whether
the pin is an output or not: written first, it makes the change to an output free of glitches.
"""

from axistwin.controllers.smartmotor.chapters import brakes
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.processor import Processor

ROLES = {"C": s.LIMIT_C, "D": s.LIMIT_D, "G": s.GO_PIN}
"""Pins with a role of their own until they are made ordinary inputs or outputs."""
CHANNEL_1 = "EF"


def power_up(motor: Processor) -> None:
    """Make all pins inputs."""
    for pin in motor.pins.values():
        pin.input()


def direction_in(motor: Processor, pin: str) -> None:
    """UAI … UGI: an ordinary input.  C and D are limits no more, G does not go, E and F leave channel 1.

    Where it was the brake's signal (5.1) it is that no more.
    """
    _take(motor, pin)
    _take_from_brake(motor, pin)
    motor.pins[pin].input()


def direction_out(motor: Processor, pin: str) -> None:
    """UAO … UGO: an output, which shows what its latch holds.  C and D are limits no more, E and F leave channel 1.

    A pin that is the brake's signal (5.1) shows that, without a moment at the level of its latch.
    """
    _take(motor, pin)
    bit = 1 << s.USER_PINS.index(pin)
    motor.pins[pin].output(brakes.engaged(motor) if motor.i[s.BRAKE_PIN] == bit else bool(motor.i[s.LATCHES] & bit))


def latch(motor: Processor, pin: str, value: int) -> None:
    """UA= … UG=: high for any value but 0; an output shows it at once.

    Where it was the brake's signal (5.1) it is that no more.
    """
    _take_from_brake(motor, pin)
    bit = 1 << s.USER_PINS.index(pin)
    motor.i[s.LATCHES] = motor.i[s.LATCHES] & ~bit | (bit if value else 0)
    if motor.pins[pin].is_output:
        motor.pins[pin].output(value != 0)


def go_pin(motor: Processor) -> None:
    """UG: pin G is an input whose falling edge does what G does."""
    direction_in(motor, "G")
    motor.i[s.GO_PIN] = 1


def take_for_channel(motor: Processor, number: int) -> None:
    """An RS-485 channel takes its pins: G as the direction line of channel 0, E and F as the two wires of channel 1."""
    if number == 0:
        _take(motor, "G")
        _take_from_brake(motor, "G")
        motor.pins["G"].output(False)
    else:
        for name in CHANNEL_1:
            motor.pins[name].input()


def _take(motor: Processor, pin: str) -> None:
    """End the role of the pin as limit, go input or wire of channel 1."""
    if pin in ROLES:
        motor.i[ROLES[pin]] = 0
    if pin in CHANNEL_1:
        motor.channels[1].shut()


def _take_from_brake(motor: Processor, pin: str) -> None:
    """Give the brake's pin another function, until BRKC or BRKG makes it the brake's signal again (5.1)."""
    if motor.i[s.BRAKE_PIN] == 1 << s.USER_PINS.index(pin):
        motor.i[s.BRAKE_PIN] = 0


def give_up_brake_pin(motor: Processor) -> None:
    """Make an ordinary input of the pin of the brake's signal, which `<variable>=UG` or `=UC` has read (5.1, note 2).

    A pin that is no output carries no signal and keeps its role.
    """
    motor.i[s.BRAKE_READ] = 0
    for pin in ("C", "G"):
        if motor.i[s.BRAKE_PIN] == 1 << s.USER_PINS.index(pin) and motor.pins[pin].is_output:
            direction_in(motor, pin)


def fetch_input(_motor: Processor) -> int:
    """AINpc, DINpc: analog or digital input of an AniLink device.  0: no such device exists."""
    return 0


def analog_out(_motor: Processor, _port: str, _value: int) -> None:
    """AOUTp,value: to the AniLink device p, A to H.  No such device exists."""


def digital_out(_motor: Processor, _port: str, _channel: int, _value: int) -> None:
    """DOUTpc,value: to the AniLink device p, A to H, channel 0 to 63.  No such device exists."""
