"""Functions of the seven user pins, and the AniLink bus (chapter 6, and section 12 of the base language).

    A, B   inputs; encoder or step and direction          E, F   RS-485 (channel 1), AniLink or inputs and outputs
    C, D   limit switches (UCP, UDM in limits.py)         G      synchronous go (UG)

At power-up all pins are inputs, which 5 kΩ resistors pull up.  A value written to a pin is kept in a latch, even
while the pin is an input.  A value written first avoids a glitch at the change to an output.
"""

from axistwin.controllers.smartmotor.chapters import brakes
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.processor import Processor

ROLES = {"C": s.LIMIT_C, "D": s.LIMIT_D, "G": s.GO_PIN}  # Until a command makes them ordinary.
CHANNEL_1 = "EF"


def power_up(motor: Processor) -> None:
    """Configure all I/O pins as inputs."""
    for pin in motor.pins.values():
        pin.input()


def direction_in(motor: Processor, pin: str) -> None:
    """UAI … UGI: make the pin an ordinary input: no limit, go input, RS-485 wire or brake signal (5.1)."""
    _take(motor, pin)
    _take_from_brake(motor, pin)
    motor.pins[pin].input()


def direction_out(motor: Processor, pin: str) -> None:
    """UAO … UGO: make the pin an output (manual, section 5.1).

    The output has the level of the pin's latch, or of the brake signal.  Pins C and D are then no longer limits, pins E
    and F no longer channel 1.
    """
    _take(motor, pin)
    bit = 1 << s.USER_PINS.index(pin)
    motor.pins[pin].output(brakes.engaged(motor) if motor.i[s.BRAKE_PIN] == bit else bool(motor.i[s.LATCHES] & bit))


def latch(motor: Processor, pin: str, value: int) -> None:
    """UA= … UG=: set the latch of the pin; 0 is low, any other value is high.

    An output changes at once.  The pin is no longer the brake's signal (manual, section 5.1).
    """
    _take_from_brake(motor, pin)
    bit = 1 << s.USER_PINS.index(pin)
    motor.i[s.LATCHES] = motor.i[s.LATCHES] & ~bit | (bit if value else 0)
    if motor.pins[pin].is_output:
        motor.pins[pin].output(value != 0)


def go_pin(motor: Processor) -> None:
    """UG: make pin G an input whose falling edge has the effect of the command G."""
    direction_in(motor, "G")
    motor.i[s.GO_PIN] = 1


def take_for_channel(motor: Processor, number: int) -> None:
    """Reserve the pins of RS-485: G is the direction line of channel 0, E and F are the wires of channel 1."""
    if number == 0:
        _take(motor, "G")
        _take_from_brake(motor, "G")
        motor.pins["G"].output(False)
    else:
        for name in CHANNEL_1:
            motor.pins[name].input()


def _take(motor: Processor, pin: str) -> None:
    if pin in ROLES:
        motor.i[ROLES[pin]] = 0
    if pin in CHANNEL_1:
        motor.channels[1].shut()


def _take_from_brake(motor: Processor, pin: str) -> None:
    """Remove the brake's signal from the pin, until BRKC or BRKG selects the pin again (5.1)."""
    if motor.i[s.BRAKE_PIN] == 1 << s.USER_PINS.index(pin):
        motor.i[s.BRAKE_PIN] = 0


def give_up_brake_pin(motor: Processor) -> None:
    """Make the pin of the brake's signal an ordinary input, because `<variable>=UG` or `=UC` has read the pin (5.1,
    note 2).  An input carries no signal and keeps its role.
    """
    motor.i[s.BRAKE_READ] = 0
    for pin in ("C", "G"):
        if motor.i[s.BRAKE_PIN] == 1 << s.USER_PINS.index(pin) and motor.pins[pin].is_output:
            direction_in(motor, pin)


def fetch_input(_motor: Processor) -> int:
    """AINpc, DINpc: read an input of an AniLink device.  No device is emulated, so the value is 0."""
    return 0


def analog_out(_motor: Processor, _port: str, _value: int) -> None:
    """AOUTp,value: analog output of the AniLink device p, A to H.  Not emulated: no effect."""


def digital_out(_motor: Processor, _port: str, _channel: int, _value: int) -> None:
    """DOUTpc,value: digital output of the AniLink device p, A to H, channel 0 to 63.  Not emulated: no effect."""
