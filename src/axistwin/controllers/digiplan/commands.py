"""Command set of the IF1 and IF2, in the order of the manual's appendix 1.  One line, one character."""

from functools import partial

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.digiplan import index, interpolation, lockout, outputs, report, run, sequence
from axistwin.controllers.digiplan.initialise import only_at_initialisation
from axistwin.controllers.digiplan.language import Accept, Direction, Instruction, Lines, Order, Written, written
from axistwin.controllers.digiplan.speed import setting

PART = Accept.WRITTEN
SETUP = Accept.SETUP
MOVE = Accept.DIRECT | Accept.STEP
DIRECT = Accept.DIRECT
STEP = Accept.STEP
ALONE = Accept.DIRECT | Accept.ALONE
ASK = Accept.DIRECT | Accept.ALONE | Accept.LOCKED

SIGN = Direction("direction")
DISTANCE = Written("distance", "steps", 0, 999_999_999, optional=True, pattern=r"(\d*)")
INPUTS = Lines("inputs", "", 1, 3)
OUTPUTS = Lines("outputs", "", 1, 5)
BACKLASH = Written("signed distance", "steps", -255, 255, optional=True, pattern=r"([+-]\d+)?")
LENGTH = Written("length", "x 10 ms", 1, 99, optional=True, pattern=r"(?:,(\d+))?")


def number(name: str, unit: str, low: int, high: int, pattern: str = r"(\d+)") -> Written:
    """A parameter that must be there."""
    return Written(name, unit, low, high, pattern=pattern)


ORDER, I = Order, Instruction  # noqa: E741  # a table is read by its columns

# fmt: off
COMMANDS = CommandSet(
    # code  name                         chapter                     parameters                                       accepted handler                             order
    I("\n", "line feed",                 "Initialisation",           (),                                              PART,    written),
    I("\r", "initialise direct command", "Initialisation",           (),                                              PART,    written),
    I(" ",  "space character",           "Sending basic move instructions", (),                                       PART,    written),
    I("#",  "cancel",                    "Index mode instructions",  (),                                              ALONE,   index.cancel),
    I("$",  "start index, run, sequence", "Index mode instructions", (),                                              PART,    written),
    I("%",  "wait for control",          "Controller intervention in a sequence", (),                                 MOVE,    sequence.hand_over),
    I("(",  "baud rate detect",          "Initialisation",           (),                                              SETUP,   only_at_initialisation),
    I("*",  "erase RAM (battery backup)", "Breaking into a locked interface", (),                                     SETUP,   only_at_initialisation),
    I("+",  "direction high",            "Index mode instructions",  (),                                              PART,    written),
    I(",",  "delimiter",                 "Output switching commands", (),                                             PART,    written),
    I("-",  "direction low",             "Index mode instructions",  (),                                              PART,    written),
    I("/",  "linear interpolation",      "Linear interpolation mode", (),                                             MOVE,    interpolation.minor_axis,           order=ORDER.MOVE),
    I(":",  "sequence divider",          "Programming a sequence",   (),                                              PART,    written),
    I("<",  "start/stop speed",          "Start/stop speed",         (number("speed", "x 100 steps/s", 1, 40),),      DIRECT,  partial(setting, "start_stop"),     order=ORDER.MOVE),
    I("=",  "repeat",                    "Repeating parts of a sequence", (number("times", "", 0, 255), number("step", "", 1, 63, r",(\d+)")), STEP, sequence.repeat, order=ORDER.REPEAT),
    I(">",  "select speed range",        "Speed",                    (number("range", "", 1, 4),),                    DIRECT,  partial(setting, "speed_range"),    order=ORDER.MOVE),
    I("@",  "speed data",                "Speed",                    (number("speed", "steps/s", 1, 99_999),),        MOVE,    partial(setting, "speed"),          order=ORDER.MOVE),
    I("A",  "abort in sequence mode",    "Aborting a run-mode move in a sequence", (),                                STEP,    run.abort,                          order=ORDER.ABORT),
    I("B",  "backlash",                  "Backlash correction",      (BACKLASH,),                                     MOVE,    index.backlash,                     order=ORDER.MOVE),
    I("D",  "inter-character delay",     "Inter-character delay",    (number("delay", "x 10 ms", 0, 25),),            DIRECT,  partial(setting, "character_delay"), order=ORDER.MOVE),
    I("E",  "busy",                      "Busy status",              (),                                              ASK,     report.busy_status),
    I("F",  "communication status",      "Motion status",            (),                                              ASK,     report.communication_status),
    I("G",  "run mode",                  "Run mode instructions",    (),                                              MOVE,    run.go,                             order=ORDER.MOVE),
    I("H",  "input high",                "Combining inputs and outputs with move instructions", (INPUTS,),            MOVE,    outputs.wait_high,                  order=ORDER.HIGH),
    I("I",  "input status",              "Input status",             (),                                              ASK,     report.input_status),
    I("K",  "motion status",             "Motion status",            (),                                              ASK,     report.motion_status),
    I("L",  "input low",                 "Combining inputs and outputs with move instructions", (INPUTS,),            MOVE,    outputs.wait_low,                   order=ORDER.LOW),
    I("N",  "number of steps run or indexed", "Position report-back", (),                                             ASK,     report.position),
    I("O",  "sequence status",           "Sequence status",          (),                                              ASK,     report.sequence_status),
    I("P",  "pulse output",              "Output switching commands", (number("output", "", 0, 5, r"(\d)"), LENGTH),  MOVE,    outputs.pulse_output,               order=ORDER.PULSE),
    I("Q",  "quick status byte",         "Quick status",             (),                                              ASK,     report.quick_status),
    I("R",  "reset output low",          "Output switching commands", (OUTPUTS,),                                     MOVE,    outputs.reset_outputs,              order=ORDER.RESET),
    I("S",  "set output high",           "Output switching commands", (OUTPUTS,),                                     MOVE,    outputs.set_outputs,                order=ORDER.SET),
    I("U",  "RS232 format set (termination on <CR>)", "Initialisation", (),                                           SETUP,   only_at_initialisation),
    I("V",  "RS232 format set (termination on <LF>)", "Initialisation", (),                                           SETUP,   only_at_initialisation),
    I("X",  "X clock",                   "Index mode instructions",  (SIGN, DISTANCE),                                MOVE,    partial(index.axis, "X"),           order=ORDER.MOVE),
    I("Y",  "Y clock",                   "Index mode instructions",  (SIGN, DISTANCE),                                MOVE,    partial(index.axis, "Y"),           order=ORDER.MOVE),
    I("Z",  "Z clock",                   "Index mode instructions",  (SIGN, DISTANCE),                                MOVE,    partial(index.axis, "Z"),           order=ORDER.MOVE),
    I("[",  "communication lock",        "Communication lockout commands", (),                                        ALONE,   lockout.lock),
    I("]",  "communication unlock",      "Communication lockout commands", (),                                        ASK,     lockout.unlock),
    I("^",  "acceleration rate data",    "Acceleration rate",        (number("acceleration", "x 1000 steps/s²", 1, 500),), DIRECT, partial(setting, "acceleration"), order=ORDER.MOVE),
)
# fmt: on
