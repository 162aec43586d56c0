"""The command table of the SmartMotor with firmware 4.76, one command per line.

The order is that of the guide to the base language; after each chapter come the additions of 4.76.  The code of a
command is its keyword with the characters that must follow: `G`, `A=`, `GOSUBn`, `PRINT()`.
"""

from functools import partial

from axistwin.controllers.commandset import CommandSet, Field
from axistwin.controllers.smartmotor.chapters import (
    brakes,
    eeprom,
    faults,
    flow,
    functions,
    io,
    limits,
    modes,
    reports,
    variables,
)
from axistwin.controllers.smartmotor.kernel import state
from axistwin.controllers.smartmotor.kernel.interpreter import HIGHEST, LOWEST
from axistwin.controllers.smartmotor.language.forms import Accept, Form, Instruction
from axistwin.controllers.smartmotor.serial import program_store, serial_data

# Sources of commands, e.g. the host or a program
BOTH, BLOCK, GONE = Accept.HOST | Accept.PROGRAM, Accept.BLOCK, Accept.REMOVED
INSIDE, HOST = Accept.PROGRAM, Accept.HOST

# A chapter title with a number, e.g. "7.0 F=", is from the manual of firmware 4.76.
# A chapter title without a number, e.g. "Modes", is from one of the user's guides of the SmartMotor.
MOTION, MODES, VARIABLES, FLOW = "Motion parameters", "Modes", "Variables", "Program flow"
REPORTS, STATUS, PINS, TUNING = "Reports", "Status word", "Inputs and outputs", "PID filter"
BRAKES, STORAGE, EEPROM, SERIAL, ANILINK = "Brakes", "Program storage", "EEPROM", "Communications", "AniLink"
HOST_MODE, PRINTING = "Host mode", "Reports"
ADDED, REMOVED, EQUAL = "1.1 Features added", "1.3 Commands removed", "8.1 Forced equal sign"
HARD, SOFT, FAULTS, CLEARING = "3.1 Hardware limits", "3.2 Software limits", "4.3 Fault handling", "4.2 Clearing fault"
BRAKE, DYNAMIC, IO, DIGITAL, ANALOG = (
    "5.1 Brake commands", "5.2 Dynamic braking", "6.1 I/O commands", "6.2 Reporting digital I/O",
    "6.3 Reporting analog I/O",
)  # fmt: skip
F_WORD, ARRAYS, CAM, ON_THE_FLY = "7.0 F=", "8.2 Arrays", "9.1 Mode cam", "9.5 On-the-fly changes"

# Parameters of the commands
LABEL, CONSTANT = Field("label", "", 0, 999), Field("constant", "", LOWEST, HIGHEST)
ADDRESS, RATE, PID_RATE = Field("address", "", 0, 120), Field("rate", "bit/s", 2400, 38400), Field("samples", "", 1, 8)
SAMPLES, CONDITION = Field("samples", "", LOWEST, HIGHEST), Field("condition")
COUNTS, ANY = Field("position", "counts", LOWEST, HIGHEST), Field("value", "", LOWEST, HIGHEST)
DISTANCE, TICKS = Field("distance or dwell", "counts", LOWEST, HIGHEST), Field("clock", "samples", LOWEST, HIGHEST)
GAIN = Field("acceleration", "1/65536 count/sample²", 0, HIGHEST)
SPEED = Field("speed", "1/65536 count/sample", LOWEST, HIGHEST)
TORQUE, CEILING = Field("torque", "1/1023", -1023, 1023), Field("PWM", "1/1023", 0, 1023)
ERROR, HOT, HOT_TIME = (
    Field("error", "counts", 0, 32000),
    Field("temperature", "°C", 0, 150),
    Field("time", "samples", 0, 65535),
)
RATIO = Field("ratio", "", -32768, 32767)
CYCLE, HIGHEST_INDEX = Field("cycle", "master counts", 0, HIGHEST), Field("highest index", "", 0, 101)
TUNED, SPACED = Field("value", "", 0, 65535), Field("spacing", "samples", 1, 255)
SWITCHES, LEVEL, POINTER = (
    Field("functions", "", 0, 255),
    Field("level", "", LOWEST, HIGHEST),
    Field("address", "bytes", 0),
)
ITEMS, OPENING, CLOSING = (
    Field('"text", exp, #byte, …'),
    Field("type,channel,parity,baud,stop,data,mode"),
    Field("type,channel"),
)
FIRST, MANY, INDEX = Field("variable"), Field("number", "", 1), Field("index", "", 0, 203)
DEVICE, CHANNEL = Field("device A…H"), Field("channel", "", 0, 63)


def kept(slot: int, field: Field) -> partial[None]:
    """Return a handler that stores a parameter in a slot, within the range of its field."""
    assert field.low is not None and field.high is not None
    return partial(modes.parameter, slot=slot, low=field.low, high=field.high)


I = Instruction  # noqa: E741  # one letter, so that the table's columns fit
N, L, X, P, C = Form.NUMBER, Form.LET, Form.AFTER, Form.ITEMS, Form.CALL

# fmt: off
COMMANDS = CommandSet(
    # Commands for communication
    I("SADDRn",    "set address",                        SERIAL,   (ADDRESS,),      BOTH,   serial_data.address,                                   N),
    I("ECHO",      "echo on, channel 0",                 SERIAL,   (),              BOTH,   serial_data.echo),
    I("ECHO_OFF",  "echo off, channel 0",                SERIAL,   (),              BOTH,   serial_data.echo_off),
    I("ECHO1",     "echo on, channel 1",                 SERIAL,   (),              BOTH,   partial(serial_data.echo, channel=1)),
    I("ECHO_OFF1", "echo off, channel 1",                SERIAL,   (),              BOTH,   partial(serial_data.echo_off, channel=1)),
    I("SLEEP",     "ignore channel 0",                   SERIAL,   (),              BOTH,   serial_data.sleep),
    I("WAKE",      "obey channel 0 again",               SERIAL,   (),              BOTH,   serial_data.wake),
    I("SLEEP1",    "ignore channel 1",                   SERIAL,   (),              BOTH,   partial(serial_data.sleep, channel=1)),
    I("WAKE1",     "obey channel 1 again",               SERIAL,   (),              BOTH,   partial(serial_data.wake, channel=1)),
    I("SILENT",    "program says nothing, channel 0",    SERIAL,   (),              BOTH,   serial_data.silent),
    I("TALK",      "program speaks again, channel 0",    SERIAL,   (),              BOTH,   serial_data.talk),
    I("SILENT1",   "program says nothing, channel 1",    SERIAL,   (),              BOTH,   partial(serial_data.silent, channel=1)),
    I("TALK1",     "program speaks again, channel 1",    SERIAL,   (),              BOTH,   partial(serial_data.talk, channel=1)),
    I("BAUDn",     "baud rate",                          SERIAL,   (RATE,),         BOTH,   serial_data.baud,                                      N),
    I("OCHN()",    "open channel",                       SERIAL,   (OPENING,),      BOTH,   serial_data.open_channel,                              C, "OCHN(type,channel,parity,baud,stop,data,mode)"),
    I("CCHN()",    "close channel",                      SERIAL,   (CLOSING,),      BOTH,   serial_data.close_channel,                             C, "CCHN(type,channel)"),
    I("RS4",       "channel 0 is RS-485, with pin G",    SERIAL,   (),              BOTH,   serial_data.rs4),
    I("RS2",       "channel 0 is RS-232",                SERIAL,   (),              BOTH,   serial_data.rs2),

    # Commands for motion and motion parameters
    I("A=",        "acceleration",                       MOTION,   (GAIN,),         BOTH,   kept(state.A, GAIN),                                   L),
    I("V=",        "velocity",                           MOTION,   (SPEED,),        BOTH,   kept(state.V, SPEED),                                  L),
    I("P=",        "absolute position",                  MOTION,   (COUNTS,),       BOTH,   modes.position,                                        L),
    I("D=",        "relative distance; cam: dwell",      MOTION,   (DISTANCE,),     BOTH,   modes.distance,                                        L),
    I("G",         "go",                                 MOTION,   (),              BOTH,   modes.go),
    I("S",         "stop abruptly",                      MOTION,   (),              BOTH,   modes.stop),
    I("X",         "decelerate to a stop",               MOTION,   (),              BOTH,   modes.decelerate),
    I("O=",        "origin: this is position exp",       MOTION,   (COUNTS,),       BOTH,   modes.origin,                                          L),
    I("OFF",       "servo off",                          MOTION,   (),              BOTH,   modes.off),
    I("T=",        "torque",                             MOTION,   (TORQUE,),       BOTH,   kept(state.T, TORQUE),                                 L),
    I("E=",        "allowable position error",           MOTION,   (ERROR,),        BOTH,   kept(state.E, ERROR),                                  L),
    I("AMPS=",     "PWM limit",                          MOTION,   (CEILING,),      BOTH,   kept(state.AMPS, CEILING),                             L),
    I("TH=",       "temperature limit",                  MOTION,   (HOT,),          BOTH,   kept(state.TH, HOT),                                   L),
    I("THD=",      "time allowed too hot",               MOTION,   (HOT_TIME,),     BOTH,   kept(state.THD, HOT_TIME),                             L),
    I("CLK=",      "sample counter",                     MOTION,   (TICKS,),        BOTH,   modes.clock,                                           L),

    # Commands for modes of motion, e.g. cam mode
    I("MP",        "mode position",                      MODES,    (),              BOTH,   partial(modes.buffer, mode=state.M_POSITION)),
    I("MV",        "mode velocity",                      MODES,    (),              BOTH,   partial(modes.buffer, mode=state.M_VELOCITY)),
    I("MT",        "mode torque",                        MODES,    (),              BOTH,   modes.torque),
    I("MF0",       "encoder input, mode unchanged",      MODES,    (),              BOTH,   modes.quadrature),
    I("MF1",       "mode follow, quadrature x 1",        MODES,    (),              BOTH,   partial(modes.follow, factor=1)),
    I("MF2",       "mode follow, quadrature x 2",        MODES,    (),              BOTH,   partial(modes.follow, factor=2)),
    I("MF4",       "mode follow, quadrature x 4",        MODES,    (),              BOTH,   partial(modes.follow, factor=4)),
    I("MFR",       "mode follow with ratio",             MODES,    (),              BOTH,   partial(modes.buffer, mode=state.M_RATIO)),
    I("MFMUL=",    "ratio: multiplier",                  MODES,    (RATIO,),        BOTH,   kept(state.MFMUL, RATIO),                              L),
    I("MFDIV=",    "ratio: divisor",                     MODES,    (RATIO,),        BOTH,   kept(state.MFDIV, RATIO),                              L),
    I("MS",        "mode step and direction",            MODES,    (),              BOTH,   modes.step_and_direction),
    I("MS0",       "step input, mode unchanged",         MODES,    (),              BOTH,   modes.count_steps),
    I("MSR",       "mode step with ratio",               MODES,    (),              BOTH,   partial(modes.buffer, mode=state.M_STEP_RATIO)),
    I("MC",        "mode cam",                           CAM,      (),              BOTH,   partial(modes.cam, factor=1)),
    I("MC2",       "mode cam, pulses x 2",               CAM,      (),              BOTH,   partial(modes.cam, factor=2)),
    I("MC4",       "mode cam, pulses x 4",               CAM,      (),              BOTH,   partial(modes.cam, factor=4)),
    I("MC8",       "mode cam, pulses x 8",               CAM,      (),              BOTH,   partial(modes.cam, factor=8)),
    I("BASE=",     "master counts per cam cycle",        CAM,      (CYCLE,),        BOTH,   kept(state.BASE, CYCLE),                               L),
    I("SIZE=",     "highest index of the cam table",     CAM,      (HIGHEST_INDEX,), BOTH,  kept(state.SIZE, HIGHEST_INDEX),                       L),
    I("CI",        "use new cam parameters",             ON_THE_FLY, (),            BOTH,   modes.initialize_cam),
    I("MD",        "mode host: positions and times",     HOST_MODE, (),             BOTH,   partial(modes.buffer, mode=state.M_HOST)),
    I("Q",         "host mode status",                   HOST_MODE, (),             BOTH,   serial_data.query),
    I("MTB",       "mode torque brake",                  DYNAMIC,  (),              BOTH,   brakes.mode_torque_brake),
    I("ENC0",      "servo from the internal encoder",    MODES,    (),              BOTH,   modes.internal_encoder),
    I("ENC1",      "servo from the external encoder",    MODES,    (),              BOTH,   modes.external_encoder),

    # Commands for limit switches and software limits
    I("UCP",       "pin C is the positive limit",        HARD,     (),              BOTH,   limits.limit_pin_c),
    I("UDM",       "pin D is the negative limit",        HARD,     (),              BOTH,   limits.limit_pin_d),
    I("LIMD",      "limits are directional, as always",  HARD,     (),              BOTH,   limits.directional),
    I("SLE",       "enable software limits",             SOFT,     (),              BOTH,   limits.enable_soft),
    I("SLD",       "disable software limits",            SOFT,     (),              BOTH,   limits.disable_soft),
    I("SLN=",      "negative software limit",            SOFT,     (COUNTS,),       BOTH,   limits.soft_negative,                                  L),
    I("SLP=",      "positive software limit",            SOFT,     (COUNTS,),       BOTH,   limits.soft_positive,                                  L),

    # Commands that assign values to variables and arrays
    I("a…zzz=",    "variable a…z, aa…zz, aaa…zzz",       EQUAL,    (ANY,),          BOTH,   variables.assign,                                      Form.VARIABLE, "a=exp"),
    I("ab[]=",     "bytes 0…203",                        ARRAYS,   (INDEX, ANY),    BOTH,   variables.assign_elements,                             Form.ARRAY, "ab[exp]=exp"),
    I("aw[]=",     "words 0…101",                        ARRAYS,   (INDEX, ANY),    BOTH,   variables.assign_elements,                             Form.ARRAY, "aw[exp]=exp"),
    I("al[]=",     "longs 0…50",                         ARRAYS,   (INDEX, ANY),    BOTH,   variables.assign_elements,                             Form.ARRAY, "al[exp]=exp"),
    I("EPTR=",     "EEPROM pointer",                     EEPROM,   (POINTER,),      BOTH,   eeprom.pointer,                                        L),
    I("VST()",     "store variables in the EEPROM",      EEPROM,   (FIRST, MANY),   BOTH,   eeprom.store_variables,                                C, "VST(variable,number)"),
    I("VLD()",     "load variables from the EEPROM",     EEPROM,   (FIRST, MANY),   BOTH,   eeprom.load_variables,                                 C, "VLD(variable,number)"),

    # Commands for program flow
    I("Cn",        "label",                              FLOW,     (LABEL,),        BLOCK,  flow.part_of_block,                                    N),
    I("GOTOn",     "go on at label",                     FLOW,     (LABEL,),        BOTH,   flow.goto,                                             N),
    I("GOSUBn",    "call subroutine",                    FLOW,     (LABEL,),        BOTH,   flow.gosub,                                            N),
    I("RETURN",    "return from subroutine",             FLOW,     (),              BOTH,   flow.return_),
    I("RETURNF",   "return from C1 after a fault",       F_WORD,   (),              BOTH,   flow.return_fault),
    I("RETURNI",   "return from C2 after an input",      F_WORD,   (),              BOTH,   flow.return_interrupt),
    I("STACK",     "forget all return addresses",        F_WORD,   (),              BOTH,   flow.stack),
    I("IF",        "if",                                 FLOW,     (CONDITION,),    BLOCK,  flow.part_of_block,                                    X),
    I("ELSEIF",    "else if",                            FLOW,     (CONDITION,),    BLOCK,  flow.part_of_block,                                    X),
    I("ELSE",      "else",                               FLOW,     (),              BLOCK,  flow.part_of_block),
    I("ENDIF",     "end of IF",                          FLOW,     (),              BLOCK,  flow.part_of_block),
    I("WHILE",     "while",                              FLOW,     (CONDITION,),    BLOCK,  flow.part_of_block,                                    X),
    I("LOOP",      "end of WHILE",                       FLOW,     (),              BLOCK,  flow.part_of_block),
    I("SWITCH",    "choose among cases",                 FLOW,     (ANY,),          BLOCK,  flow.part_of_block,                                    X),
    I("CASE",      "case",                               FLOW,     (CONSTANT,),     BLOCK,  flow.part_of_block,                                    X),
    I("DEFAULT",   "in all other cases",                 FLOW,     (),              BLOCK,  flow.part_of_block),
    I("BREAK",     "leave SWITCH or WHILE",              FLOW,     (),              BLOCK,  flow.part_of_block),
    I("ENDS",      "end of SWITCH",                      FLOW,     (),              BLOCK,  flow.part_of_block),
    I("END",       "end the program",                    FLOW,     (),              BOTH,   flow.end),
    I("RUN",       "start the stored program",           FLOW,     (),              BOTH,   flow.run),
    I("RUN?",      "end here unless RUN was given",      FLOW,     (),              INSIDE, flow.run_wait),
    I("WAIT=",     "wait",                               FLOW,     (SAMPLES,),      INSIDE, flow.wait,                                             L),
    I("TWAIT",     "wait for the trajectory's end",      FLOW,     (),              INSIDE, flow.twait),
    I("!",         "pause until a character arrives",    FLOW,     (),              INSIDE, flow.pause),
    I("Z",         "total reset",                        FLOW,     (),              BOTH,   flow.reset),

    # Commands that clear status flags, and the command F=, which switches functions of the motor on or off
    I("ZS",        "clear all flags",                    CLEARING, (),              BOTH,   faults.clear_all),
    I("Zr",        "clear Br, positive limit",           CLEARING, (),              BOTH,   partial(faults.clear, slot=state.BR)),
    I("Zl",        "clear Bl, negative limit",           CLEARING, (),              BOTH,   partial(faults.clear, slot=state.BL)),
    I("Ze",        "clear Be, position error",           CLEARING, (),              BOTH,   partial(faults.clear, slot=state.BE)),
    I("Zh",        "clear Bh, overheat",                 CLEARING, (),              BOTH,   partial(faults.clear, slot=state.BH)),
    I("Zw",        "clear Bw, wrap",                     STATUS,   (),              BOTH,   partial(faults.clear, slot=state.BW)),
    I("Zd",        "clear Bd, math overflow",            STATUS,   (),              BOTH,   partial(faults.clear, slot=state.BD)),
    I("Zu",        "clear Bu, array index",              STATUS,   (),              BOTH,   partial(faults.clear, slot=state.BU)),
    I("Zs",        "clear Bs, syntax error",             STATUS,   (),              BOTH,   partial(faults.clear, slot=state.BS)),
    I("Za",        "clear Ba, overcurrent",              STATUS,   (),              BOTH,   partial(faults.clear, slot=state.BA)),
    I("Zb",        "clear Bb, parity error",             STATUS,   (),              BOTH,   partial(faults.clear, slot=state.BB)),
    I("Zc",        "clear Bc, communications overflow",  STATUS,   (),              BOTH,   partial(faults.clear, slot=state.BC)),
    I("Zf",        "clear Bf, framing error",            STATUS,   (),              BOTH,   partial(faults.clear, slot=state.BF)),
    I("F=",        "functions",                          F_WORD,   (SWITCHES,),     BOTH,   functions.functions,                                   L),

    # Commands for inputs, outputs and brakes
    *(I(f"U{pin}I", f"pin {pin} is an input",            PINS,     (),              BOTH,   partial(io.direction_in, pin=pin)) for pin in state.USER_PINS),
    *(I(f"U{pin}O", f"pin {pin} is an output",           PINS,     (),              BOTH,   partial(io.direction_out, pin=pin)) for pin in state.USER_PINS),
    *(I(f"U{pin}=", f"output latch of pin {pin}",        PINS,     (LEVEL,),        BOTH,   partial(io.latch, pin=pin),                            L) for pin in state.USER_PINS),
    I("UG",        "pin G goes on its falling edge",     PINS,     (),              BOTH,   io.go_pin),
    I("AOUTp",     "analog output of an AniLink device", ANILINK,  (DEVICE, ANY),   BOTH,   io.analog_out,                                         Form.OUTPUT, "AOUTp,exp"),
    I("DOUTp",     "output of an AniLink device",        ANILINK,  (DEVICE, CHANNEL, ANY), BOTH, io.digital_out,                                   Form.OUTPUT, "DOUTpc,exp"),
    I("BRKRLS",    "release the brake",                  BRAKES,   (),              BOTH,   brakes.release),
    I("BRKENG",    "engage the brake",                   BRAKES,   (),              BOTH,   brakes.engage),
    I("BRKSRV",    "brake released while servo is on",   BRAKES,   (),              BOTH,   brakes.servo),
    I("BRKTRJ",    "brake released during trajectory",   BRAKES,   (),              BOTH,   brakes.trajectory_brake),
    I("BRKI",      "brake signal inside only",           BRAKE,    (),              BOTH,   brakes.internal),
    I("BRKC",      "brake signal on pin C too",          BRAKE,    (),              BOTH,   brakes.pin_c),
    I("BRKG",      "brake signal on pin G too",          BRAKE,    (),              BOTH,   brakes.pin_g),

    # Commands for the PID filter
    I("KP=",       "proportional coefficient",           TUNING,   (TUNED,),        BOTH,   kept(state.KP, TUNED),                                 L),
    I("KI=",       "integral coefficient",               TUNING,   (TUNED,),        BOTH,   kept(state.KI, TUNED),                                 L),
    I("KD=",       "derivative coefficient",             TUNING,   (TUNED,),        BOTH,   kept(state.KD, TUNED),                                 L),
    I("KL=",       "integral limit",                     TUNING,   (TUNED,),        BOTH,   kept(state.KL, TUNED),                                 L),
    I("KS=",       "derivative sampling",                TUNING,   (SPACED,),       BOTH,   kept(state.KS, SPACED),                                L),
    I("KV=",       "velocity feed-forward",              TUNING,   (TUNED,),        BOTH,   kept(state.KV, TUNED),                                 L),
    I("KA=",       "acceleration feed-forward",          TUNING,   (TUNED,),        BOTH,   kept(state.KA, TUNED),                                 L),
    I("KG=",       "gravity offset",                     TUNING,   (TUNED,),        BOTH,   kept(state.KG, TUNED),                                 L),
    I("F",         "use the new coefficients",           TUNING,   (),              BOTH,   modes.tune),
    I("PIDn",      "servo law every n samples",          TUNING,   (PID_RATE,),     BOTH,   modes.pid,                                             N),

    # Commands for program storage
    I("LOAD",      "download a program",                 STORAGE,  (),              HOST,   program_store.load),
    I("UPLOAD",    "upload the program's text",          STORAGE,  (),              HOST,   program_store.upload),
    I("UP",        "upload the compiled program",        STORAGE,  (),              HOST,   program_store.upload_image),
    I("LOCKP",     "prevent upload",                     STORAGE,  (),              BOTH,   program_store.lock),
    I("RCKS",      "report checksums",                   STORAGE,  (),              BOTH,   program_store.checksum_report),

    # Commands that report or print values
    I("RP",        "report position",                    REPORTS,  (),              BOTH,   partial(reports.variable, name="@P")),
    I("RPE",       "report position error",              REPORTS,  (),              BOTH,   partial(reports.variable, name="@PE")),
    I("RV",        "report velocity now",                REPORTS,  (),              BOTH,   partial(reports.variable, name="@V")),
    I("RA",        "report acceleration",                REPORTS,  (),              BOTH,   partial(reports.variable, name="A")),
    I("RD",        "report relative distance",           REPORTS,  (),              BOTH,   partial(reports.variable, name="D")),
    I("RE",        "report allowable error",             REPORTS,  (),              BOTH,   partial(reports.variable, name="E")),
    I("RT",        "report torque",                      REPORTS,  (),              BOTH,   partial(reports.variable, name="T")),
    I("RI",        "report captured index position",     REPORTS,  (),              BOTH,   partial(reports.variable, name="I")),
    I("RPW",       "report position and status",         REPORTS,  (),              BOTH,   reports.position_and_status),
    I("RW",        "report status word",                 STATUS,   (),              BOTH,   partial(reports.variable, name="W")),
    I("RS",        "report status byte",                 STATUS,   (),              BOTH,   partial(reports.variable, name="S")),
    *(I(f"RB{bit}", f"report flag B{bit}",              STATUS,   (),              BOTH,   partial(reports.variable, name=f"B{bit}")) for bit in "trliwehoxpmdusakbcf"),
    I("RMODE",     "report mode",                        REPORTS,  (),              BOTH,   reports.mode),
    I("RSP",       "report sample period and firmware",  REPORTS,  (),              BOTH,   reports.sample_rate),
    *(I(f"R{name}", f"report {name}",                  TUNING,   (),              BOTH,   partial(reports.variable, name=name)) for name in ("KP", "KI", "KD", "KL", "KS", "KV", "KA", "KG")),
    I("RCTR",      "report external counter",            REPORTS,  (),              BOTH,   partial(reports.variable, name="CTR")),
    I("Ra…Rzzz",   "report variable",                    REPORTS,  (),              BOTH,   reports.value,                                         Form.REPORT_VARIABLE, "Ra"),
    I("Rab[]",     "report element of ab[]",            ARRAYS,   (INDEX,),        BOTH,   reports.value,                                         Form.REPORT_ARRAY, "Rab[exp]"),
    I("Raw[]",     "report element of aw[]",            ARRAYS,   (INDEX,),        BOTH,   reports.value,                                         Form.REPORT_ARRAY, "Raw[exp]"),
    I("Ral[]",     "report element of al[]",            ARRAYS,   (INDEX,),        BOTH,   reports.value,                                         Form.REPORT_ARRAY, "Ral[exp]"),
    I("RU",        "report all pins",                    IO,       (),              BOTH,   partial(reports.variable, name="U")),
    *(I(f"RU{pin}", f"report pin {pin}",                DIGITAL,  (),              BOTH,   partial(reports.variable, name=f"U{pin}")) for pin in state.USER_PINS),
    *(I(f"RU{pin}A", f"report voltage of pin {pin}",     ANALOG,   (),              BOTH,   partial(reports.variable, name=f"U{pin}A")) for pin in state.USER_PINS),
    I("RAINpc",    "report AniLink analog input",        ANILINK,  (),              BOTH,   reports.value,                                         Form.REPORT_VARIABLE),
    I("RDINpc",    "report AniLink digital input",       ANILINK,  (),              BOTH,   reports.value,                                         Form.REPORT_VARIABLE),
    I("RCHN",      "report channel errors",              REPORTS,  (),              BOTH,   reports.channel_errors),
    I("RCHN0",     "report errors of channel 0",         REPORTS,  (),              BOTH,   partial(reports.channel_errors, channel=0)),
    I("RCHN1",     "report errors of channel 1",         REPORTS,  (),              BOTH,   partial(reports.channel_errors, channel=1)),
    I("RCS",       "report errors of channel 0",         REPORTS,  (),              BOTH,   partial(reports.channel_errors, channel=0)),
    I("RCS1",      "report errors of channel 1",         REPORTS,  (),              BOTH,   partial(reports.channel_errors, channel=1)),
    I("RAMPS",     "report PWM limit",                   REPORTS,  (),              BOTH,   partial(reports.variable, name="AMPS")),
    I("RBASE",     "report cam cycle",                   REPORTS,  (),              BOTH,   partial(reports.variable, name="BASE")),
    I("RSIZE",     "report cam table size",              REPORTS,  (),              BOTH,   partial(reports.variable, name="SIZE")),
    I("REPTR",     "report EEPROM pointer",              REPORTS,  (),              BOTH,   partial(reports.variable, name="EPTR")),
    I("RCLK",      "report sample counter",              REPORTS,  (),              BOTH,   partial(reports.variable, name="CLK")),
    I("RTEMP",     "report temperature",                 REPORTS,  (),              BOTH,   partial(reports.variable, name="TEMP")),
    I("RADDR",     "report address",                     REPORTS,  (),              BOTH,   partial(reports.variable, name="ADDR")),
    I("PRINT()",   "print",                              PRINTING, (ITEMS,),        BOTH,   reports.print_,                                        P, "PRINT(item,…)"),
    I("PRINT1()",  "print on channel 1",                 IO,       (ITEMS,),        BOTH,   partial(reports.print_, channel=1),                    P, "PRINT1(item,…)"),
    *(I(f"PRINT{p}()", f"print on AniLink device {p}",   ANILINK,  (ITEMS,),        BOTH,   partial(reports.print_device, device=p),               P, f"PRINT{p}(item,…)") for p in "ABCDEFGH"),

    # Commands that firmware 4.76 has removed (manual, section 1.3)
    I("ES400",     "removed",                            REMOVED,  (),              GONE,   None, instead="the encoder's filter is fixed: remove this command"),
    I("ES1000",    "removed",                            REMOVED,  (),              GONE,   None, instead="the encoder's filter is fixed: remove this command"),
    I("KGON",      "removed",                            REMOVED,  (),              GONE,   None, instead="KG acts whenever it is not 0: remove this command"),
    I("KGOFF",     "removed",                            REMOVED,  (),              GONE,   None, instead="KG acts whenever it is not 0: write KG=0 F"),
    I("LIMH",      "removed",                            REMOVED,  (),              GONE,   None, instead="limits are always active high: remove this command and wire normally closed switches to ground (3.1)"),
    I("LIML",      "removed",                            REMOVED,  (),              GONE,   None, instead="limits are always active high: remove this command and wire normally closed switches to ground (3.1)"),
    I("LIMN",      "removed",                            REMOVED,  (),              GONE,   None, instead="limits are always directional (3.1): remove this command, or write UCI UDI for pins C and D as ordinary inputs"),
    I("MFRATIO",   "removed",                            REMOVED,  (),              GONE,   None, instead="write e.g. MFMUL=1 MFDIV=2 MFR"),
    I("RES=",      "removed",                            REMOVED,  (),              GONE,   None, instead="the encoder's resolution is fixed: remove this command"),
    I("MD50",      "removed",                            REMOVED,  (),              GONE,   None, instead="write e.g. MT T=UAA G, again and again"),
)
# fmt: on
