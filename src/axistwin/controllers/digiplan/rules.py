"""Table of the diagnostic codes of the IF1 and IF2.

DP1xx: messages and commands.  DP2xx: sequences.  DP3xx: conflicting values.  DP4xx: initialisation, lock, message ends.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E, W = Severity.ERROR, Severity.WARNING

# Names of chapters in the manual
ALL, COMBINING = "Full command list", "Combining inputs and outputs with move instructions"
INTERPOLATION, CONSTRAINTS = "Linear interpolation mode", "Constraints in linear interpolation mode"
SEQUENCE, REPEATS = "Programming a sequence", "Repeating parts of a sequence"
ABORT, INTERVENTION = "Aborting a run-mode move in a sequence", "Controller intervention in a sequence"
INDEX, RUN = "Index mode instructions", "Run mode instructions"
INITIALISATION, LOCKOUT = "Initialisation", "Communication lockout commands"

RULES = (
    UNKNOWN := Rule("DP101", "unknown character", E, ALL,
        "This character is not a command.  The interface refuses the whole message and sets the data fault.  "
        "Commands are upper case; in a file of command lines `;` begins a comment.",
        "x1000$"),
    LOST_NUMBER := Rule("DP102", "a number without a command", E, ALL,
        "The command before this number takes no number, or a number of another form.  The message is refused.",
        "B20"),
    ALONE := Rule("DP103", "must be sent alone", E, ALL,
        "Send each status request, `#`, `[` and `]` as a message of its own, with its own <CR>.",
        "X100 E"),
    SETUP := Rule("DP104", "for initialisation only", E, INITIALISATION,
        "The interface obeys `(`, `*`, `U` and `V` only during initialisation; later each of them sets the data fault. "
        " Leave them out of a file of command lines: axistwin initialises the interface before the first line.",
        "U61"),
    MISPLACED := Rule("DP105", "a sign that is not valid here", E, ALL,
        "`$`, `:`, `+`, `-` and `,` are parts of other commands: `$` ends a message, `:` divides the steps of a "
        "sequence, signs follow an axis or B, a comma follows P or =.",
        "X$Y$"),
    NOT_IN_THIS_KIND := Rule("DP106", "a command for another kind of message", E, ALL,
        "The commands `=` and `A` are valid only in steps of a sequence; `>`, `<`, `^` and `D` only in direct "
        "messages.",
        ":^5X100:$"),
    ORDER := Rule("DP107", "commands in a wrong order", E, COMBINING,
        "The commands in a message or a step have a fixed order: waiting for inputs (H, L), the move, then outputs "
        "(S, R, P).  In a step, A comes after the inputs and = at the end.",
        "S1X100$"),
    NEEDS := Rule("DP108", "a parameter is missing", E, ALL,
        "This command needs a number; the number is missing or malformed.",
        "@"),
    RANGE := Rule("DP109", "a parameter is out of range", E, ALL,
        "The interface refuses the whole message and sets the range fault.",
        ">5"),
    TWICE := Rule("DP110", "an axis, / or G that does not fit the preceding text", E, ALL,
        "An axis, `/` or `G` is repeated in a message, or `/`, `G` or `B` has no axis before.",
        "X1X2$"),
    WAITS := Rule("DP111", "waiting for an input without a move", E, COMBINING,
        "H and L delay a move.  To wait for an input and then only switch an output, use a sequence.",
        "H1$"),
    MINOR := Rule("DP112", "the minor axis is missing", E, INTERPOLATION,
        "`/` must be followed by the axis with the shorter distance, or by two axes.",
        "X200/$"),
    CORRECTION := Rule("DP113", "impossible backlash correction", E, "Backlash correction",
        "`B` without a number corrects an index of the same axis, but not a run or an interpolated move.",
        "X@500GB$"),
    CONTROL_ALONE := Rule("DP114", "% with other commands", E, INTERVENTION,
        "The step in which a sequence gives control to the host must contain `%` only.",
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
        "In `=times,first`, `first` must be the number of an earlier step or of the same step.",
        ":X100:=2,3:$"),
    NEVER_REACHED := Rule("DP205", "steps that are never reached", W, REPEATS,
        "`=0,n` repeats steps for ever, until the host sends `#`.  The steps after `=0,n` are stored but never "
        "carried out.",
        ":X100:=0,1:Y:$"),
    RUN_CONTINUES := Rule("DP206", "a move that waits for a run to end", W, ABORT,
        "A run continues during the next steps.  The move of a later step waits until the run ends, and in a sequence "
        "only `A` ends a run.",
        ":X@500G:X5:$"),
    NO_INTERVENTION := Rule("DP207", "% without a sequence that waits for the host", E, INTERVENTION,
        "`%` sent directly gives control back to a sequence that has given control to the host with a step `%`.",
        "%"),
    NOTHING_STORED := Rule("DP208", "no sequence to run again", W, SEQUENCE,
        "`:$` runs the stored sequence again, but no sequence has been sent.  An IF2 may still have an old sequence "
        "in its battery-backed memory.",
        ":$"),
    TOO_FAST := Rule("DP301", "a speed above the maximum of the range", E, "Speed",
        "The highest speeds of the speed ranges 1 to 4 are 25000, 50000, 100000 and 4000 steps/s.  The interface "
        "keeps the range and the speed for later messages.",
        "@25001"),
    CONSTRAINT := Rule("DP302", "beyond the constraints of linear interpolation", E, CONSTRAINTS,
        "Linear interpolation needs speed range 1, a speed up to 10000 steps/s and an acceleration from 5000 "
        "steps/s².  The longer distance is up to 65535 steps and belongs to the first axis.",
        "@10001\nX200/Y100$"),
    NO_DISTANCE := Rule("DP303", "an index of no length", W, INDEX,
        "The distance is 0: no distance has been sent, or a run has set it to 0.  Nothing moves.",
        "X@500G$\nX$"),
    UNUSED_DISTANCE := Rule("DP304", "a distance that a run does not use", W, RUN,
        "G runs the motor until it is stopped, so the distance in the message is not used.  The distance of later "
        "moves becomes 0 too.",
        "X1000G$"),
    NO_START := Rule("DP305", "a message without `$`", W, INDEX,
        "The interface stores the parameters of a message without `$`, but starts no move and sets no output.",
        "S2"),
    TOO_EARLY := Rule("DP401", "sent before ( sets the baud rate", W, INITIALISATION,
        "After power-on the interface obeys only `(`, from which it detects the baud rate.",
        "+1.5\n> X100$\\r\n> (", ".talk"),
    FORMAT := Rule("DP402", "no data format", E, INITIALISATION,
        "After `(` the host must send the data format: U or V, then a digit for the frame, 1 to 8, and one for the "
        "parity, 1 to 9.  With U, messages end in <CR>; with V, in <CR><LF>.",
        "> (\n> U60\\r\n> U61\\r", ".talk"),
    FORMAT_UNENDED := Rule("DP403", "a data format without its end", W, INITIALISATION,
        "The interface obeys the data format when it receives the <CR> at its end (for V: the <LF>).",
        "> (U61", ".talk"),
    UNENDED := Rule("DP404", "a message without its end", W, INITIALISATION,
        "The interface obeys a message when it receives the end of the message: <CR>, or <LF> if the data format is V.",
        "> (U61\\r\n> X100$", ".talk"),
    LOCKED := Rule("DP405", "sent while the interface is locked", W, LOCKOUT,
        "After `[` the interface obeys only status requests, `]`, and `(` while DSR is active.  It ignores all other "
        "commands.",
        "[\nX100$\n]"),
)  # fmt: skip
