"""Diagnostics of the SmartMotor checker: the table of codes.

The codes 1xx concern a command and its values, 2xx program flow, 3xx mode cam, 4xx changes of 4.76 against 4.15 and
4.40, 5xx the whole program and the host's serial line.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E, W = Severity.ERROR, Severity.WARNING

# Chapter titles that begin with a number are from the 4.76 manual.
# Chapter titles without a number are from the guide to the base language.
LEXICAL, EXPRESSIONS, FLOW, F_WORD = "Lexical rules", "Variables and mathematics", "Program flow", "7.0 F="
EQUAL, ARRAYS, CAM, ON_THE_FLY = "8.1 Forced equal sign", "8.2 Arrays", "9.1 Mode cam", "9.5 On-the-fly changes"
LIMITATIONS, HARD, BRAKE, HOST = (
    "9.4 Mode cam limitations",
    "3.1 Hardware limits",
    "5.1 Brake commands",
    "Communications",
)
WIRED = "UCI UDI ZS "

RULES = (
    UNKNOWN := Rule(
        "SM101", "unknown command", E, LEXICAL,
        "The motor sets the status bit Bs (syntax error) and continues with the next statement.",
        "FLY",
    ),
    REMOVED := Rule(
        "SM102", "a command that has been removed in 4.76", E, "1.3 Commands removed",
        "The command sets Bs.  The message names the replacement.",
        "KGON",
    ),
    EQUAL_SIGN := Rule(
        "SM103", "an assignment without its equal sign", E, EQUAL,
        "Before firmware 4.76, `A100` was the same as `A=100`; since 4.76, `A100` sets Bs (syntax error).",
        "A100",
    ),
    BLANKS := Rule(
        "SM104", "blanks around =", E, LEXICAL,
        "A blank ends a statement, so `a = 1` is three statements, and each sets Bs (syntax error).",
        "a =1",
    ),
    VALUE := Rule(
        "SM105", "a value where a command is expected", E, LEXICAL,
        "A variable alone sets Bs (syntax error).  To report its value, write R and the variable's name, e.g. Ra.",
        "a",
    ),
    CASE := Rule(
        "SM106", "a command in lower case", E, LEXICAL,
        "Commands are in upper case, variables in lower case.",
        "g=5 endif",
    ),
    NO_COMMENT := Rule(
        "SM107", "a line of punctuation that is not a comment", E, LEXICAL,
        "A comment begins with an apostrophe and ends at the end of the line.",
        "-----",
    ),
    PROGRAM_ONLY := Rule(
        "SM108", "a command for programs only", E, LEXICAL,
        "This command is valid only in a program; if a host sends it, the motor sets Bs (syntax error).",
        "> WAIT=5\\r", ".talk",
    ),
    NUMBER := Rule(
        "SM109", "a number in a command's name is out of range", E, LEXICAL,
        "Labels are numbers from 0 to 999, addresses from 0 to 120; any other number sets Bs (syntax error).",
        "GOSUB1000",
    ),
    RANGE := Rule(
        "SM110", "a value is out of range", E, LEXICAL,
        "The motor refuses the value and keeps the present one.",
        "E=40000",
    ),
    INDEX := Rule(
        "SM111", "an array index out of range", E, ARRAYS,
        "The valid elements are ab[0] to ab[203], aw[0] to aw[101] and al[0] to al[50]; the three arrays share one "
        "memory.",
        "a=aw[102]",
    ),
    EXPRESSION := Rule(
        "SM112", "an expression that cannot be read", E, EXPRESSIONS,
        "A value, an operator or a parenthesis is missing, or more text follows the expression.  The motor sets Bs.",
        "b=2+",
    ),
    VARIABLE := Rule(
        "SM113", "no such variable", E, EXPRESSIONS,
        "Variables are a…z, aa…zz and aaa…zzz; values of the motor have names in upper case, such as @P or CLK.",
        "a=FOO",
    ),
    ELEMENTS := Rule(
        "SM114", "a malformed list of array values", E, "1.1 Features added",
        "Write the values after the array element, with blanks between them and a period after the last value.",
        "aw[0] 1 2 3",
    ),
    PRINTED := Rule(
        "SM115", "something that cannot be printed", E, "Reports",
        "PRINT takes texts in quotes, expressions and codes of characters as #0 to #255, with commas between them, and "
        "ends with a parenthesis.",
        'PRINT("go)',
    ),
    ARGUMENTS := Rule(
        "SM116", "a command with wrong parameters", E, LEXICAL,
        "The parameters in parentheses, or the device and channel of an AniLink command, are invalid.",
        "VST(a)",
    ),
    OVERFLOW := Rule(
        "SM117", "a number that does not fit 32 bits", E, EXPRESSIONS,
        "The motor sets the status bit Bd (arithmetic overflow) and does not carry out the statement.",
        "a=3000000000",
    ),
    ZERO := Rule(
        "SM118", "a division by 0", E, EXPRESSIONS,
        "The motor sets the status bit Bd (arithmetic overflow) and does not carry out the statement.",
        "a=b/0",
    ),
    LATER := Rule(
        "SM119", "a word of Class 5 motors", E, LEXICAL,
        "Programs for the later generation do not run on 4.76: the motor sets Bs.  The message names the 4.76 word. "
        "Velocities and accelerations differ, because Class 5 has 8000 samples per second.",
        "PT=1000",
    ),
    BLOCK := Rule(
        "SM201", "a block without its end, or a part without its block", E, FLOW,
        "Each IF needs its ENDIF, each WHILE its LOOP and each SWITCH its ENDS.  A part without its counterpart sets "
        "Bs (syntax error).",
        "IF a",
    ),
    NO_LABEL := Rule(
        "SM202", "a missing label", E, FLOW,
        "A GOTO or GOSUB to a missing label sets Bs (syntax error), and the program continues with the next statement.",
        "GOTO5",
    ),
    LABEL_TWICE := Rule(
        "SM203", "a label defined twice", E, FLOW,
        "GOTO and GOSUB go to the first label.",
        "C5 a=1\nC5",
    ),
    RETURN := Rule(
        "SM204", "a return without a call", W, FLOW,
        "The program reaches RETURN without a GOSUB: RETURN sets Bs (syntax error) and ends the program.",
        "GOSUB5 C5 a=1 RETURN",
    ),
    OTHER_RETURN := Rule(
        "SM205", "the wrong return for this routine", W, F_WORD,
        "The routine C1, which a fault calls, ends with RETURNF; the routine C2, which pin G calls, ends with RETURNI.",
        "F=32 END C1 RETURN",
    ),
    STRAY_RETURN := Rule(
        "SM206", "RETURNF or RETURNI outside its routine", W, F_WORD,
        "RETURNF belongs to C1 and RETURNI to C2.",
        "GOSUB7 END C7 RETURNF",
    ),
    DEEP := Rule(
        "SM207", "more nested calls than the stack holds", E, FLOW,
        "The stack holds ten return addresses, including those of C1 and C2.",
        "F=96 GOSUB3 END C1 RETURNF C2 RETURNI"
        + "".join(f" C{n} GOSUB{n + 1} RETURN" for n in range(3, 12)) + " C12 RETURN",
    ),
    RECURSION := Rule(
        "SM208", "a routine that calls itself", W, FLOW,
        "Each call adds a return address to the stack, which holds ten.",
        "GOSUB5 END C5 GOSUB5 RETURN",
    ),
    CALLS_NOTHING := Rule(
        "SM209", "F= calls a missing label", W, F_WORD,
        "With F=32 a fault calls the routine C1, and with F=64 pin G calls C2; the program does not have "
        "this label.",
        "F=32 END",
    ),
    STACK := Rule(
        "SM210", "STACK without GOTO", W, F_WORD,
        "STACK discards all return addresses; a GOTO must follow.",
        "C5 STACK a=1 END",
    ),
    UNREACHED := Rule(
        "SM211", "statements that are never reached", W, FLOW,
        "Neither the program nor a call from the host reaches these statements.",
        "END a=1",
    ),
    SWITCHES := Rule(
        "SM212", "too many nested SWITCH", W, FLOW,
        "The guide allows four nested SWITCH.",
        "SWITCH a CASE 1 " * 5 + "ENDS " * 5,
    ),
    SIZE := Rule(
        "SM301", "a cam table that is too small", W, LIMITATIONS,
        "SIZE, the highest index of a cam table, should be 4 or more.  The motor accepts a smaller SIZE.",
        WIRED + "BASE=800 SIZE=3 MC G",
    ),
    TABLE := Rule(
        "SM302", "a cam table that is shorter than SIZE", W, CAM,
        "The table goes from aw[0] to aw[SIZE]; an entry that is not set has the old contents of the memory.",
        WIRED + "BASE=8000 SIZE=5 aw[0] 0 1 2 3 0. MC G",
    ),
    BASE := Rule(
        "SM303", "a cam cycle without length", E, CAM,
        "BASE, the number of counts of the master in one cam cycle, must be positive.",
        WIRED + "BASE=0 SIZE=5 MC",
    ),
    SHORT_BASE := Rule(
        "SM304", "a cam cycle that is too short for the master's speed", W, LIMITATIONS,
        "In one sample the master must move less than a quarter of BASE.",
        WIRED + "BASE=4 SIZE=4 MC",
    ),
    BASE_BELOW_SIZE := Rule(
        "SM305", "a cam cycle of fewer counts than table entries", E, CAM,
        "BASE must not be smaller than SIZE.",
        WIRED + "BASE=9 SIZE=10 MC",
    ),
    NOT_GIVEN := Rule(
        "SM306", "mode cam before BASE= or SIZE=", W, CAM,
        "MC uses the values that BASE and SIZE have when it is executed.",
        WIRED + "MC BASE=9 SIZE=5",
    ),
    NO_DWELL := Rule(
        "SM307", "a dwell without effect", W, ON_THE_FLY,
        "D= sets a dwell only with F=16 or F=128.",
        WIRED + "BASE=8000 SIZE=4 aw[0] 0 1 2 3 0. D=50 MC G",
    ),
    INVALID := Rule(
        "SM308", "a change that makes a CI invalid", W, ON_THE_FLY,
        "CI waits for the zero point of the cam; until then D=, BASE=, SIZE=, F= and MC cancel the CI.",
        WIRED + "BASE=8000 SIZE=4 aw[0] 0 1 2 3 0. MC G CI D=5",
    ),
    STALE := Rule(
        "SM309", "a CI without a new MC", W, ON_THE_FLY,
        "New values of BASE= and SIZE= take effect only after MC and then CI.",
        WIRED + "BASE=8000 SIZE=4 aw[0] 0 1 2 3 0. MC G BASE=9000 CI",
    ),
    NO_TABLE := Rule(
        "SM310", "a cam table without an interval", E, ON_THE_FLY,
        "The length of an interval of a cam table is BASE/SIZE.  With SIZE=0, MC sets Bs (syntax error) and nothing "
        "changes.",
        WIRED + "BASE=800 SIZE=0 MC",
    ),
    LIMITS := Rule(
        "SM401", "a move of a motor without limit switches", W, HARD,
        "Since firmware 4.76 the limit inputs are active high: a motor without wired limit switches has a limit fault "
        "when it is switched on.",
        "MP G",
    ),
    LIMIT_FAULTS := Rule(
        "SM402", "limit faults that are not cleared", W, HARD,
        "UCI and UDI make the limit pins ordinary inputs, but the program must also clear the limit fault that the "
        "motor has since it was switched on.",
        "UCI UDI G",
    ),
    DIRECTION := Rule(
        "SM403", "F=2 has a new meaning", W, "1.4 Commands modified",
        "Since firmware 4.76, F=2 reverses the direction of the shaft.",
        "F=2",
    ),
    ENDS_PROGRAM := Rule(
        "SM404", "a fault that the program cannot test for", W, "4.3 Fault handling",
        "Since firmware 4.76 a position error or overheating ends the program, unless F=32 is set and the fault calls "
        "C1.",
        "IF Be a=1 ENDIF",
    ),
    SOFT_LIMITS := Rule(
        "SM405", "software limits changed while they are enabled", E, "3.2 Software limits",
        "The motor refuses the new value: disable the limits with SLD, change them, then enable them with SLE.",
        "SLE SLN=5",
    ),
    BRAKE_PIN := Rule(
        "SM406", "a brake pin that is not an output", W, BRAKE,
        "Make the pin an output with UCO or UGO before BRKC or BRKG.",
        "BRKG",
    ),
    BRAKE_USED := Rule(
        "SM407", "a brake pin that is used for something else", W, BRAKE,
        "While the pin drives the brake, the program must not use the pin.",
        "UGO BRKG\na=UG",
    ),
    TOO_LONG := Rule(
        "SM501", "a program that does not fit", E, "Program storage",
        "The motor stores 32 KiB.",
        "a=1 \n" * 9000,
    ),
    LONG_COMMAND := Rule(
        "SM502", "a command of more than 64 characters", E, HOST,
        "The motor drops the command and sets Bc.",
        "> " + "x" * 70 + "\\r", ".talk",
    ),
    UNENDED := Rule(
        "SM503", "a command without its end", W, HOST,
        "The motor executes a command when it receives a blank or <CR> after it.",
        "> RP", ".talk",
    ),
    DOWNLOAD := Rule(
        "SM504", "a download without its end", E, "Program storage",
        "After LOAD the motor stores all characters as the program until it receives FFh FFh.",
        "> LOAD\\r\n> GOTO5 C5 END", ".talk",
    ),
)  # fmt: skip
