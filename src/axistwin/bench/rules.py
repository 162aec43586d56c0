"""What is found in our own kinds of text, whatever the family: the table of codes of conversations and scenes.

AX1xx the lines of a program or conversation, SC1xx scenes.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E = Severity.ERROR
PAGE, SCENES = "docs/conversations.md", "docs/scenes.md"
IF1 = '[[controller]]\nmodel = "if1"\n'

RULES = (
    UNREADABLE := Rule(
        "AX100", "a line that cannot be read", E, PAGE,
        "It is no line of this kind of file; the message says what is wanted.",
        "; model: 1811\n> ; nothing", ".talk",
    ),
    NO_ACT := Rule(
        "AX101", "no act of a conversation", E, PAGE,
        "Each line begins with `;`, `+`, `>`, `<`, `!` or `=`, or with a controller's name and a colon before that.",
        "?what", ".talk",
    ),
    NO_TIME := Rule(
        "AX102", "no time", E, PAGE,
        "Behind `+` stands a number of seconds, such as 0.25.",
        "+soon", ".talk",
    ),
    NO_VALUE := Rule(
        "AX103", "a name or a value is missing", E, PAGE,
        "`!` and `=` take a name and a value: `! input1 high`, `= X.position 1000`.",
        "! input1", ".talk",
    ),
    NO_ASCII := Rule(
        "AX104", "no ASCII character", E, PAGE,
        "A host sends bytes.  Printable ASCII is written as it is, anything else in a conversation as \\xNN.",
        "X100é$", ".if1",
    ),
    NO_ESCAPE := Rule(
        "AX105", "an escape that means nothing", E, PAGE,
        "There are \\r, \\n, \\\\ and \\xNN with two hex digits.",
        "> X100\\q", ".talk",
    ),
    NO_TOML := Rule(
        "SC101", "not TOML", E, SCENES,
        "The file cannot be read as TOML; nothing else of it has been looked at.",
        '[[controller]\nmodel = "if1"', ".toml",
    ),
    UNKNOWN_KEY := Rule(
        "SC102", "an unknown key", E, SCENES,
        "Keys that are not known are refused, so that no misspelling goes unnoticed.",
        IF1 + 'nmae = "left"', ".toml",
    ),
    MISSING_KEY := Rule(
        "SC103", "a key is missing", E, SCENES,
        "This table needs it.",
        '[[controller]]\nname = "left"', ".toml",
    ),
    VALUE := Rule(
        "SC104", "a value that cannot be", E, SCENES,
        "It is of another type, or out of its range.",
        IF1 + "axes.X.limits = [100, 0]", ".toml",
    ),
    SCENE := Rule(
        "SC110", "a scene that cannot be built", E, SCENES,
        "Each table is right by itself, but something it names is not there, stands twice, or does not go together.",
        IF1 + '[[wire]]\nfrom = "if1.output1"\nto = "if1.inptu1"', ".toml",
    ),
)  # fmt: skip
"""All of them, in the order of the codes."""
