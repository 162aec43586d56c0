"""The diagnostics of the checker for the 1810 and 1811: a table of codes.

1xx a command and its bytes, 2xx modes and sequences, 3xx moves, 4xx streaming.  A board ignores wrong commands
without a message.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E, W = Severity.ERROR, Severity.WARNING

# Names of chapters in the manual
LANGUAGE, READING, SEQUENCES = "Command Language", "Reading and writing", "Sequence buffers"
MODES, DEFINE, STREAM = "Modes", "Pre-defined moves", "Velocity-streaming mode"
DEFAULT = "31 00 00 00 00 61 A8 00 03 D0 90\n"
STREAMING = "51 01 04 00 00 00 00\n"
DISTANCE_TIME = "53 01 04 00 00 00 00 00 02\n"

RULES = (
    NO_COMMAND := Rule(
        "CM101", "no such command", E, LANGUAGE,
        "The board does not have this opcode, or only an 1811 does.  `axistwin commands 1811` lists all opcodes.",
        "02",
    ),
    TOO_LONG := Rule(
        "CM102", "a command of more than 16 bytes", E, READING,
        "The input data buffer holds 16 bytes.",
        "E0" + " 00" * 16,
    ),
    TOO_SHORT := Rule(
        "CM103", "parameter bytes are missing", E, LANGUAGE,
        "A command with too few parameter bytes is ignored.",
        "33 00",
    ),
    SURPLUS := Rule(
        "CM104", "too many parameter bytes", E, LANGUAGE,
        "Bytes after the last parameter must be 00; otherwise the board ignores the command.",
        "70 00 00 01",
    ),
    RANGE := Rule(
        "CM105", "a parameter is out of range", E, LANGUAGE,
        "The command is ignored.",
        "08 08",
    ),
    NOTHING := Rule(
        "CM106", "a command that does nothing", W, LANGUAGE,
        "The manual lists this opcode, but the board does nothing when it receives it.",
        "FE",
    ),
    UNKNOWN_NAME := Rule(
        "CM110", "no command of this name", E, LANGUAGE,
        "Write a command in hex, or by the name that `axistwin commands` lists, with `_` instead of blanks.",
        "go_relatve 25000",
    ),
    WORD := Rule(
        "CM111", "a value that cannot be read", E, LANGUAGE,
        "After a command's name write its values: decimal numbers, hex numbers after 0x, ranges as two digits, and "
        "switches as on or off.  In a command in hex, write two digits for each byte.",
        "set_user_bit 3",
    ),
    NUMBER_OF_VALUES := Rule(
        "CM112", "too few or too many values", E, LANGUAGE,
        "After a command's name write one value for each parameter; leave out parameters that have no meaning.",
        "go_relative",
    ),
    NOT_IN_SEQUENCE := Rule(
        "CM201", "a command that is not allowed in a sequence", E, SEQUENCES,
        "Between D9 and D8, while a sequence is being defined, the board neither stores nor obeys this command.",
        "D9 01\n70\nD8",
    ),
    ONLY_IN_SEQUENCE := Rule(
        "CM202", "a command for sequences only", E, SEQUENCES,
        "Commands that wait or repeat are valid only in the definition of a sequence, between D9 and D8.",
        "wait_seconds 2",
    ),
    ONLY_STREAMING := Rule(
        "CM203", "a command for the streaming modes", E, STREAM,
        "The command is ignored in indexer mode.  51, 52 or 53 enter a streaming mode.",
        "E0" + " 00" * 12,
    ),
    NOT_STREAMING := Rule(
        "CM204", "a command that is not valid in a streaming mode", E, MODES,
        "The command is ignored in a streaming mode.  50 returns to indexer mode.",
        STREAMING + "40 01",
    ),
    NESTED := Rule(
        "CM205", "a loop within a loop", E, SEQUENCES,
        "A loop (20 or 21) cannot contain another loop: the board ignores the inner 20 or 21.",
        "D9 01\nrepeat 3 2\nrepeat 1 2\n83\n83\nD8",
    ),
    LOOP_TOO_LONG := Rule(
        "CM206", "a loop over more commands than follow", W, SEQUENCES,
        "The loop ends with the sequence.",
        "D9 01\nrepeat 3 2\n83\nD8",
    ),
    UNENDED := Rule(
        "CM207", "a sequence definition that never ends", W, SEQUENCES,
        "The board stores all further commands in the sequence until it receives D8.",
        "D9 01\n83",
    ),
    NOT_DEFINING := Rule(
        "CM208", "an end without a sequence definition", W, SEQUENCES,
        "D8 ends the definition of a sequence, but no definition has begun.",
        "D8",
    ),
    NO_SEQUENCE := Rule(
        "CM209", "a sequence that is not defined", E, SEQUENCES,
        "The command 41 performs a sequence that has been defined with D9.  Entering a streaming mode deletes all "
        "sequences.",
        "41 02",
    ),
    NO_SUCH_MOVE := Rule(
        "CM301", "a move number that is not stored", E, DEFINE,
        "Valid are moves 1 to 50.",
        "define_relative_move 51 00 1 1 1",
    ),
    VELOCITY := Rule(
        "CM302", "a velocity beyond its range", E, "Positions and moves",
        "Each velocity range has a highest velocity; the board does not perform a faster move.",
        "31 00 00 00 10 00 00 00 00 00 01",
    ),
    ACCELERATION := Rule(
        "CM303", "acceleration 0", W, "Positions and moves",
        "The board never performs a move whose acceleration is 0.",
        "31 00 00 00 00 61 A8 00 00 00 00",
    ),
    NO_MOVE := Rule(
        "CM304", "a move that is not defined", E, DEFINE,
        "The command 40 performs a move that has been defined before.",
        "40 07",
    ),
    NOT_GIVEN := Rule(
        "CM305", "ignored, because a definition is missing", E, "Positions and moves",
        "A default move needs the command 31 before it, a search for home needs 38, and a closed-loop move needs B0 "
        "to B4.",
        "33 00 00 00 01",
    ),
    TRIGGER := Rule(
        "CM306", "a trigger with two functions", E, "Stop and kill",
        "A trigger has one function at a time; disable the first function before you set the second.",
        "stop_on_trigger 1 on off\ninterrupt_on_trigger 1 on",
    ),
    NO_ENCODER := Rule(
        "CM307", "a closed-loop move of an 1810", W, DEFINE,
        "An 1810 stores the definition but does not perform the move, because it has no encoder.  With the option "
        "`encoder_commands=\"performed\"` it moves as if an encoder stayed at 0.",
        "; model: 1810\n> D4 01 00 00 00 61 A8 00 03 D0 90 00 00 00 0A\n> 40 01",
        suffix=".talk",
    ),
    OTHER_MODE := Rule(
        "CM401", "data for another streaming mode", E, STREAM,
        "E0 is for mode 51, E1 for 52, E3 for 53.",
        STREAMING + "E1" + " 00" * 14,
    ),
    SHORT_PAIR := Rule(
        "CM402", "a velocity-distance pair that is too short", E, STREAM,
        "Each pair must last 2 ms at least.",
        STREAMING + "E0 10 00 00 01" + " 00" * 8,
    ),
    BEYOND_CLOCK := Rule(
        "CM403", "more pulses than the clock allows", E, STREAM,
        "The base clock and the divisor limit the number of pulses in one update interval.",
        DISTANCE_TIME + "E3 01 7F FF" + " 00" * 12,
    ),
    NOT_MARKED := Rule(
        "CM404", "a command that cannot be in a marker", E, STREAM,
        "A marker can contain only a command that is valid while streaming and has at most two parameter bytes.",
        STREAMING + "EE 7F FE 7C 01 01",
    ),
)  # fmt: skip
