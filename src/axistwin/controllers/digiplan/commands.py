"""Command set of the IF1 and IF2, in the order of the manual's appendix 1, one character per line."""

from functools import partial

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.digiplan.chapters import index, interpolation, lockout, outputs, report, run, sequence
from axistwin.controllers.digiplan.chapters.initialise import only_at_initialisation
from axistwin.controllers.digiplan.chapters.speed import setting
from axistwin.controllers.digiplan.language import Accept, Direction, Instruction, Lines, Order, Written, written
from axistwin.controllers.digiplan.step import RANGES

# Conditions under which commands are allowed, e.g. only during initialisation
PART, SETUP, DIRECT, STEP = Accept.WRITTEN, Accept.SETUP, Accept.DIRECT, Accept.STEP
MOVE, ALONE, UNLOCK = DIRECT | STEP, DIRECT | Accept.ALONE, DIRECT | Accept.ALONE | Accept.LOCKED
ASK = UNLOCK | Accept.REQUEST

# Titles of chapters in the Digiplan manual
INITIALISATION, DELAY = "Initialisation", "Inter-character delay"
BASIC, SPEED, START_STOP = "Sending basic move instructions", "Speed", "Start/stop speed"
ACCELERATION, INDEX, RUN = "Acceleration rate", "Index mode instructions", "Run mode instructions"
BACKLASH, SWITCHING = "Backlash correction", "Output switching commands"
COMBINING = "Combining inputs and outputs with move instructions"
SEQUENCE, REPEATS = "Programming a sequence", "Repeating parts of a sequence"
ABORT, INTERVENTION = "Aborting a run-mode move in a sequence", "Controller intervention in a sequence"
INTERPOLATION, LOCKOUT = "Linear interpolation mode", "Communication lockout commands"
STATUS, INPUT_STATUS, SEQ_STATUS = "Motion status", "Input status", "Sequence status"
QUICK_STATUS, BUSY, POSITION = "Quick status", "Busy status", "Position report-back"
BREAKING_IN = "Breaking into a locked interface"

# Parameters of the commands
START = Written("start/stop speed", "x 100 steps/s", *RANGES["start_stop"])
RANGE = Written("range", "", *RANGES["speed_range"])
RATE = Written("speed", "steps/s", *RANGES["speed"])
GAIN = Written("acceleration", "x 1000 steps/s²", *RANGES["acceleration"])
PAUSE = Written("delay", "x 10 ms", *RANGES["character_delay"])
SIGN = Direction("direction", optional=True)
DISTANCE = Written("distance", "steps", *RANGES["distance"], optional=True, pattern=r"(\d*)")
PLAY = Written("signed distance", "steps", *RANGES["backlash"], optional=True, pattern=r"([+-]\d+)?")
FORMAT = Written("frame", "", 1, 8, pattern=r"(\d)"), Written("parity", "", 1, 9, pattern=r"(\d)")
INPUTS = Lines("inputs", "", 1, 3)
OUTPUTS = Lines("outputs", "", 1, 5)
OUTPUT = Written("output", "", 0, 5, pattern=r"(\d)")
LENGTH = Written("length", "x 10 ms", *RANGES["pulse_length"], optional=True, pattern=r"(?:,(\d+))?")
TIMES = Written("times", "", 0, 255)
FIRST = Written("first step", "", 1, 63, pattern=r",(\d+)")

I = Instruction  # noqa: E741  # short, for the columns of the table

# fmt: off
COMMANDS = CommandSet(
    I("\n", "line feed",                      INITIALISATION, (),               PART,   written),
    I("\r", "initialise direct command",      INITIALISATION, (),               PART,   written),
    I(" ",  "space character",                BASIC,          (),               PART,   written),
    I("#",  "cancel",                         INDEX,          (),               ALONE,  index.cancel),
    I("$",  "index, run and sequence start",  INDEX,          (),               PART,   written, form="…$"),
    I("%",  "wait for control",               INTERVENTION,   (),               MOVE,   sequence.hand_over),
    I("(",  "baud rate detect",               INITIALISATION, (),               SETUP,  only_at_initialisation),
    I("*",  "erase RAM (battery backup)",     BREAKING_IN,    (),               SETUP,  only_at_initialisation),
    I("+",  "direction high",                 INDEX,          (),               PART,   written, form="X+ Y+ Z+"),
    I(",",  "delimiter",                      SWITCHING,      (),               PART,   written, form="P output,length"),
    I("-",  "direction low",                  INDEX,          (),               PART,   written, form="X- Y- Z-"),
    I("/",  "linear interpolation",           INTERPOLATION,  (),               MOVE,   interpolation.minor_axis,            Order.MOVE, form="major axis/minor axis"),
    I(":",  "sequence divider",               SEQUENCE,       (),               PART,   written, form=":step:step:…:$"),
    I("<",  "start/stop speed",               START_STOP,     (START,),         DIRECT, partial(setting, "start_stop"),      Order.MOVE),
    I("=",  "repeat",                         REPEATS,        (TIMES, FIRST),   STEP,   sequence.repeat,                     Order.REPEAT),
    I(">",  "select speed range",             SPEED,          (RANGE,),         DIRECT, partial(setting, "speed_range"),     Order.MOVE),
    I("@",  "speed data",                     SPEED,          (RATE,),          MOVE,   partial(setting, "speed"),           Order.MOVE),
    I("A",  "abort in sequence mode",         ABORT,          (),               STEP,   run.abort,                           Order.ABORT),
    I("B",  "backlash",                       BACKLASH,       (PLAY,),          MOVE,   index.backlash,                      Order.MOVE, form="B[+distance|-distance]"),
    I("D",  "inter-character delay",          DELAY,          (PAUSE,),         DIRECT, partial(setting, "character_delay"), Order.MOVE),
    I("E",  "busy",                           BUSY,           (),               ASK,    report.busy_status),
    I("F",  "communication status",           STATUS,         (),               ASK,    report.communication_status),
    I("G",  "run mode",                       RUN,            (),               MOVE,   run.go,                              Order.MOVE, form="axis G"),
    I("H",  "input high",                     COMBINING,      (INPUTS,),        MOVE,   outputs.wait_high,                   Order.HIGH),
    I("I",  "input status",                   INPUT_STATUS,   (),               ASK,    report.input_status),
    I("K",  "motion status",                  STATUS,         (),               ASK,    report.motion_status),
    I("L",  "input low",                      COMBINING,      (INPUTS,),        MOVE,   outputs.wait_low,                    Order.LOW),
    I("N",  "number of steps run or indexed", POSITION,       (),               ASK,    report.position),
    I("O",  "sequence status",                SEQ_STATUS,     (),               ASK,    report.sequence_status),
    I("P",  "pulse output",                   SWITCHING,      (OUTPUT, LENGTH), MOVE,   outputs.pulse_output,                Order.PULSE),
    I("Q",  "quick status byte",              QUICK_STATUS,   (),               ASK,    report.quick_status),
    I("R",  "reset output low",               SWITCHING,      (OUTPUTS,),       MOVE,   outputs.reset_outputs,               Order.RESET),
    I("S",  "set output high",                SWITCHING,      (OUTPUTS,),       MOVE,   outputs.set_outputs,                 Order.SET),
    I("U",  "RS232 format, ended by <CR>",    INITIALISATION, FORMAT,           SETUP,  only_at_initialisation, form="U frame parity"),
    I("V",  "RS232 format, ended by <LF>",    INITIALISATION, FORMAT,           SETUP,  only_at_initialisation, form="V frame parity"),
    I("X",  "X clock",                        INDEX,          (SIGN, DISTANCE), MOVE,   partial(index.axis, "X"),            Order.MOVE),
    I("Y",  "Y clock",                        INDEX,          (SIGN, DISTANCE), MOVE,   partial(index.axis, "Y"),            Order.MOVE),
    I("Z",  "Z clock",                        INDEX,          (SIGN, DISTANCE), MOVE,   partial(index.axis, "Z"),            Order.MOVE),
    I("[",  "communication lock",             LOCKOUT,        (),               ALONE,  lockout.lock),
    I("]",  "communication unlock",           LOCKOUT,        (),               UNLOCK, lockout.unlock),
    I("^",  "acceleration rate data",         ACCELERATION,   (GAIN,),          DIRECT, partial(setting, "acceleration"),    Order.MOVE),
)
# fmt: on
