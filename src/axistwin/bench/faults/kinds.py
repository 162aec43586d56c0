"""The table of all kinds of faults, each with the thing it acts on and its parameters."""

from axistwin.bench.faults import lines, machines, places
from axistwin.bench.faults.lines import WAYS
from axistwin.bench.faults.table import Kind, On, Parameter, Sort
from axistwin.core.errors import UsageError, instead

SIDES = "minus", "plus", "both"
CONTROL_LINES = "dtr", "rts", "dsr", "cts"

COUNT = Parameter(
    "count", Sort.WHOLE, "number of characters; default 1, or all if a probability or a duration is given", low=1,
    optional=True, unit="characters",
)  # fmt: skip
PROBABILITY = Parameter("probability", Sort.NUMBER, "probability for each character", default=1.0, low=0, high=1)
TO = Parameter("way", Sort.WORD, "to the device, from it, or both", default="to", words=WAYS)
BOTH = Parameter("way", Sort.WORD, "to the device, from it, or both", default="both", words=WAYS)
MASK = Parameter("mask", Sort.WHOLE, "data bits to invert; 0: a random one", default=1, low=0, high=255)
FAR = 1 << 31

KINDS = {
    kind.name: kind
    for kind in (
        Kind("lose", On.LINE, "characters never arrive", lines.lose, (COUNT, PROBABILITY, TO)),
        Kind("double", On.LINE, "characters arrive twice", lines.double, (COUNT, PROBABILITY, TO)),
        Kind("flip", On.LINE, "data bits of characters are inverted", lines.flip, (COUNT, MASK, PROBABILITY, TO)),
        Kind("break", On.LINE, "the line is at space, as by a short circuit", lines.line_break, (
            Parameter("seconds", Sort.NUMBER, "its duration", "s", 0.25, low=1e-6, high=1000), TO), at_once=True),
        Kind("baud", On.LINE, "the host is set to a wrong baud rate", lines.baud, (
            Parameter("baudrate", Sort.WHOLE, "the wrong baud rate", "baud", low=1, high=10_000_000),)),
        Kind("drift", On.LINE, "the sender's clock runs fast or slow", lines.drift, (
            Parameter("percent", Sort.NUMBER, "deviation; positive: faster", "%", low=-90, high=900), BOTH)),
        Kind("delay", On.LINE, "characters arrive later, in order", lines.late, (
            Parameter("seconds", Sort.NUMBER, "delay", "s", low=0, high=1000),
            Parameter("jitter", Sort.NUMBER, "maximum random extra delay", "s", 0.0, low=0, high=1000), BOTH)),
        Kind("cut", On.LINE, "the wires are open; with both ways also the control lines", lines.cut, (BOTH,)),
        Kind("handshake", On.LINE, "a control line is stuck", lines.handshake, (
            Parameter("line", Sort.WORD, "a control line of the device", words=CONTROL_LINES),
            Parameter("level", Sort.LEVEL, "the level", default=False)), check=lines.check_handshake),
        Kind("hang_up", On.LINE, "the port disconnects its client, and is gone", lines.hang_up),
        Kind("stuck", On.PIN, "a switch or a pin stays at a level", machines.stuck, (
            Parameter("level", Sort.LEVEL, "the level", optional=False),)),
        Kind("bounce", On.PIN, "a switch bounces whenever it changes", machines.bounce, (
            Parameter("ms", Sort.NUMBER, "approximate duration of bouncing", "ms", 5.0, low=0.001, high=10_000),
            Parameter("count", Sort.WHOLE, "number of bounces", "times", 5, low=1, high=1000))),
        Kind("open_wire", On.PIN, "the wire of an input is broken: no current flows", machines.open_wire,
             check=machines.check_wire),
        Kind("open_limit", On.CONTROLLER, "a limit switch's circuit is open", machines.open_limit, (
            Parameter("side", Sort.WORD, "the switch", default="both", words=SIDES),), check=machines.check_limits),
        Kind("encoder_slips", On.AXIS, "the encoder turns on its shaft, once", machines.encoder_slips, (
            Parameter("counts", Sort.WHOLE, "displacement", "counts", low=-FAR, high=FAR),), at_once=True,
            check=machines.check_encoder),
        Kind("encoder_loses", On.AXIS, "the encoder loses counts", machines.encoder_loses, (
            Parameter("every", Sort.WHOLE, "distance between lost counts", "counts", 10, low=2, high=FAR),),
            check=machines.check_encoder),
        Kind("encoder_reversed", On.AXIS, "the encoder counts backwards", machines.encoder_reversed,
             check=machines.check_encoder),
        Kind("encoder_dead", On.AXIS, "the encoder stops counting", machines.encoder_dead,
             check=machines.check_encoder),
        Kind("stall", On.AXIS, "the motor loses its torque", machines.stall, (
            Parameter("left", Sort.NUMBER, "remaining fraction of the torque", default=0.0, low=0, high=1),),
            check=machines.check_data_sheet),
        Kind("jam", On.AXIS, "the shaft cannot turn", machines.jam),
        Kind("load", On.AXIS, "a torque acts on the shaft", machines.load, (
            Parameter("torque", Sort.NUMBER, "positive turns it in the positive direction", "N·m", low=-1000,
                      high=1000),)),
        Kind("push", On.AXIS, "the load is displaced, once", machines.push, (
            Parameter("counts", Sort.WHOLE, "displacement", "counts", low=-FAR, high=FAR),), at_once=True,
            check=machines.check_push),
        Kind("drive_fault", On.AXIS, "the drive switches off and signals a fault", machines.drive_fault,
             check=machines.check_drive),
        Kind("overheat", On.CONTROLLER, "a SmartMotor's surroundings are hot", machines.overheat, (
            Parameter("celsius", Sort.NUMBER, "ambient temperature", "°C", 90.0, low=-40, high=150),),
            check=machines.check_motor),
        Kind("supply_dip", On.CONTROLLER, "the supply sags; a SmartMotor resets below 18 V", machines.supply_dip, (
            Parameter("left", Sort.NUMBER, "remaining fraction of its voltage", default=0.5, low=0, high=1),),
            check=machines.check_data_sheet),
        Kind("power_cut", On.CONTROLLER, "the power is off", machines.power_cut),
    )
}  # fmt: skip
"""All kinds by name."""

PLACES = {On.LINE: places.lines, On.PIN: places.pins, On.AXIS: places.axes, On.CONTROLLER: places.controllers}
"""For each type of part, the function that yields all parts of this type on a bench."""
THINGS = {On.LINE: "serial line", On.PIN: "pin", On.AXIS: "axis", On.CONTROLLER: "controller"}
"""For each type of part, its name in messages."""


def kind_of(name: str) -> Kind:
    """Return the kind of fault with this name.  Raises UsageError for an unknown name."""
    if name in KINDS:
        return KINDS[name]
    raise UsageError(f"unknown kind of fault {name!r}: {instead(name, KINDS)}")
