"""The front panel of an 1810 or 1811: status byte, alarm lamp, connectors, and the answer to 88h.

Chapters Programming: The Status Byte (C.2), Interrupts (D); Functional check; Specifications: Inputs and Outputs;
appendix A, 88h.
"""

from axistwin.controllers.compumotor.parts.pulses import Phase
from axistwin.controllers.front import Group, Lamp, Reading, Tone, Word

MODES = {
    0: "no power", 0x50: "50h indexer", 0x51: "51h velocity-distance streaming", 0x52: "52h velocity-time streaming",
    0x53: "53h distance-time streaming",
}  # fmt: skip
STATUS, INPUTS_OUTPUTS = "Programming: The Status Byte", "Specifications: Inputs and Outputs"
AUXILIARY, JOYSTICK, DRIVER, ENCODER = (
    f"{INPUTS_OUTPUTS}, {name}" for name in ("Auxiliary", "Joystick", "Motor/Driver", "Encoder")
)
PHASES = {phase.name.lower(): phase.value for phase in Phase} | {"joystick": "moved by the joystick", "off": "no power"}

FRONT = (
    Group("Status byte", STATUS, (
        Lamp("7", "interrupt", "status", 7, tone=Tone.WARNING, doc="The board interrupts; bits 3 to 5 show why."),
        Lamp("6", "interrupt mask set", "status", 6, doc="The inverse of bit 6 of the control byte."),
        Lamp("5", "fail", "status", 5, tone=Tone.FAULT, doc="Cleared by a reset: CB bit 5, the bus, or power."),
        Lamp("4", "IDB ready", "status", 4, doc="The host may write a command."),
        Lamp("3", "ODB ready", "status", 3, doc="There is a message for the host."),
        *(Lamp(f"{n}", f"user bit {n}", "status", n, doc="Set by 08h to 0Ah; with 0Fh it shows a state.")
          for n in (2, 1, 0)),
    ), row=True),
    Group("Board", "Functional check; Programming: Interrupts", (
        Lamp("ALARM", "board monitor alarm", "led", tone=Tone.FAULT, doc=(
            "The red lamp at the board's edge: the board has failed or ended its test, and needs a reset.")),
        Lamp("INT", "interrupt line", "interrupt", tone=Tone.WARNING, doc="To the host, over the bus."),
        Word("", "mode", "mode", MODES),
        Word("", "motion", "phase", PHASES, unpowered="no power"),
        Reading("", "commands waiting", "queue", doc="Read from the IDB and not performed yet."),
        Word("IDB", "input data buffer", "input", {"": "empty"}),
        Word("ODB", "output data buffer", "output", {"": "empty"}),
    )),
    Group("Move status 88h", "Appendix A: 88h", (
        Lamp("+", "plus limit active", "move", 0, tone=Tone.FAULT),
        Lamp("−", "minus limit active", "move", 1, tone=Tone.FAULT),
        Lamp("HOME", "home switch active", "move", 2, doc="Active high, unless 38h defines low."),
        Lamp("DIR −", "direction is minus", "move", 3, doc="The present or most recent direction."),
        Lamp("MOV", "moving", "move", 4),
        Lamp("CONST", "constant, non-zero velocity", "move", 5),
        Lamp("ACC", "accelerating", "move", 6),
        Lamp("DEC", "decelerating", "move", 7),
    ), row=True),
    Group("Outputs", f"{AUXILIARY}; {DRIVER}", (
        Lamp("1", "programmable output 1", "output1", doc="Set at power-up."),
        Lamp("2", "programmable output 2", "output2", doc="Set at power-up."),
        Lamp("RPS", "remote power shutdown", "shutdown", tone=Tone.WARNING, doc="The motor has no current."),
        Lamp("CW", "direction", "direction", doc="High: clockwise."),
        Lamp("STEP", "step", "step", doc="High for half a period after each pulse."),
        Lamp("CW STEP", "clockwise step", "cw_step", lit=False, doc=(
            "Low while STEP is high clockwise; open collector.")),
        Lamp("CCW STEP", "counter-clockwise step", "ccw_step", lit=False, doc=(
            "Low while STEP is high counter-clockwise; open collector.")),
    ), row=True),
    Group("Interrupt lines", "Installation: Multibus interrupts", (
        Lamp("JU18", "message ready", "ju18", doc="The jumper's right side; no mask affects it."),
        Lamp("JU20", "input ready", "ju20", doc="The jumper's right side; no mask affects it."),
        Lamp("JU19", "controller failed", "ju19", tone=Tone.FAULT, doc="The jumper's right side; no mask affects it."),
    ), row=True),
    Group("Limits and triggers", AUXILIARY, (
        Lamp("CW", "clockwise limit", "cw_limit", tone=Tone.FAULT, doc="High: active."),
        Lamp("CCW", "counter-clockwise limit", "ccw_limit", tone=Tone.FAULT, doc="High: active."),
        *(Lamp(f"{n}", f"trigger {n}", f"trigger{n}", doc="A TTL level; open it is high.") for n in range(1, 7)),
    ), row=True),
    Group("Joystick", JOYSTICK, (
        Lamp("REQ", "remote enable", "remote_enable", lit=False, doc=(
            "Low: the joystick requests control of the motor.  The board only reports the level (95h).")),
        Lamp("ACK", "remote acknowledge", "remote_acknowledge", doc="The joystick controls the motor (11h)."),
        Lamp("ZERO", "at zero", "at_zero", doc="The joystick outputs no pulses."),
    ), row=True),
)  # fmt: skip
FRONT_1811 = (
    *FRONT,
    Group("Encoder", ENCODER, (
        Lamp("Z", "channel Z", "channel_z", doc="The encoder's index mark; 96h reports it as inverted by JU16."),
        Lamp("STEP", "encoder step", "encoder_step", doc="High for 229 ns after each count."),
        Lamp("DIR", "encoder direction", "encoder_direction", doc="High: positive, unless JU17 inverts it."),
    ), row=True),
)  # fmt: skip
