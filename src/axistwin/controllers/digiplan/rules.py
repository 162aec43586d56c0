"""Table of the diagnostic codes of the IF1 and IF2.

DP1xx: messages and commands.  DP2xx: sequences.  DP3xx: conflicting values.  DP4xx: initialisation, lock, message ends.
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
        "This character is not a command.  The whole message is refused and the data fault is flagged.  Commands are "
        "upper case; in a file of command lines `;` begins a comment.",
        "x1000$"),
    LOST_NUMBER := Rule("DP102", "a number without a command", E, ALL,
        "The preceding command takes no number, or a number of another form.  The message is refused.",
        "B20"),
    ALONE := Rule("DP103", "must be sent alone", E, ALL,
        "Status requests, `#`, `[` and `]` are messages by themselves, each with its own <CR>.",
        "X100 E"),
    SETUP := Rule("DP104", "for initialisation only", E, INITIALISATION,
        "`(`, `*`, `U` and `V` are obeyed during initialisation; afterwards they are a data fault.  Leave them out "
        "of a file of command lines: axistwin initialises the interface before the first line.",
        "U61"),
    MISPLACED := Rule("DP105", "a sign that is not valid here", E, ALL,
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
        "This command needs a number; the number is missing or malformed.",
        "@"),
    RANGE := Rule("DP109", "a parameter is out of range", E, ALL,
        "The value is refused and the range fault is flagged; nothing of the message is kept.",
        ">5"),
    TWICE := Rule("DP110", "an axis, / or G that does not fit the preceding text", E, ALL,
        "An axis, `/` or `G` is repeated in a message, or `/`, `G` or `B` has no axis before.",
        "X1X2$"),
    WAITS := Rule("DP111", "waiting for an input without a move", E, COMBINING,
        "H and L delay a move.  To wait for an input and then only switch an output, use a sequence.",
        "H1$"),
    MINOR := Rule("DP112", "the minor axis is missing", E, INTERPOLATION,
        "`/` is followed by the axis with the shorter distance, or by two axes.",
        "X200/$"),
    CORRECTION := Rule("DP113", "impossible backlash correction", E, "Backlash correction",
        "`B` without a number corrects an index of the same axis, but not a run or an interpolated move.",
        "X@500GB$"),
    CONTROL_ALONE := Rule("DP114", "% with other commands", E, INTERVENTION,
        "The step in which a sequence gives control to the host contains only `%`.",
        ":X100%:$"),
    SEQUENCE_END := Rule("DP201", "a sequence without its end", E, SEQUENCE,
        "A message that begins with `:` is a sequence, and ends in `:$`.",
        ":X100"),
    STEP_MISSING := Rule("DP202", "an empty step", E, SEQUENCE,
        "A step between two colons is empty.  The steps are numbered from 1.",
        ":X100::Y:$"),
    TOO_MANY := Rule("DP203", "too many steps", E, SEQUENCE,
        "A sequence has 63 steps at most.  The previously stored sequence is kept.",
        ":" + "X:" * 64 + "$"),
    REPEAT := Rule("DP204", "a repeat from a later step", E, REPEATS,
        "`=times,first` repeats from an earlier step or from its own step.",
        ":X100:=2,3:$"),
    NEVER_REACHED := Rule("DP205", "steps that are never reached", W, REPEATS,
        "`=0,n` repeats for ever; only `#` ends it.  Later steps are stored but never carried out.",
        ":X100:=0,1:Y:$"),
    RUN_CONTINUES := Rule("DP206", "a move that waits for a run to end", W, ABORT,
        "A run continues during the next steps.  A move must wait for the end of the run, and only `A` ends the run.",
        ":X@500G:X5:$"),
    NO_INTERVENTION := Rule("DP207", "% without a sequence that waits for the host", E, INTERVENTION,
        "`%` sent directly gives control back to a sequence that has given control to the host with a step `%`.",
        "%"),
    NOTHING_STORED := Rule("DP208", "no sequence to run again", W, SEQUENCE,
        "`:$` runs the stored sequence again, and none has been sent.  An IF2 may still have one in its battery-backed "
        "memory.",
        ":$"),
    TOO_FAST := Rule("DP301", "a speed above the maximum of the range", E, "Speed",
        "Each speed range has its highest speed: 25000, 50000, 100000 and 4000 steps/s in ranges 1 to 4.  Range and "
        "speed are kept from message to message.",
        "@25001"),
    CONSTRAINT := Rule("DP302", "beyond the constraints of linear interpolation", E, CONSTRAINTS,
        "Speed up to 10000 steps/s, acceleration from 5000 steps/s², major distance up to 65535 steps and not less "
        "than the minor one, speed range 1.",
        "@10001\nX200/Y100$"),
    NO_DISTANCE := Rule("DP303", "an index of no length", W, INDEX,
        "The distance is 0: no distance has been sent, or a run has set it to 0.  Nothing moves.",
        "X@500G$\nX$"),
    UNUSED_DISTANCE := Rule("DP304", "a distance that a run does not use", W, RUN,
        "G runs until it is stopped.  The distance is not used, and becomes 0 for later moves too.",
        "X1000G$"),
    NO_START := Rule("DP305", "a message without `$`", W, INDEX,
        "Without `$` the message only keeps its parameters: no move, no output, no run.",
        "S2"),
    TOO_EARLY := Rule("DP401", "sent before ( sets the baud rate", W, INITIALISATION,
        "After power-on the interface obeys only `(`, from which it detects the baud rate.",
        "+1.5\n> X100$\\r\n> (", ".talk"),
    FORMAT := Rule("DP402", "no data format", E, INITIALISATION,
        "`(` is followed by the data format: U or V, frame 1 to 8, parity 1 to 9.  U ends in <CR>, V in <CR><LF>.",
        "> (\n> U60\\r\n> U61\\r", ".talk"),
    FORMAT_UNENDED := Rule("DP403", "a data format without its end", W, INITIALISATION,
        "The format message is obeyed when its <CR> (after V: <LF>) is received.",
        "> (U61", ".talk"),
    UNENDED := Rule("DP404", "a message without its end", W, INITIALISATION,
        "A message is obeyed when its terminator is received: <CR>, or <LF> if the data format was V.",
        "> (U61\\r\n> X100$", ".talk"),
    LOCKED := Rule("DP405", "sent while the interface is locked", W, LOCKOUT,
        "After `[` only status requests and `]` are obeyed, and `(` while DSR is active; the rest is ignored.",
        "[\nX100$\n]"),
)  # fmt: skip
