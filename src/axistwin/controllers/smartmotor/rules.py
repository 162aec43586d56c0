"""Diagnostics of the SmartMotor checker: the table of codes.

The codes 1xx concern a command and its values, 2xx program flow, 3xx mode cam, 4xx changes of 4.76 against 4.15 and
4.40, 5xx the whole program and the host's serial line.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E, W = Severity.ERROR, Severity.WARNING

# Chapter titles with a number, e.g. "8.2 Arrays", refer to the manual of firmware 4.76.
# Chapter titles without a number, e.g. "Program flow", refer to the guide to the SmartMotor command language.
LEXICAL, EXPRESSIONS, FLOW, F_WORD = "Lexical rules", "Variables and mathematics", "Program flow", "7.0 F="
EQUAL, ARRAYS, CAM, ON_THE_FLY = "8.1 Forced equal sign", "8.2 Arrays", "9.1 Mode cam", "9.5 On-the-fly changes"
LIMITATIONS, HARD = "9.4 Mode cam limitations", "3.1 Hardware limits"
BRAKE, HOST = "5.1 Brake commands", "Communications"
WIRED = "UCI UDI ZS "

RULES = (
    UNKNOWN := Rule("SM101", "the command is unknown", E, LEXICAL,
        "The motor sets the status bit Bs (syntax error) and continues with the next statement.  "
        "`axistwin commands smartmotor` lists all commands.  A comment begins with an apostrophe.",
        "FLY"),
    REMOVED := Rule("SM102", "the command does not exist in firmware 4.76", E, "1.3 Commands removed",
        "Firmware 4.76 lacks some commands of earlier firmware.  A motor with firmware 4.76 sets the status bit Bs "
        "(syntax error) when the motor executes a command that only earlier firmware has.  The error message says "
        "what to write instead of the old command.",
        "KGON"),
    EQUAL_SIGN := Rule("SM103", "the equal sign of an assignment is missing", E, EQUAL,
        "Before firmware 4.76, `A100` was the same as `A=100`.  Since firmware 4.76, `A100` sets the status bit Bs "
        "(syntax error).",
        "A100"),
    BLANKS := Rule("SM104", "there are blanks before or after =", E, LEXICAL,
        "A blank ends a statement.  The blanks divide `a = 1` into three statements, and each of the three statements "
        "sets the status bit Bs (syntax error).",
        "a =1"),
    VALUE := Rule("SM105", "a value is written instead of a command", E, LEXICAL,
        "A statement that contains only the name of a variable sets the status bit Bs (syntax error).  To report the "
        "value of a variable, write R and its name, for example Ra, or PRINT, for example PRINT(P,#13).",
        "a"),
    CASE := Rule("SM106", "a command is in lower case", E, LEXICAL,
        "Commands are in upper case, variables in lower case.",
        "g=5 endif"),
    NO_COMMENT := Rule("SM107", "the apostrophe before a separating line such as `-----` is missing", E, LEXICAL,
        "A comment begins with an apostrophe and ends at the end of the line.  To separate the parts of a program by "
        "a line of hyphens, write the line as a comment, for example `'-----`.",
        "-----"),
    PROGRAM_ONLY := Rule("SM108", "the command is allowed only in a program", E, LEXICAL,
        "If a host sends a command that is valid only in a program, for example WAIT=5, the motor sets the status bit "
        "Bs (syntax error).",
        "> WAIT=5\\r", ".talk"),
    NUMBER := Rule("SM109", "the number in the name of a command is out of range", E, LEXICAL,
        "The number of a label must be from 0 to 999, and an address must be from 0 to 120.  If the number is out of "
        "range, the motor sets the status bit Bs (syntax error).",
        "GOSUB1000"),
    RANGE := Rule("SM110", "a value is out of range", E, LEXICAL,
        "The motor does not execute an assignment with a value that is out of range, and keeps the old value.",
        "E=40000"),
    INDEX := Rule("SM111", "an array index is out of range", E, ARRAYS,
        "The valid array elements are ab[0] to ab[203], aw[0] to aw[101] and al[0] to al[50].  The three arrays share "
        "one memory.",
        "a=aw[102]"),
    EXPRESSION := Rule("SM112", "an expression is not valid", E, EXPRESSIONS,
        "A value, an operator or a parenthesis is missing, or more text follows the expression.  The motor sets the "
        "status bit Bs (syntax error).",
        "b=2+"),
    VARIABLE := Rule("SM113", "the variable does not exist", E, EXPRESSIONS,
        "The name of a variable is one lower-case letter, or the same lower-case letter two or three times, for "
        "example a, bb or ccc.  The motor's built-in values have names in upper case, for example @P or CLK.",
        "a=FOO"),
    ELEMENTS := Rule("SM114", "a list of array values is malformed", E, "1.1 Features added",
        "To assign values to successive array elements, write for example `aw[0] 1 2 3.`, with blanks between the "
        "values and a period after the last value.",
        "aw[0] 1 2 3"),
    PRINTED := Rule("SM115", "an item of PRINT is not valid", E, "Reports",
        "The items of PRINT are texts in quotes, expressions and character codes from #0 to #255.  Write commas "
        "between the items of PRINT, and close the parenthesis, for example `PRINT(\"x=\",a,#13)`.",
        'PRINT("go)'),
    ARGUMENTS := Rule("SM116", "the parameters of a command are wrong", E, LEXICAL,
        "The parameters in parentheses, or the device and channel of an AniLink command, are invalid.",
        "VST(a)"),
    OVERFLOW := Rule("SM117", "a number needs more than 32 bits", E, EXPRESSIONS,
        "The motor sets the status bit Bd (arithmetic overflow) and does not execute the statement.",
        "a=3000000000"),
    ZERO := Rule("SM118", "an expression divides by 0", E, EXPRESSIONS,
        "The motor sets the status bit Bd (arithmetic overflow) and does not execute the statement.",
        "a=b/0"),
    LATER := Rule("SM119", "the command exists only in Class 5 motors", E, LEXICAL,
        "Programs for Class 5 motors do not work with firmware 4.76: the motor sets the status bit Bs (syntax error).  "
        "The error message gives the equivalent command of firmware 4.76.  A Class 5 motor has 8000 samples per "
        "second, and a motor with firmware 4.76 has 4069 samples per second.  Velocities and accelerations are "
        "measured per sample, so convert these values for firmware 4.76.",
        "PT=1000"),
    ADDRESS := Rule("SM120", "the address of a motor is written in digits", E, HOST,
        "An address is one byte before a command, 128 plus the number of the motor: 81h for motor 1, 80h for all "
        "motors.  In a conversation write `\\x81RP`; in a program, for example `PRINT(#129,\"RP \")`.",
        "> 1RP\\r", ".talk"),
    BLOCK := Rule("SM201", "the beginning or the end of a block is missing", E, FLOW,
        "Each IF needs an ENDIF, each WHILE needs a LOOP, and each SWITCH needs an ENDS.  A statement of an incomplete "
        "block, for example an ELSE without an IF, sets the status bit Bs (syntax error).",
        "IF a"),
    NO_LABEL := Rule("SM202", "a label is missing", E, FLOW,
        "If the label of a GOTO or GOSUB is missing, the motor sets the status bit Bs (syntax error), and executes "
        "the next statement of the program.",
        "GOTO5"),
    LABEL_TWICE := Rule("SM203", "a label is defined twice", E, FLOW,
        "If two labels of a program have the same number, GOTO and GOSUB always go to the first of the two labels.  "
        "Give each label a number of its own.",
        "C5 a=1\nC5"),
    RETURN := Rule("SM204", "the program reaches RETURN without a GOSUB", W, FLOW,
        "RETURN without an earlier GOSUB sets the status bit Bs (syntax error) and ends the program.  Write END before "
        "the first subroutine.",
        "GOSUB5 C5 a=1 RETURN"),
    OTHER_RETURN := Rule("SM205", "the routine C1 or C2 ends with the wrong return command", W, F_WORD,
        "A fault calls the routine C1, which must end with RETURNF.  Pin G calls the routine C2, which must end with "
        "RETURNI.",
        "F=32 END C1 RETURN"),
    STRAY_RETURN := Rule("SM206", "RETURNF is outside C1, or RETURNI is outside C2", W, F_WORD,
        "RETURNF is allowed only in the routine C1, and RETURNI only in the routine C2.  End other routines with "
        "RETURN.",
        "GOSUB7 END C7 RETURNF"),
    DEEP := Rule("SM207", "nested calls need more return addresses than the stack holds", E, FLOW,
        "The stack has space for ten return addresses, including those of the routines C1 and C2.",
        "F=96 GOSUB3 END C1 RETURNF C2 RETURNI"
        + "".join(f" C{n} GOSUB{n + 1} RETURN" for n in range(3, 12)) + " C12 RETURN"),
    RECURSION := Rule("SM208", "a subroutine calls itself", W, FLOW,
        "Each call of the subroutine puts a return address on the stack.  The stack has space for only ten return "
        "addresses.  Repeat statements with WHILE and LOOP instead.",
        "GOSUB5 END C5 GOSUB5 RETURN"),
    CALLS_NOTHING := Rule("SM209", "F= selects a routine whose label is missing", W, F_WORD,
        "With F=32, a fault calls the routine C1.  With F=64, pin G calls the routine C2.  The program does not "
        "contain the label of the selected routine.",
        "F=32 END"),
    STACK := Rule("SM210", "STACK is not followed by GOTO", W, F_WORD,
        "STACK discards all return addresses, so RETURN is no longer possible.  The next statement after STACK must "
        "be a GOTO.",
        "C5 STACK a=1 END"),
    UNREACHED := Rule("SM211", "some statements are never reached", W, FLOW,
        "For example, the motor never executes the statement a=1 in the program `END a=1`.  Remove such statements, or "
        "put a label before them.",
        "END a=1"),
    SWITCHES := Rule("SM212", "too many SWITCH blocks are nested", W, FLOW,
        "The guide to the SmartMotor language allows at most four nested SWITCH blocks.",
        "SWITCH a CASE 1 " * 5 + "ENDS " * 5),
    SIZE := Rule("SM301", "the cam table is too small", W, LIMITATIONS,
        "SIZE is the highest index of the cam table.  The command SIZE= should set a value of 4 or more, but the "
        "motor accepts a smaller value.",
        WIRED + "BASE=800 SIZE=3 MC G"),
    TABLE := Rule("SM302", "the cam table has fewer entries than SIZE requires", W, CAM,
        "The cam table is in the array elements aw[0] to aw[SIZE].  If the program assigns no value to an array "
        "element, the element keeps its old value.",
        WIRED + "BASE=8000 SIZE=5 aw[0] 0 1 2 3 0. MC G"),
    BASE := Rule("SM303", "the length of a cam cycle is not positive", E, CAM,
        "BASE is the length of a cam cycle, in counts of the master.  BASE must be positive.",
        WIRED + "BASE=0 SIZE=5 MC"),
    SHORT_BASE := Rule("SM304", "the cam cycle is too short for the speed of the master", W, LIMITATIONS,
        "BASE is the length of a cam cycle, in counts of the master.  In one sample, the master must move less than a "
        "quarter of BASE.",
        WIRED + "BASE=4 SIZE=4 MC"),
    BASE_BELOW_SIZE := Rule("SM305", "the cam cycle has fewer counts than the cam table has intervals", E, CAM,
        "BASE, the length of the cam cycle in counts, must not be smaller than SIZE, the number of intervals.",
        WIRED + "BASE=9 SIZE=10 MC"),
    NOT_GIVEN := Rule("SM306", "the command MC comes before BASE= or SIZE=", W, CAM,
        "MC uses the values that BASE and SIZE have when MC is executed.  Assign BASE and SIZE before MC.",
        WIRED + "MC BASE=9 SIZE=5"),
    NO_DWELL := Rule("SM307", "a dwell has no effect", W, ON_THE_FLY,
        "D= sets a dwell of the cam only with F=16 or F=128.",
        WIRED + "BASE=8000 SIZE=4 aw[0] 0 1 2 3 0. D=50 MC G"),
    INVALID := Rule("SM308", "a later command can cancel CI", W, ON_THE_FLY,
        "CI takes effect at the next zero point of the cam.  The commands D=, BASE=, SIZE=, F= and MC cancel CI if "
        "CI has not taken effect yet.",
        WIRED + "BASE=8000 SIZE=4 aw[0] 0 1 2 3 0. MC G CI D=5"),
    STALE := Rule("SM309", "a new value of BASE= or SIZE= has no effect without MC", W, ON_THE_FLY,
        "A new value of BASE= or SIZE= takes effect only after two further commands: first MC, then CI.",
        WIRED + "BASE=8000 SIZE=4 aw[0] 0 1 2 3 0. MC G BASE=9000 CI"),
    NO_TABLE := Rule("SM310", "the cam table has no interval, because SIZE is 0", E, ON_THE_FLY,
        "The length of an interval of a cam table is BASE/SIZE.  With SIZE=0, MC sets the status bit Bs (syntax "
        "error) and has no other effect.",
        WIRED + "BASE=800 SIZE=0 MC"),
    LIMITS := Rule("SM401", "the program moves a motor that may have no limit switches", W, HARD,
        "Since firmware 4.76, a limit input of a SmartMotor reports a limit while the limit input is high.  A limit "
        "input without a wired switch is high, so a motor without limit switches has a limit fault at power-up.",
        "MP G"),
    LIMIT_FAULTS := Rule("SM402", "the program does not clear the limit faults that occur at power-up", W, HARD,
        "UCI and UDI make the limit pins ordinary inputs, but do not clear the limit faults that occur at power-up.  "
        "To clear the limit faults, the program needs a command such as ZS.",
        "UCI UDI G"),
    DIRECTION := Rule("SM403", "the meaning of F=2 has changed in firmware 4.76", W, "1.4 Commands modified",
        "Since firmware 4.76, F=2 reverses the direction of the shaft.  In earlier firmware, the command F=2 allowed "
        "the motor to report scan errors (errors in received commands) to the host.  Unless the program is to reverse "
        "the direction, take 2 from the value of F=: write F=32 instead of F=34.",
        "F=2"),
    ENDS_PROGRAM := Rule(
        "SM404", "a fault ends the program before the program can test for the fault", W, "4.3 Fault handling",
        "Since firmware 4.76, a position error or overheating ends the program.  With F=32, a position error or "
        "overheating does not end the program, but calls the routine C1.",
        "IF Be a=1 ENDIF"),
    SOFT_LIMITS := Rule("SM405", "the value of an enabled software limit is changed", E, "3.2 Software limits",
        "The motor refuses the new value.  Disable the software limits with SLD, change the values, then enable the "
        "limits with SLE.",
        "SLE SLN=5"),
    BRAKE_PIN := Rule("SM406", "the pin for the brake is not an output", W, BRAKE,
        "Make the pin an output with UCO or UGO before the command BRKC or BRKG.",
        "BRKG"),
    BRAKE_USED := Rule("SM407", "the pin for the brake is used for another purpose", W, BRAKE,
        "While a pin controls the brake, the program must not use this pin.  BRKI ends this: only the internal brake "
        "is then controlled.",
        "UGO BRKG\na=UG"),
    TOO_LONG := Rule("SM501", "the program is too long for the memory of the motor", E, "Program storage",
        "The motor stores a program of at most 32 KiB.",
        "a=1 \n" * 9000),
    LONG_COMMAND := Rule("SM502", "a command has more than 64 characters", E, HOST,
        "The motor drops the command and sets the status bit Bc (communications overflow).",
        "> " + "x" * 70 + "\\r", ".talk"),
    UNENDED := Rule("SM503", "the end of a command is missing", W, HOST,
        "The motor executes a command only after the blank or <CR> at the end of the command.",
        "> RP", ".talk"),
    DOWNLOAD := Rule("SM504", "the end of a download is missing", E, "Program storage",
        "After LOAD, the motor stores all characters as the program, until the motor receives the bytes FFh FFh.",
        "> LOAD\\r\n> GOTO5 C5 END", ".talk"),
)  # fmt: skip
