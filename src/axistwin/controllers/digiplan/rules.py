"""Table of the diagnostic codes of the IF1 and IF2.

DP1xx: messages and commands.  DP2xx: sequences.  DP3xx: conflicting values.  DP4xx: initialisation, lock, message ends.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E, W = Severity.ERROR, Severity.WARNING

# Titles of chapters in the Digiplan manual
ALL, COMBINING = "Full command list", "Combining inputs and outputs with move instructions"
INTERPOLATION, CONSTRAINTS = "Linear interpolation mode", "Constraints in linear interpolation mode"
SEQUENCE, REPEATS = "Programming a sequence", "Repeating parts of a sequence"
ABORT, INTERVENTION = "Aborting a run-mode move in a sequence", "Controller intervention in a sequence"
INDEX, RUN = "Index mode instructions", "Run mode instructions"
INITIALISATION, LOCKOUT = "Initialisation", "Communication lockout commands"

RULES = (
    UNKNOWN := Rule("DP101", "the character is unknown", E, ALL,
        "This character is not a command.  The interface refuses the whole message and sets the data fault bit of the "
        "status answer F.  `axistwin commands if1` lists all commands, which are in upper case.  In a file of command "
        "lines, `;` begins a comment.",
        "x1000$"),
    LOST_NUMBER := Rule("DP102", "a number is in a place where no number is allowed", E, ALL,
        "Write each number directly after its command, for example `X1000`.  After the command `B`, a number needs a "
        "sign, for example `B+20`.  The interface refuses the whole message.",
        "B20"),
    ALONE := Rule("DP103", "the command must be the only command in its message", E, ALL,
        "Send a status request, for example `E`, as a separate message.  A message that contains a status request or "
        "one of the commands `#`, `[` and `]` must contain no other command.",
        "X100 E"),
    SETUP := Rule("DP104", "the command is allowed only during initialisation", E, INITIALISATION,
        "The interface obeys `(`, `*`, `U` and `V` only during initialisation.  After the initialisation, each of the "
        "commands `(`, `*`, `U` and `V` sets the data fault bit of the status answer F.  A file of command lines must "
        "not contain `(`, `*`, `U` or `V`, because axistwin itself initialises the interface.",
        "U61"),
    MISPLACED := Rule("DP105", "`$`, `:`, `+`, `-` or `,` is in a wrong position", E, ALL,
        "`$`, `:`, `+`, `-` and `,` are not commands, but parts of commands and messages.  `$` ends a message, and "
        "`:` separates the steps of a sequence.  `+` and `-` are allowed only after an axis or `B`, and `,` only "
        "after `P` or `=`.",
        "X$Y$"),
    NOT_IN_THIS_KIND := Rule("DP106", "the command is not allowed in this kind of message", E, ALL,
        "The commands `=` and `A` are allowed only in the steps of a sequence.  The commands `>`, `<`, `^` and `D` "
        "are allowed only in direct messages.",
        ":^5X100:$"),
    ORDER := Rule("DP107", "the commands are in a wrong order", E, COMBINING,
        "The commands in a message or a step have a fixed order: first the commands that wait for inputs (`H`, `L`), "
        "then the move, then the commands for outputs (`S`, `R`, `P`).  In a step without a move, write `H` and `L` "
        "first, then `A`, and then `=`.",
        "S1X100$"),
    NEEDS := Rule("DP108", "a parameter is missing", E, ALL,
        "Write a valid number after a command that needs a number, for example `@1000` instead of `@`.",
        "@"),
    RANGE := Rule("DP109", "a parameter is out of range", E, ALL,
        "The interface refuses the whole message and sets the out-of-range bit of the status answer F.",
        ">5"),
    TWICE := Rule("DP110", "an axis, `/`, `G` or `B` is not allowed in this place", E, ALL,
        "In a message or a step, each axis, `/` and `G` can occur only once.  Before `/`, `G` or `B`, write an axis.",
        "X1X2$"),
    WAITS := Rule("DP111", "a message waits for an input (H or L), but contains no move", E, COMBINING,
        "H and L delay a move until an input has the given level.  This message has no move to delay.  A sequence "
        "can wait for an input without a move: for example, `:H1S2:$` waits for input 1 and sets output 2.",
        "H1$"),
    MINOR := Rule("DP112", "an interpolated move has no axis after `/`", E, INTERPOLATION,
        "Before `/`, write the major axis, which moves the longest distance.  After `/`, write one or two minor axes, "
        "for example `X200/Y100$`.",
        "X200/$"),
    CORRECTION := Rule("DP113", "a backlash correction is not possible for this move", E, "Backlash correction",
        "To add the backlash correction to an index move, write `B` without a number after the axis.  A run-mode "
        "move and an interpolated move cannot have a backlash correction.",
        "X@500GB$"),
    CONTROL_ALONE := Rule("DP114", "% is not the only command in its step", E, INTERVENTION,
        "The command `%` gives control to the host.  If a step of a sequence contains the command `%`, the step must "
        "contain no other command.",
        ":X100%:$"),
    SEQUENCE_END := Rule("DP201", "the end of a sequence is missing", E, SEQUENCE,
        "A sequence begins with `:` and ends with `:$`, for example `:X100:Y200:$`.",
        ":X100"),
    STEP_MISSING := Rule("DP202", "a step of a sequence is empty", E, SEQUENCE,
        "Two colons of the sequence follow each other without a step between them.  The steps of a sequence are "
        "numbered from 1.  Remove one of the two colons, or write the missing step.",
        ":X100::Y:$"),
    TOO_MANY := Rule("DP203", "a sequence has too many steps", E, SEQUENCE,
        "A sequence can have at most 63 steps.  The interface does not store the new sequence, and keeps the "
        "old sequence.",
        ":" + "X:" * 64 + "$"),
    REPEAT := Rule("DP204", "a repeat command `=` names a later step", E, REPEATS,
        "`=times,first` repeats the steps from the step with the number `first` to the step that contains `=`.  For "
        "example, the command `=2,3` is not allowed in step 2, because step 3 is a later step.",
        ":X100:=2,3:$"),
    NEVER_REACHED := Rule("DP205", "some steps of a sequence are never executed", W, REPEATS,
        "`=0,n` repeats the steps from step n until the host sends `#`.  The steps after `=0,n` are stored but never "
        "executed.  For an end after some repeats, write a number of times, for example `=5,1`.",
        ":X100:=0,1:Y:$"),
    RUN_CONTINUES := Rule("DP206", "a move in a sequence must wait until a run-mode move ends", W, ABORT,
        "A run-mode move continues while the next steps of the sequence are executed.  The move of a later step begins "
        "only after the end of the run-mode move.  In a sequence, only the command `A` ends a run-mode move.",
        ":X@500G:X5:$"),
    NO_INTERVENTION := Rule("DP207", "% is sent, but no sequence waits for the host", E, INTERVENTION,
        "A step `%` of a sequence gives control to the host.  The host sends `%` to continue a sequence after a "
        "step `%`.",
        "%"),
    NOTHING_STORED := Rule("DP208", "`:$` is sent, but no sequence is stored", W, SEQUENCE,
        "After power-up, an IF1 has no stored sequence that the message `:$` could start.  An IF2 may still have an "
        "old sequence in its battery-backed memory.",
        ":$"),
    TOO_FAST := Rule("DP301", "the speed is above the maximum of the speed range", E, "Speed",
        "The highest speeds of the speed ranges 1 to 4 are 25000, 50000, 100000 and 4000 steps/s.  The interface "
        "keeps the range and the speed for later messages.",
        "@25001"),
    CONSTRAINT := Rule("DP302", "a move exceeds a limit of linear interpolation", E, CONSTRAINTS,
        "Linear interpolation needs speed range 1, a speed of at most 10000 steps/s and an acceleration of at least "
        "5000 steps/s².  In an interpolated move, for example `X200/Y100$`, the axis before `/` must have the longest "
        "distance.  The longest distance in an interpolated move is at most 65535 steps.",
        "@10001\nX200/Y100$"),
    NO_DISTANCE := Rule("DP303", "an index move has the distance 0", W, INDEX,
        "Nothing moves, because the distance is 0.  Either no distance has been sent, or a run-mode move has set the "
        "distance to 0.  Send a distance with the move, for example `X1000$`.",
        "X@500G$\nX$"),
    UNUSED_DISTANCE := Rule("DP304", "a run-mode move does not use the distance in the message", W, RUN,
        "G starts a run-mode move, which continues until the motor is stopped.  G ignores the distance in the message "
        "and sets the stored distance to 0.  After a run-mode move, the host must send a new distance for an index "
        "move.",
        "X1000G$"),
    NO_START := Rule("DP305", "a message does not contain `$`", W, INDEX,
        "If a message contains no `$`, the interface stores the parameters that the message contains.  A message "
        "without `$` starts no move and sets no output.",
        "S2"),
    TOO_EARLY := Rule("DP401", "a command is sent before `(` has set the baud rate", W, INITIALISATION,
        "After power-on the interface obeys only `(`.  The interface detects the baud rate from the character `(`.",
        "+1.5\n> X100$\\r\n> (", ".talk"),
    FORMAT := Rule("DP402", "the data format is missing or invalid", E, INITIALISATION,
        "After `(` the host must send the data format in three characters: U or V, a frame digit (1 to 8) and a "
        "parity digit (1 to 9).  With U, messages end in <CR>; with V, messages end in <CR><LF>.",
        "> (\n> U60\\r\n> U61\\r", ".talk"),
    FORMAT_UNENDED := Rule("DP403", "the end of a data format message is missing", W, INITIALISATION,
        "The data format takes effect when the interface receives the last character of the data format message.  The "
        "last character is <CR> in a message that begins with U, and <LF> in a message that begins with V.",
        "> (U61", ".talk"),
    UNENDED := Rule("DP404", "the end of a message is missing", W, INITIALISATION,
        "The interface executes a message only after the last character of the message.  If the data format begins "
        "with U, for example U61, each message ends in <CR>.  If the data format begins with V, for example V62, each "
        "message ends in <LF>.",
        "> (U61\\r\n> X100$", ".talk"),
    LOCKED := Rule("DP405", "a command is sent while the interface is locked", W, LOCKOUT,
        "After the command `[`, an IF1 or IF2 ignores most commands from the host until the host sends `]`.  A locked "
        "interface obeys only status requests, `]`, and, while DSR is active, `(`.",
        "[\nX100$\n]"),
)  # fmt: skip
