"""Table of the diagnostic codes of the IF1 and IF2.

1xx a message and its commands, 2xx sequences, 3xx values that do not go together, 4xx the session.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E, W = Severity.ERROR, Severity.WARNING

# Chapters of the manual
ALL, COMBINING = "Full command list", "Combining inputs and outputs with move instructions"
INTERPOLATION, CONSTRAINTS = "Linear interpolation mode", "Constraints in linear interpolation mode"
SEQUENCE, REPEATS = "Programming a sequence", "Repeating parts of a sequence"
ABORT, INTERVENTION = "Aborting a run-mode move in a sequence", "Controller intervention in a sequence"
INDEX, RUN = "Index mode instructions", "Run mode instructions"
INITIALISATION, LOCKOUT = "Initialisation", "Communication lockout commands"

RULES = (
    UNKNOWN := Rule("DP101", "unknown character", E, ALL,
        "This character is no command.  The whole message is refused and the data fault is flagged.  Commands are "
        "upper case; in a file of command lines `;` begins a comment.",
        "x1000$"),
    LOST_NUMBER := Rule("DP102", "a number that belongs to no command", E, ALL,
        "A number stands where the command before it takes none, or takes another number.  The message is refused.",
        "B20"),
    ALONE := Rule("DP103", "must be sent alone", E, ALL,
        "Status requests, `#`, `[` and `]` are messages by themselves, each with its own <CR>.",
        "X100 E"),
    SETUP := Rule("DP104", "for initialisation only", E, INITIALISATION,
        "`(`, `*`, `U` and `V` are obeyed during initialisation; afterwards they are a data fault.",
        "U61"),
    CANNOT_STAND := Rule("DP105", "a sign that cannot stand here", E, ALL,
        "`$`, `:`, `+`, `-` and `,` are parts of other commands: `$` ends a message, `:` divides the steps of a "
        "sequence, signs follow an axis or B, a comma follows P or =.",
        "X$Y$"),
    NOT_IN_THIS_KIND := Rule("DP106", "a command for another kind of message", E, ALL,
        "Some commands are for steps of a sequence only (`=`, `A`), some for direct messages only (`>`, `<`, `^`, "
        "`D`).",
        ":^5X100:$"),
    ORDER := Rule("DP107", "commands in a wrong order", E, COMBINING,
        "A message or step has a fixed order: inputs H and L, the move, then outputs S, R or a pulse P; in a step also "
        "A after the inputs, and = at the end.",
        "S1X100$"),
    NEEDS := Rule("DP108", "a parameter is missing", E, ALL,
        "This command needs a number; the number is missing or is written in another way.",
        "@"),
    RANGE := Rule("DP109", "a parameter is out of range", E, ALL,
        "The value is refused and the range fault is flagged; nothing of the message is kept.",
        ">5"),
    TWICE := Rule("DP110", "an axis, / or G that does not fit what stands before it", E, ALL,
        "An axis, `/` or `G` stands twice in a message, or `/`, `G` or `B` has no axis before it.",
        "X1X2$"),
    WAITS := Rule("DP111", "waiting for an input without a move", E, COMBINING,
        "H and L hold a move back.  To wait and then only switch an output, use a step of a sequence.",
        "H1$"),
    MINOR := Rule("DP112", "the minor axis is missing", E, INTERPOLATION,
        "`/` is followed by the axis with the shorter distance, or two of them.",
        "X200/$"),
    CORRECTION := Rule("DP113", "backlash correction that cannot be", E, "Backlash correction",
        "`B` without a number corrects an index of its own axis, no run and no interpolated move.",
        "X@500GB$"),
    CONTROL_ALONE := Rule("DP114", "% with something beside it", E, INTERVENTION,
        "The step in which a sequence gives control to the host contains `%` and nothing else.",
        ":X100%:$"),
    SEQUENCE_END := Rule("DP201", "a sequence without its end", E, SEQUENCE,
        "A message that begins with `:` is a sequence, and ends in `:$`.",
        ":X100"),
    STEP_MISSING := Rule("DP202", "an empty step", E, SEQUENCE,
        "Nothing stands between two colons.  Steps count from 1, which matters to the repeats after it.",
        ":X100::Y:$"),
    TOO_MANY := Rule("DP203", "too many steps", E, SEQUENCE,
        "A sequence has 63 steps at most.  The sequence that was stored before is kept.",
        ":" + "X:" * 64 + "$"),
    REPEAT := Rule("DP204", "a repeat from a step that has not come yet", E, REPEATS,
        "`=times,first` repeats from an earlier step or from its own step.",
        ":X100:=2,3:$"),
    NEVER_REACHED := Rule("DP205", "steps that are never reached", W, REPEATS,
        "`=0,n` repeats for ever; only `#` ends it.  The steps after it are stored and never carried out.",
        ":X100:=0,1:Y:$"),
    RUN_GOES_ON := Rule("DP206", "a move that waits for a run to end", W, ABORT,
        "A run goes on into the next steps.  A move must wait until the run ends, and only `A` ends the run.",
        ":X@500G:X5:$"),
    NOT_HANDED_OVER := Rule("DP207", "% without a sequence that waits for it", E, INTERVENTION,
        "`%` sent directly gives control back to a sequence that has handed it over with a step `%`.",
        "%"),
    NOTHING_STORED := Rule("DP208", "no sequence to run again", W, SEQUENCE,
        "`:$` runs the stored sequence again, and none has been sent.  An IF2 may still have one in its battery-backed "
        "memory.",
        ":$"),
    TOO_FAST := Rule("DP301", "a speed above the maximum of the range", E, "Speed",
        "Each speed range has its highest speed: 25000, 50000, 100000 and 4000 steps/s in ranges 1 to 4.  Range and "
        "speed are kept from message to message.",
        "@25001"),
    CONSTRAINT := Rule("DP302", "beyond what linear interpolation can do", E, CONSTRAINTS,
        "Speed up to 10000 steps/s, acceleration from 5000 steps/s², major distance up to 65535 steps and not less "
        "than the minor one, speed range 1.",
        "@10001\nX200/Y100$"),
    NO_DISTANCE := Rule("DP303", "an index of no length", W, INDEX,
        "The distance is 0: no distance has been sent, or a run has set it to 0.  Nothing moves.",
        "X@500G$\nX$"),
    UNUSED_DISTANCE := Rule("DP304", "a distance that a run does not use", W, RUN,
        "G runs until it is stopped.  The distance is not used, and becomes 0 for later moves too.",
        "X1000G$"),
    NO_START := Rule("DP305", "a message that begins nothing", W, INDEX,
        "Without `$` the message only keeps its parameters: no move, no output, no run.",
        "S2"),
    NOT_HEARD := Rule("DP401", "said before ( has told the baud rate", W, INITIALISATION,
        "After power-on the interface obeys only `(`, from which it detects the baud rate.",
        "+1.5\n> X100$\\r\n> (", ".talk"),
    FORMAT := Rule("DP402", "no data format", E, INITIALISATION,
        "`(` is followed by the data format: U or V, frame 1 to 8, parity 1 to 9.  U ends in <CR>, V in <CR><LF>.",
        "> (\n> U60\\r\n> U61\\r", ".talk"),
    FORMAT_UNENDED := Rule("DP403", "a data format that is never ended", W, INITIALISATION,
        "The format message is obeyed when its <CR> (after V: <LF>) is received.",
        "> (U61", ".talk"),
    UNENDED := Rule("DP404", "a message that is never ended", W, INITIALISATION,
        "A message is obeyed when its terminator is received: <CR>, or <LF> if the data format was V.",
        "> (U61\\r\n> X100$", ".talk"),
    LOCKED := Rule("DP405", "sent while the interface is locked", W, LOCKOUT,
        "After `[` only status requests and `]` are obeyed, and `(` while DSR is held; everything else is ignored.",
        "[\nX100$\n]"),
)  # fmt: skip
