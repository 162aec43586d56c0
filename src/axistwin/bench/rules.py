"""Diagnostics that all families share: the table of codes of conversations and scenes.

AX1xx: lines of a program or conversation, SC1xx: scenes.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E = Severity.ERROR
PAGE, SCENES = "docs/conversations.md", "docs/scenes.md"
IF1 = '[[controller]]\nmodel = "if1"\n'

RULES = (
    UNREADABLE := Rule(
        "AX100", "a line that cannot be read", E, PAGE,
        "A file of this kind cannot contain such a line; the message says what is expected.",
        "; model: 1811\n> ; nothing", ".talk",
    ),
    NO_ACT := Rule(
        "AX101", "not a line of a conversation", E, PAGE,
        "Each line begins with `;`, `+`, `>`, `<`, `!` or `=`, or with a controller's name and a colon before that.",
        "?what", ".talk",
    ),
    NO_TIME := Rule(
        "AX102", "an invalid time", E, PAGE,
        "After `+` write a number of seconds, e.g. +0.25.",
        "+soon", ".talk",
    ),
    NO_VALUE := Rule(
        "AX103", "a name or a value is missing", E, PAGE,
        "After `!` and `=` write a name and a value: `! input1 high`, `= X.position 1000`.",
        "! input1", ".talk",
    ),
    NO_ASCII := Rule(
        "AX104", "a character that is not ASCII", E, PAGE,
        "A host sends bytes.  Write printable ASCII as it is, and other bytes in a conversation as \\xNN.",
        "X100é$", ".if1",
    ),
    NO_ESCAPE := Rule(
        "AX105", "an unknown escape sequence", E, PAGE,
        "The valid escape sequences are \\r, \\n, \\\\ and \\xNN with two hex digits.",
        "> X100\\q", ".talk",
    ),
    NO_TOML := Rule(
        "SC101", "not TOML", E, SCENES,
        "The file cannot be read as TOML; the rest of the file has not been checked.",
        '[[controller]\nmodel = "if1"', ".toml",
    ),
    UNKNOWN_KEY := Rule(
        "SC102", "an unknown key", E, SCENES,
        "The table cannot have a key of this name; perhaps the name is misspelled.",
        IF1 + 'nmae = "left"', ".toml",
    ),
    MISSING_KEY := Rule(
        "SC103", "a key is missing", E, SCENES,
        "This table needs the key.",
        '[[controller]]\nname = "left"', ".toml",
    ),
    VALUE := Rule(
        "SC104", "an invalid value", E, SCENES,
        "The value is of a wrong type, or out of range.",
        IF1 + "axes.X.limits = [100, 0]", ".toml",
    ),
    SCENE := Rule(
        "SC110", "a scene that cannot be built", E, SCENES,
        "Each table of the scene is valid, but a name in a table does not exist, is used twice, or does not fit the "
        "other tables.",
        IF1 + '[[wire]]\nfrom = "if1.output1"\nto = "if1.inptu1"', ".toml",
    ),
)  # fmt: skip
