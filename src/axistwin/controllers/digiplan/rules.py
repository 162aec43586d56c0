"""What the checker of the IF1 and IF2 can find: its table of codes.

1xx a message and its commands, 2xx sequences, 3xx values that do not go together, 4xx the session.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E, W = Severity.ERROR, Severity.WARNING

# Chapters of the manual
ALL, COMBINING, INTERPOLATION = (
    "Full command list",
    "Combining inputs and outputs with move instructions",
    "Linear interpolation mode",
)
SEQUENCE, REPEATS, ABORT = (
    "Programming a sequence",
    "Repeating parts of a sequence",
    "Aborting a run-mode move in a sequence",
)
INTERVENTION, INDEX, RUN = (
    "Controller intervention in a sequence",
    "Index mode instructions",
    "Run mode instructions",
)
INITIALISATION, LOCKOUT = "Initialisation", "Communication lockout commands"

RULES = (
    UNKNOWN := Rule(
        "DP101", "unknown character", E, ALL,
        "This character is no command.  The whole message is refused and the data fault is flagged.  Commands are "
        "upper case; in a file of command lines `;` begins a comment.",
        "x1000$",
    ),
    LOST_NUMBER := Rule(
        "DP102", "a number that belongs to no command", E, ALL,
        "A number stands where the command before it takes none, or not such a one.  The message is refused.",
        "B20",
    ),
    ALONE := Rule(
        "DP103", "must be sent alone", E, ALL,
        "Status requests, `#`, `[` and `]` are messages by themselves, each with its own <CR>.",
        "X100 E",
    ),
    SETUP := Rule(
        "DP104", "for initialisation only", E, INITIALISATION,
        "`(`, `*`, `U` and `V` are heard while the interface is being initialised; afterwards they are a data fault.",
        "U61",
    ),
    CANNOT_STAND := Rule(
        "DP105", "a sign that cannot stand here", E, ALL,
        "`$`, `:`, `+`, `-` and `,` are parts of other commands: `$` ends a message, `:` divides the steps of a "
        "sequence, signs follow an axis or B, a comma follows P or =.",
        "X$Y$",
    ),
    NOT_IN_THIS_KIND := Rule(
        "DP106", "a command for another kind of message", E, ALL,
        "Some commands are for steps of a sequence only (`=`, `A`), some for direct messages only (`>`, `<`, `^`, "
        "`D`).",
        ":^5X100:$",
    ),
    ORDER := Rule(
        "DP107", "commands in a wrong order", E, COMBINING,
        "A message or step has a fixed order: inputs H and L, the move, then outputs S, R or a pulse P; in a step also "
        "A behind the inputs, and = at the end.",
        "S1X100$",
    ),
    NEEDS := Rule(
        "DP108", "a parameter is missing", E, ALL,
        "This command needs a number, which is not there or is written in another way.",
        "@",
    ),
    RANGE := Rule(
        "DP109", "a parameter is out of range", E, ALL,
        "The value is refused and the range fault is flagged; nothing of the message is kept.",
        ">5",
    ),
    TWICE := Rule(
        "DP110", "an axis, / or G that does not fit what stands before it", E, ALL,
        "An axis, `/` or `G` stands twice in a message, or `/`, `G` or `B` has no axis before it.",
        "X1X2$",
    ),
    WAITS := Rule(
        "DP111", "waiting for an input without a move", E, COMBINING,
        "H and L hold a move back.  To wait and then only switch an output, use a step of a sequence.",
        "H1$",
    ),
    MINOR := Rule(
        "DP112", "the minor axis is missing", E, INTERPOLATION,
        "Behind `/` stands the axis with the shorter distance, or two of them.",
        "X200/$",
    ),
    CORRECTION := Rule(
        "DP113", "backlash correction that cannot be", E, "Backlash correction",
        "`B` without a number corrects an index of its own axis, no run and no interpolated move.",
        "X@500GB$",
    ),
    CONTROL_ALONE := Rule(
        "DP114", "% with something beside it", E, INTERVENTION,
        "The step in which a sequence hands control over holds `%` and nothing else.",
        ":X100%:$",
    ),
    SEQUENCE_END := Rule(
        "DP201", "a sequence without its end", E, SEQUENCE,
        "A message that begins with `:` is a sequence, and ends in `:$`.",
        ":X100",
    ),
    STEP_MISSING := Rule(
        "DP202", "an empty step", E, SEQUENCE,
        "Nothing stands between two colons.  Steps count from 1, which matters to the repeats behind it.",
        ":X100::Y:$",
    ),
    TOO_MANY := Rule(
        "DP203", "too many steps", E, SEQUENCE,
        "A sequence has 63 steps at most.  The sequence that was stored before is kept.",
        ":" + "X:" * 64 + "$",
    ),
    REPEAT := Rule(
        "DP204", "a repeat from a step that has not come yet", E, REPEATS,
        "`=times,first` repeats from a step that stands before it, or from its own.",
        ":X100:=2,3:$",
    ),
    NEVER_REACHED := Rule(
        "DP205", "steps that are never reached", W, REPEATS,
        "`=0,n` repeats for ever; only `#` ends it.  What stands behind it is stored and never done.",
        ":X100:=0,1:Y:$",
    ),
    RUN_GOES_ON := Rule(
        "DP206", "a move that waits for a run to end", W, ABORT,
        "A run goes on into the next steps.  A move must wait for its end, and it has none until `A` aborts it.",
        ":X@500G:X5:$",
    ),
    NOT_HANDED_OVER := Rule(
        "DP207", "% without a sequence that waits for it", E, INTERVENTION,
        "`%` sent directly gives control back to a sequence that has handed it over with a step `%`.",
        "%",
    ),
    NOTHING_STORED := Rule(
        "DP208", "no sequence to run again", W, SEQUENCE,
        "`:$` runs the stored sequence again, and none has been sent.  An IF2 may still have one in its battery-backed "
        "memory.",
        ":$",
    ),
    TOO_FAST := Rule(
        "DP301", "a speed above the maximum of the range", E, "Speed",
        "Each speed range has its highest speed: 25000, 50000, 100000 and 4000 steps/s in ranges 1 to 4.  Range and "
        "speed are kept from message to message.",
        "@25001",
    ),
    CONSTRAINT := Rule(
        "DP302", "beyond what linear interpolation can do", E, "Constraints in linear interpolation mode",
        "Speed up to 10000 steps/s, acceleration from 5000 steps/s², major distance up to 65535 steps and not less "
        "than the minor one, speed range 1.",
        "@10001\nX200/Y100$",
    ),
    NO_DISTANCE := Rule(
        "DP303", "an index of no length", W, INDEX,
        "The distance is 0: none has been said, or a run has set it to 0.  The interface obeys, and nothing moves.",
        "X@500G$\nX$",
    ),
    UNUSED_DISTANCE := Rule(
        "DP304", "a distance that a run does not use", W, RUN,
        "G runs until it is stopped.  The distance is not used, and becomes 0 for later moves too.",
        "X1000G$",
    ),
    NO_START := Rule(
        "DP305", "a message that begins nothing", W, INDEX,
        "Without `$` the message only keeps its parameters: no move, no output, no run.",
        "S2",
    ),
    NOT_HEARD := Rule(
        "DP401", "said before ( has told the baud rate", W, INITIALISATION,
        "After switching on, the interface hears nothing but `(`, by which it finds the baud rate.",
        "+1.5\n> X100$\\r\n> (", ".talk",
    ),
    FORMAT := Rule(
        "DP402", "no data format", E, INITIALISATION,
        "Behind `(` comes the data format: U or V, frame 1 to 8, parity 1 to 9.  U ends in <CR>, V in <CR><LF>.",
        "> (\n> U60\\r\n> U61\\r", ".talk",
    ),
    FORMAT_UNENDED := Rule(
        "DP403", "a data format that is never ended", W, INITIALISATION,
        "The format message is obeyed when its <CR> (behind V: <LF>) has come.",
        "> (U61", ".talk",
    ),
    UNENDED := Rule(
        "DP404", "a message that is never ended", W, INITIALISATION,
        "A message is obeyed when its terminator has come: <CR>, or <LF> if the data format was V.",
        "> (U61\\r\n> X100$", ".talk",
    ),
    LOCKED := Rule(
        "DP405", "sent while the interface is locked", W, LOCKOUT,
        "Behind `[` only status requests and `]` are obeyed, and `(` while DSR is held; everything else is ignored.",
        "[\nX100$\n]",
    ),
)  # fmt: skip
"""All of them, in the order of the codes."""
