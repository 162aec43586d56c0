"""Command set of the 1810 and 1811, in the order of the manual's command summary.  One line, one opcode."""

from dataclasses import replace
from functools import partial

import axistwin.core.units as units
from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor.chapters import (
    closed_loop,
    events,
    home,
    joystick,
    moves,
    outputs,
    requests,
    selftest,
    sequence,
    stop,
    streaming,
)
from axistwin.controllers.compumotor.language import (
    Accept,
    DontCare,
    OneOf,
    Opcode,
    Ranges,
    StreamedVelocity,
    Switch,
    i16,
    i32,
    u8,
    u16,
    u32,
)
from axistwin.controllers.compumotor.options import Options
from axistwin.controllers.compumotor.parts.library import Kind
from axistwin.controllers.compumotor.parts.pulses import Phase

# Abbreviations for the attributes of commands in the command table
S, I, V, Q, C, W, D, E = Accept  # noqa: E741
ANY = I | V | Q | C | W
ASK = I | V | C | W

# Titles of chapters in the Compumotor manual
BITS, STICK, SHUTDOWN, SENSE = "Status bits and outputs", "Joystick", "Remote power shutdown", "Direction"
SEQ, POS, HOME, STREAM = "Sequence buffers", "Positions and moves", "Home", "Velocity-streaming mode"
MODE, STOP, ASKING, EVENT = "Modes", "Stop and kill", "Requests", "Interrupts"
DEFINE, LOOP, TEST = "Pre-defined moves", "Position tracking", "Test switch function"

# Parameters
TRIGGER = OneOf("trigger", low=1, high=6, choices=(1, 6))
ON, MESSAGE, DIRECTION = Switch("on"), Switch("message"), Switch("direction")
USER_BIT, OUTPUT = u8("bit", 0, 2), u8("output", 1, 2)
RANGES = Ranges("ranges")
VELOCITY, ACCELERATION = (
    i32("velocity", low=0, unit="units of range"),
    i32("acceleration", low=0, unit="units of range"),
)
DISTANCE, POSITION = i32("distance", low=-0x7FFF_FFFF, unit="pulses"), i32("position", unit="pulses")
ABSOLUTE = i32("position", low=-moves.FARTHEST_ABSOLUTE, high=moves.FARTHEST_ABSOLUTE, unit="pulses")
ENCODER_DISTANCE, ENCODER_POSITION = (i32(name, unit="encoder pulses") for name in ("distance", "position"))
MOVE, ANY_MOVE, SEQUENCE = u8("move", 1), u8("move"), u8("sequence", 1, 15)
COUNT, TIMES = u8("commands", 1), u16("times", 1)
BASE, FEW_BASES, DIVISOR = u8("base clock", 1, 9), u8("base clock", 1, 3), u8("divisor", 1, 16)
ALARM, RATE = u32("alarm", unit="bytes"), u16("update rate", 2, unit="ms")
SPEED_V = StreamedVelocity("velocity", "effective clock/65536", 0, 0xFFFF, size=2)
LENGTH_D = u16("distance", unit="pulses")
STEP_D = i16("distance", unit="pulses")
MOVE_HEAD = (MOVE, RANGES, VELOCITY, ACCELERATION)
ON_TRIGGER = (TRIGGER, ON, MESSAGE)
SEARCH = (Switch("active level"), Switch("edge"), u8("final speed", 1, 100, "%"), Switch("final direction"))
MARKER = (u16("marker", 1), u8("command"), u8("parameter 1"), u8("parameter 2"))

INTERRUPT, DEADBAND = 0x01, 0xB5
ENCODER_DEFINITIONS = (0x2F, 0xD4, 0xD5)

# Handlers of the commands that assign an action to a trigger input
by_trigger = partial(partial, stop.on_trigger)

# fmt: off
COMMANDS_1811 = CommandSet(
    Opcode(0x00, "null",                                      BITS,     (),                              ANY | D,       outputs.nothing),
    Opcode(0x01, "interrupt",                                 EVENT,    (u8("identifier"),),             ANY,           requests.interrupt),
    Opcode(0x08, "write user bits",                           BITS,     (u8("bits", 0, 7),),             ANY,           outputs.write_user_bits),
    Opcode(0x09, "set user bit",                              BITS,     (USER_BIT,),                     ANY,           partial(outputs.write_bit, True, 0)),
    Opcode(0x0A, "clear user bit",                            BITS,     (USER_BIT,),                     ANY,           partial(outputs.write_bit, False, 0)),
    Opcode(0x0B, "set output",                                BITS,     (OUTPUT,),                       ANY,           partial(outputs.write_bit, True, 2)),
    Opcode(0x0C, "clear output",                              BITS,     (OUTPUT,),                       ANY,           partial(outputs.write_bit, False, 2)),
    Opcode(0x0D, "write outputs",                             BITS,     (u8("bits"),),                   ANY,           outputs.write_outputs),
    Opcode(0x0F, "show state",                                BITS,     (u8("bit", 0, 4), u8("state"), Switch("active level")), ANY, outputs.show_state),
    Opcode(0x10, "disable joystick",                          STICK,    (),                              I | V | C,     joystick.disable_joystick),
    Opcode(0x11, "enable joystick",                           STICK,    (),                              S | I | V | Q, joystick.enable_joystick),
    Opcode(0x12, "remote power shutdown",                     SHUTDOWN, (ON,),                           I | V | Q,     joystick.shut_down),
    Opcode(0x13, "shutdown-in bit",                           SHUTDOWN, (ON,),                           I | V | Q,     joystick.enable_shutdown_input),
    Opcode(0x14, "sense of CW",                               SENSE,    (DIRECTION,),                    I | V | Q | C, joystick.set_direction_sense),
    Opcode(0x18, "position maintenance",                      LOOP,     (ON,),                           I | V | Q | W, closed_loop.maintain),
    Opcode(0x19, "end move on stall",                         LOOP,     (ON,),                           ANY,           closed_loop.end_on_stall),
    Opcode(0x20, "repeat",                                    SEQ,      (COUNT, TIMES),                  S | Q,         sequence.repeat),
    Opcode(0x21, "repeat until continue",                     SEQ,      (COUNT,),                        S | Q,         sequence.repeat),
    Opcode(0x28, "wait for continue",                         SEQ,      (MESSAGE,),                      S | Q,         sequence.wait_for_continue),
    Opcode(0x29, "wait milliseconds",                         SEQ,      (u32("time", 1, unit="ms"),),    S | Q,         partial(sequence.wait, units.MS)),
    Opcode(0x2A, "wait seconds",                              SEQ,      (u16("time", 1, unit="s"),),     S | Q,         partial(sequence.wait, units.S)),
    Opcode(0x2B, "wait minutes",                              SEQ,      (u16("time", 1, unit="min"),),   S | Q,         partial(sequence.wait, 60 * units.S)),
    Opcode(0x2C, "wait for trigger",                          SEQ,      (u8("trigger", 1, 6), Switch("level")), S | Q,  sequence.wait_for_trigger),
    Opcode(0x2E, "define absolute open-loop position",        POS,      (POSITION,),                     I | V | Q,     moves.define_position),
    Opcode(0x2F, "define absolute closed-loop position",      LOOP,     (ENCODER_POSITION,),             I | V | Q,     closed_loop.define_position),
    Opcode(0x30, "absolute zero here",                        POS,      (),                              I | V | C,     moves.define_zero),
    Opcode(0x31, "default velocity and acceleration",         POS,      (DontCare("don't care"), RANGES, VELOCITY, ACCELERATION), I | V | Q | C, moves.set_default),
    Opcode(0x32, "go on",                                     POS,      (DIRECTION,),                    S | I | Q,     moves.go_on),
    Opcode(0x33, "go relative",                               POS,      (DISTANCE,),                     S | I | V | Q, moves.go_relative),
    Opcode(0x34, "go absolute",                               POS,      (ABSOLUTE,),                     S | I | V | Q, moves.go_absolute),
    Opcode(0x35, "go relative, encoder",                      LOOP,     (ENCODER_DISTANCE,),             S | I | V | Q | E, partial(closed_loop.go, Kind.RELATIVE_ENCODER)),
    Opcode(0x36, "go absolute, encoder",                      LOOP,     (ENCODER_POSITION,),             S | I | V | Q | E, partial(closed_loop.go, Kind.ABSOLUTE_ENCODER)),
    Opcode(0x37, "resume stopped closed-loop move",           LOOP,     (),                              S | I | V | Q | E, closed_loop.resume),
    Opcode(0x38, "define home",                               HOME,     SEARCH,                          I | V | Q | W, home.define_home),
    Opcode(0x39, "go home",                                   HOME,     (DIRECTION,),                    S | I | V | Q, home.go_home),
    Opcode(0x3A, "go encoder home",                           HOME,     (DIRECTION,),                    S | I | V | Q | E, home.go_encoder_home),
    Opcode(0x40, "perform move",                              DEFINE,   (u8("move", 1, 0x32),),          S | I | Q,     moves.perform_move),
    Opcode(0x41, "perform sequence",                          SEQ,      (SEQUENCE,),                     I,             sequence.perform),
    Opcode(0x42, "perform streaming buffer",                  STREAM,   (),                              V,             streaming.perform),
    Opcode(0x48, "continue",                                  SEQ,      (),                              ASK,           sequence.go_on),
    Opcode(0x50, "indexer mode",                              MODE,     (),                              I | V,         streaming.indexer_mode),
    Opcode(0x51, "velocity-distance streaming mode",          STREAM,   (BASE, DIVISOR, ALARM),          I | V,         partial(streaming.enter, 0x51)),
    Opcode(0x52, "velocity-time streaming mode",              STREAM,   (BASE, DIVISOR, ALARM, RATE),    I | V,         partial(streaming.enter, 0x52)),
    Opcode(0x53, "distance-time streaming mode",              STREAM,   (FEW_BASES, DIVISOR, ALARM, RATE), I | V,       partial(streaming.enter, 0x53)),
    Opcode(0x70, "stop",                                      STOP,     (),                              ASK,           stop.stop_motion),
    Opcode(0x71, "discontinue sequence",                      STOP,     (),                              I | C,         stop.discontinue_sequence),
    Opcode(0x72, "suspend sequence",                          STOP,     (),                              I | C,         stop.suspend_sequence),
    Opcode(0x73, "discontinue singular command",              STOP,     (),                              I | V | C,     stop.discontinue_singular),
    Opcode(0x74, "stop on trigger",                           STOP,     ON_TRIGGER,                      ANY,           by_trigger(0x74, stop.stop_motion)),
    Opcode(0x75, "discontinue sequence on trigger",           STOP,     ON_TRIGGER,                      I | Q | C,     by_trigger(0x75, stop.discontinue_sequence)),
    Opcode(0x76, "suspend sequence on trigger",               STOP,     ON_TRIGGER,                      I | Q | C,     by_trigger(0x76, stop.suspend_sequence)),
    Opcode(0x77, "discontinue singular command on trigger",   STOP,     ON_TRIGGER,                      I | V | Q | C, by_trigger(0x77, stop.discontinue_singular)),
    Opcode(0x78, "kill motion",                               STOP,     (),                              ASK,           stop.kill_motion),
    Opcode(0x79, "kill sequence",                             STOP,     (),                              I | C,         stop.kill_sequence),
    Opcode(0x7A, "kill singular command and suspend",         STOP,     (),                              I | C,         stop.kill_and_suspend),
    Opcode(0x7B, "kill streaming buffer",                     STREAM,   (),                              V | W,         streaming.kill_buffer),
    Opcode(0x7C, "kill motion on trigger",                    STOP,     ON_TRIGGER,                      ANY,           by_trigger(0x7C, stop.kill_motion)),
    Opcode(0x7D, "kill sequence on trigger",                  STOP,     ON_TRIGGER,                      I | Q | C,     by_trigger(0x7D, stop.kill_sequence)),
    Opcode(0x7E, "kill singular and suspend on trigger",      STOP,     ON_TRIGGER,                      I | Q | C,     by_trigger(0x7E, stop.kill_and_suspend)),
    Opcode(0x7F, "kill streaming buffer on trigger",          STREAM,   ON_TRIGGER,                      V | W,         by_trigger(0x7F, streaming.kill_buffer)),
    Opcode(0x80, "position from start of move",               ASKING,   (),                              ASK,           requests.from_start),
    Opcode(0x81, "position from end of move",                 ASKING,   (),                              ASK,           requests.from_end),
    Opcode(0x82, "position from home",                        ASKING,   (),                              ASK,           requests.from_home),
    Opcode(0x83, "position from absolute zero",               ASKING,   (),                              ANY,           requests.from_zero),
    Opcode(0x84, "direction",                                 ASKING,   (),                              ASK,           requests.direction),
    Opcode(0x85, "velocity",                                  ASKING,   (),                              ASK,           requests.velocity),
    Opcode(0x86, "acceleration",                              ASKING,   (),                              I | V | C,     requests.acceleration),
    Opcode(0x88, "move status",                               ASKING,   (),                              ASK,           requests.status),
    Opcode(0x89, "limits",                                    ASKING,   (),                              ASK,           requests.limits),
    Opcode(0x8A, "home switch",                               ASKING,   (),                              ASK,           requests.home_switch),
    Opcode(0x8B, "direction of travel",                       ASKING,   (),                              ASK,           requests.direction),
    Opcode(0x8C, "moving",                                    ASKING,   (),                              ASK,           requests.moving),
    Opcode(0x8D, "at constant velocity",                      ASKING,   (),                              I | V | C,     partial(requests.in_phase, Phase.CONSTANT)),
    Opcode(0x8E, "accelerating",                              ASKING,   (),                              I | V | C,     partial(requests.in_phase, Phase.ACCELERATING)),
    Opcode(0x8F, "decelerating",                              ASKING,   (),                              I | V | C,     partial(requests.in_phase, Phase.DECELERATING)),
    Opcode(0x90, "mode",                                      ASKING,   (),                              ASK,           requests.mode),
    Opcode(0x91, "move parameters",                           ASKING,   (ANY_MOVE,),                     I | V | C,     requests.move_parameters),
    Opcode(0x92, "list sequence",                             SEQ,      (SEQUENCE,),                     S | I,         sequence.list_commands),
    Opcode(0x93, "moves calculated",                          ASKING,   (),                              I | C,         requests.crunched),
    Opcode(0x94, "triggers",                                  ASKING,   (),                              ASK,           requests.triggers),
    Opcode(0x95, "joystick request",                          STICK,    (),                              ASK,           joystick.request_joystick),
    Opcode(0x96, "channel Z",                                 LOOP,     (),                              ASK,           requests.channel_z),
    Opcode(0x97, "outputs",                                   ASKING,   (),                              ASK,           outputs.request_outputs),
    Opcode(0x98, "relative encoder count",                    LOOP,     (),                              ASK,           closed_loop.relative_count),
    Opcode(0x99, "closed-loop error",                         LOOP,     (),                              ASK,           closed_loop.error),
    Opcode(0x9A, "absolute encoder count",                    LOOP,     (),                              ASK,           closed_loop.absolute_count),
    Opcode(0x9B, "slip status",                               LOOP,     (),                              ASK,           closed_loop.slip),
    Opcode(0x9C, "ratio",                                     LOOP,     (),                              ASK,           closed_loop.ratio),
    Opcode(0x9D, "motor resolution",                          LOOP,     (),                              ASK,           closed_loop.resolution),
    Opcode(0x9E, "backlash sigma",                            LOOP,     (),                              ASK,           closed_loop.sigma),
    Opcode(0x9F, "position maintenance parameters",           LOOP,     (),                              ASK,           closed_loop.law),
    Opcode(0xA0, "interrupt at next start of move",           EVENT,    (ON,),                           I | Q | C,     partial(events.arm, 0xA0)),
    Opcode(0xA1, "interrupt at every start of move",          EVENT,    (ON,),                           I | Q | C,     partial(events.arm, 0xA1)),
    Opcode(0xA2, "interrupt at next constant velocity",       EVENT,    (ON,),                           I | Q | C,     partial(events.arm, 0xA2)),
    Opcode(0xA3, "interrupt at every constant velocity",      EVENT,    (ON,),                           I | Q | C,     partial(events.arm, 0xA3)),
    Opcode(0xA4, "interrupt at next end of motion",           EVENT,    (ON,),                           I | Q | C,     partial(events.arm, 0xA4)),
    Opcode(0xA5, "interrupt at every end of motion",          EVENT,    (ON,),                           I | Q | C,     partial(events.arm, 0xA5)),
    Opcode(0xA6, "interrupt at next stall",                   EVENT,    (ON,),                           ANY,           partial(events.arm, 0xA6)),
    Opcode(0xA7, "interrupt at every stall",                  EVENT,    (ON,),                           ANY,           partial(events.arm, 0xA7)),
    Opcode(0xA8, "interrupt at next hit of + limit",          EVENT,    (ON,),                           ANY,           partial(events.arm, 0xA8)),
    Opcode(0xA9, "interrupt at every hit of + limit",         EVENT,    (ON,),                           ANY,           partial(events.arm, 0xA9)),
    Opcode(0xAA, "interrupt at next hit of - limit",          EVENT,    (ON,),                           ANY,           partial(events.arm, 0xAA)),
    Opcode(0xAB, "interrupt at every hit of - limit",         EVENT,    (ON,),                           ANY,           partial(events.arm, 0xAB)),
    Opcode(0xAC, "interrupt on trigger",                      EVENT,    (TRIGGER, ON),                   ANY,           stop.interrupt_on_trigger),
    Opcode(0xAF, "inhibit interrupts",                        EVENT,    (),                              ANY,           events.inhibit),
    Opcode(0xB0, "ratio of motor to encoder pulses",          LOOP,     (u16("motor pulses", 1), u16("encoder pulses", 1)), ANY, closed_loop.set_ratio),
    Opcode(0xB1, "define motor resolution",                   LOOP,     (u32("resolution", high=0xFFFF, unit="pulses/rev"),), ANY, closed_loop.set_resolution),
    Opcode(0xB2, "define backlash sigma",                     LOOP,     (i32("sigma", low=0, unit="motor steps"),), ANY, closed_loop.set_sigma),
    Opcode(0xB3, "define maintenance algorithm",              LOOP,     (u8("algorithm", 1, 3), u8("constant"), u8("velocity range", 0x00, 0x5F), i32("maximum velocity", low=0, unit="units of range")), ANY, closed_loop.set_law),
    Opcode(0xB4, "define rotor teeth",                        LOOP,     (u32("teeth", high=0xFFFF),),    ANY,           closed_loop.set_teeth),
    Opcode(0xB5, "define deadband",                           LOOP,     (DontCare("don't care", size=2), u16("deadband", unit="encoder pulses")), ANY | E, closed_loop.set_deadband),
    Opcode(0xC8, "define relative move",                      DEFINE,   (*MOVE_HEAD, DISTANCE),          I | Q | C,     partial(moves.define, Kind.RELATIVE)),
    Opcode(0xCB, "define absolute move",                      DEFINE,   (*MOVE_HEAD, ABSOLUTE),          I | Q | C,     partial(moves.define, Kind.ABSOLUTE)),
    Opcode(0xCE, "define continuous move",                    DEFINE,   (*MOVE_HEAD, u8("direction")),   I | Q | C,     partial(moves.define, Kind.CONTINUOUS)),
    Opcode(0xD4, "define relative closed-loop move",          LOOP,     (*MOVE_HEAD, ENCODER_DISTANCE),  I | Q | C,     partial(moves.define, Kind.RELATIVE_ENCODER)),
    Opcode(0xD5, "define absolute closed-loop move",          LOOP,     (*MOVE_HEAD, ENCODER_POSITION),  I | Q | C,     partial(moves.define, Kind.ABSOLUTE_ENCODER)),
    Opcode(0xD6, "start/stop velocity",                       DEFINE,   (i32("velocity", low=0, unit="pulses/s"),), ASK, moves.set_start_stop),
    Opcode(0xD7, "delete move",                               DEFINE,   (MOVE,),                         I | Q | C,     moves.delete),
    Opcode(0xD8, "end sequence definition",                   SEQ,      (),                              I | D,         sequence.finish),
    Opcode(0xD9, "begin sequence definition",                 SEQ,      (SEQUENCE,),                     S | I,         sequence.begin),
    Opcode(0xDA, "delete sequence",                           SEQ,      (SEQUENCE,),                     S | I,         sequence.delete),
    Opcode(0xE0, "velocity-distance data",                    STREAM,   (SPEED_V, LENGTH_D) * 3,         V | W,         streaming.velocity_distance),
    Opcode(0xE1, "velocity-time data",                        STREAM,   (SPEED_V,) * 7,                  V | W,         streaming.velocity_time),
    Opcode(0xE2, "free bytes",                                ASKING,   (),                              ASK,           requests.free_bytes),
    Opcode(0xE3, "distance-time data",                        STREAM,   (u8("count", 1, 7), *(STEP_D,) * 7), V | W,     streaming.distance_time),
    Opcode(0xEE, "define marker",                             STREAM,   MARKER,                          V | W,         streaming.define_marker),
    Opcode(0xFD, "part number",                               ASKING,   (),                              ASK,           requests.part_number),
    Opcode(0xFE, "reserved (self-test report)",               TEST,     (),                              Accept(0),     outputs.nothing),
    Opcode(0xFF, "test switch function",                      TEST,     (),                              ASK | D,       selftest.test_switch),
)
# fmt: on

COMMANDS_1810 = COMMANDS_1811.without(*(c.code for c in COMMANDS_1811 if Accept.ENCODER in c.accepted))
"""Commands of the 1810: the same software without an encoder, which ignores B5h and encoder moves."""


def installed(commands: CommandSet, options: Options) -> CommandSet:
    """Return the commands of a board with the options `encoder_commands` (1810 only) and `interrupt_command`."""
    if commands is COMMANDS_1810:
        if options.encoder_commands == "performed":
            commands = COMMANDS_1811.without(DEADBAND)
        elif options.encoder_commands == "ignored":
            commands = commands.without(*ENCODER_DEFINITIONS)
    if options.interrupt_command == "printed":
        commands = commands.with_(*(replace(c, accepted=I | V) for c in commands if c.code == INTERRUPT))
    return commands
