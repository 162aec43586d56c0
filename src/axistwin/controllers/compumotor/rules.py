"""The diagnostics of the checker for the 1810 and 1811: a table of codes.

1xx a command and its bytes, 2xx modes and sequences, 3xx moves, 4xx streaming.  A board ignores wrong commands
without a message.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E, W = Severity.ERROR, Severity.WARNING

LANGUAGE, READING, SEQUENCES = "Command Language", "Reading and writing", "Sequence buffers"
MODES, DEFINE, STREAM = "Modes", "Pre-defined moves", "Velocity-streaming mode"
DEFAULT = "31 00 00 00 00 61 A8 00 03 D0 90\n"
STREAMING = "51 01 04 00 00 00 00\n"
DISTANCE_TIME = "53 01 04 00 00 00 00 00 02\n"

RULES = (
    NO_COMMAND := Rule("CM101", "the board has no such command", E, LANGUAGE,
        "An opcode is the first byte of a command.  Some opcodes are valid only for an 1811, and not for an 1810.  "
        "`axistwin commands 1811` lists all opcodes.",
        "02"),
    TOO_LONG := Rule("CM102", "a command has more than 16 bytes", E, READING,
        "The input data buffer holds 16 bytes.",
        "E0" + " 00" * 16),
    TOO_SHORT := Rule("CM103", "parameter bytes are missing", E, LANGUAGE,
        "The board ignores a command with too few parameter bytes.",
        "33 00"),
    SURPLUS := Rule("CM104", "there are too many parameter bytes", E, LANGUAGE,
        "Bytes after the last parameter must be 00; otherwise the board ignores the command.",
        "70 00 00 01"),
    RANGE := Rule("CM105", "a parameter is out of range", E, LANGUAGE,
        "The board ignores a command with a parameter that is out of range.",
        "08 08"),
    NOTHING := Rule("CM106", "the command does nothing", W, LANGUAGE,
        "The manual lists this opcode, but the board ignores this opcode.  Leave it out.",
        "FE"),
    UNKNOWN_NAME := Rule("CM110", "no command has this name", E, LANGUAGE,
        "In a program for an 1810 or 1811, write each command by its hex code or by its name.  "
        "`axistwin commands 1811` lists all names.  Write `_` instead of each blank in the name of a command, for "
        "example `go_relative`.",
        "go_relatve 25000"),
    WORD := Rule("CM111", "a value is malformed or out of range", E, LANGUAGE,
        "After the name of a command, write the values of the parameters of the command.  A number is decimal, or "
        "hexadecimal after 0x.  Write the velocity range and the acceleration range together as two digits, for "
        "example `51`.  For a parameter that switches a function on or off, write `on` or `off`.  In a command that "
        "is written in hex, write each byte with two digits, for example `05`.",
        "set_user_bit 3"),
    NUMBER_OF_VALUES := Rule("CM112", "the command has too few or too many values", E, LANGUAGE,
        "After the name of a command, write one value for each parameter that the command uses.  For the unused bytes "
        "of a command, write no value, because axistwin sends 00 for each unused byte.",
        "go_relative"),
    NOT_IN_SEQUENCE := Rule("CM201", "the command is not allowed in a sequence", E, SEQUENCES,
        "The definition of a sequence begins with the command D9h, and ends with the command D8h.  During the "
        "definition of a sequence, the board ignores commands that are not allowed in a sequence.  Send the command "
        "before D9h or after D8h.",
        "D9 01\n70\nD8"),
    ONLY_IN_SEQUENCE := Rule("CM202", "the command is allowed only in a sequence", E, SEQUENCES,
        "Commands that wait or repeat are allowed only in the definition of a sequence.  The definition of a sequence "
        "begins with the command D9h, and ends with the command D8h.",
        "wait_seconds 2"),
    ONLY_STREAMING := Rule("CM203", "the command is allowed only in a streaming mode", E, STREAM,
        "In indexer mode, the board ignores commands that are valid only in a streaming mode, for example E0h.  The "
        "commands 51h, 52h and 53h select a streaming mode.",
        "E0" + " 00" * 12),
    NOT_STREAMING := Rule("CM204", "the command is not allowed in a streaming mode", E, MODES,
        "In a streaming mode, the board ignores commands that are valid only in indexer mode, for example 40h.  The "
        "command 50h selects indexer mode.",
        STREAMING + "40 01"),
    NESTED := Rule("CM205", "a loop contains another loop", E, SEQUENCES,
        "A loop (command 20h or 21h) cannot contain another loop.  The board ignores the command that begins the inner "
        "loop.  Write out the commands of the inner loop as often as they are to be performed.",
        "D9 01\nrepeat 3 2\nrepeat 1 2\n83\n83\nD8"),
    LOOP_TOO_LONG := Rule("CM206", "a loop repeats more commands than the sequence contains", W, SEQUENCES,
        "For example, after the command `repeat 3 2`, the board executes the next three commands of the sequence two "
        "times.  A loop ends at the latest with the last command of the sequence, even if the loop should contain "
        "more commands.",
        "D9 01\nrepeat 3 2\n83\nD8"),
    UNENDED := Rule("CM207", "the end of a sequence definition is missing", W, SEQUENCES,
        "The board stores all further commands in the sequence until the board receives the command D8h.",
        "D9 01\n83"),
    NOT_DEFINING := Rule("CM208", "a sequence definition ends, but none has begun", W, SEQUENCES,
        "The command D8h ends the definition of a sequence.  The command D9h, which begins a definition, was not sent "
        "before D8h.",
        "D8"),
    NO_SEQUENCE := Rule("CM209", "the sequence is not defined", E, SEQUENCES,
        "The command 41h performs a sequence that has been defined with the command D9h.  When the board enters a "
        "streaming mode, the board deletes all sequences.",
        "41 02"),
    DURING_MOVE := Rule("CM210", "the command follows directly on a move or a sequence", W, SEQUENCES,
        "The board ignores the commands 92h, D9h and DAh while a move of the host, a search for home or a sequence is "
        "in progress.  The commands after an ignored D9h are performed, not stored.  Wait until the motor has "
        "stopped, or define the sequences first.",
        "31 00 00 00 00 61 A8 00 03 D0 90\n33 00 00 00 01\nD9 01\n83\nD8"),
    NO_SUCH_MOVE := Rule("CM301", "the board cannot store a move with this number", E, DEFINE,
        "The numbers of stored moves are 1 to 50.",
        "define_relative_move 51 00 1 1 1"),
    VELOCITY := Rule("CM302", "the velocity exceeds the velocity range", E, "Positions and moves",
        "Each velocity range has a highest velocity.  The board does not perform a move whose velocity exceeds the "
        "highest velocity of the selected velocity range.",
        "31 00 00 00 10 00 00 00 00 00 01"),
    ACCELERATION := Rule("CM303", "the acceleration is 0", W, "Positions and moves",
        "The board never performs a move with the acceleration 0.",
        "31 00 00 00 00 61 A8 00 00 00 00"),
    NO_MOVE := Rule("CM304", "the board has no stored move with this number", E, DEFINE,
        "The command 40h performs a stored move.  Define the move before you send the command 40h.",
        "40 07"),
    NOT_GIVEN := Rule("CM305", "the command uses values that the host has not defined", E, "Positions and moves",
        "Some commands use values that other commands must define first.  Send the command 31h before a default move.  "
        "Send the command 38h before a search for home.  Send the commands B0h to B4h before a closed-loop move.",
        "33 00 00 00 01"),
    TRIGGER := Rule("CM306", "a trigger has two functions", E, "Stop and kill",
        "A trigger can have only one function at a time.  Disable the present function of the trigger before you set "
        "another function.",
        "stop_on_trigger 1 on off\ninterrupt_on_trigger 1 on"),
    NO_ENCODER := Rule("CM307", "an 1810 has no encoder for a closed-loop move", W, DEFINE,
        "An 1810 stores the definition of a closed-loop move, but does not perform the move, because an 1810 has no "
        "encoder.  Use an 1811 for closed-loop moves.  With the option `encoder_commands=\"performed\"`, a virtual "
        "1810 performs them, with an encoder count that is always 0; the warning remains.",
        "; model: 1810\n> D4 01 00 00 00 61 A8 00 03 D0 90 00 00 00 0A\n> 40 01",
        suffix=".talk"),
    OTHER_MODE := Rule("CM401", "the data do not match the present streaming mode", E, STREAM,
        "The command E0h sends data for the streaming mode 51h, E1h for 52h, and E3h for 53h.",
        STREAMING + "E1" + " 00" * 14),
    SHORT_PAIR := Rule("CM402", "the duration of a velocity-distance pair is too short", E, STREAM,
        "The duration of a velocity-distance pair is its distance divided by its velocity.  The duration of a "
        "velocity-distance pair must be at least 2 ms.",
        STREAMING + "E0 10 00 00 01" + " 00" * 8),
    BEYOND_CLOCK := Rule("CM403", "an update interval has more pulses than the clock permits", E, STREAM,
        "The base clock and the divisor limit the number of pulses in one update interval.",
        DISTANCE_TIME + "E3 01 7F FF" + " 00" * 12),
    NOT_MARKED := Rule("CM404", "a marker (a special streamed value) cannot start this command", E, STREAM,
        "A marker can start only a command that is allowed during streaming and has at most two parameter bytes.",
        STREAMING + "EE 7F FE 7C 01 01"),
)  # fmt: skip
