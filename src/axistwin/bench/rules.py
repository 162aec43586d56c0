"""Diagnostics that all families share: the table of codes of conversations and scenes.

AX1xx: lines of a program or conversation, SC1xx: scenes.
"""

from axistwin.controllers.diagnostics import Rule, Severity

E = Severity.ERROR
PAGE, SCENES = "docs/conversations.md", "docs/scenes.md"
IF1 = '[[controller]]\nmodel = "if1"\n'

RULES = (
    UNREADABLE := Rule("AX100", "a line is not allowed in this type of file", E, PAGE,
        "Each type of file permits only certain texts in a line, for example commands of a host in an `.if1` file.  "
        "The error message says which text axistwin expected in the line.",
        "; model: 1811\n> ; nothing", ".talk"),
    NO_ACT := Rule("AX101", "a line begins with a wrong character", E, PAGE,
        "Each line of a conversation begins with `;`, `+`, `>`, `<`, `!`, `=` or the name of a controller, for example "
        "`table: > K`.",
        "?what", ".talk"),
    NO_TIME := Rule("AX102", "a time is invalid", E, PAGE,
        "After `+`, write a number of seconds, for example `+0.25`.",
        "+soon", ".talk"),
    NO_VALUE := Rule("AX103", "a name or a value is missing after `!` or `=`", E, PAGE,
        "A line with `!` or `=` needs a name and a value, for example `= X.position 1000` or `!input1 high`.",
        "! input1", ".talk"),
    NO_ASCII := Rule("AX104", "a character is not ASCII", E, PAGE,
        "A host sends bytes.  Write a printable ASCII character as the character itself, for example `X`.  In a "
        "conversation, write any other byte as `\\xNN`, where NN is the byte in hex, for example `\\x0D`.",
        "X100é$", ".if1"),
    NO_ESCAPE := Rule("AX105", "an escape sequence is unknown", E, PAGE,
        "The valid escape sequences are \\r, \\n, \\\\ and \\xNN, where NN is two hex digits.",
        "> X100\\q", ".talk"),
    TYPOGRAPHIC := Rule("AX106", "a quotation mark, a minus or a space is a typographic character", E, PAGE,
        "A text from a word processor or a web page may have typographic characters, for example `−` for `-`.  Write "
        "the character of the keyboard, or let `axistwin check --fix` write it.",
        "X−100$", ".if1"),
    NO_TOML := Rule("SC101", "the file is not valid TOML", E, SCENES,
        "The file cannot be read as TOML.  After a TOML error, axistwin does not check the rest of the file.",
        '[[controller]\nmodel = "if1"', ".toml"),
    UNKNOWN_KEY := Rule("SC102", "the name of a key is unknown", E, SCENES,
        "Each table of a scene, for example `[[controller]]`, permits only keys with certain names.  The name of the "
        "key may be misspelled.",
        IF1 + 'nmae = "left"', ".toml"),
    MISSING_KEY := Rule("SC103", "a key is missing", E, SCENES,
        "This table must contain the missing key.",
        '[[controller]]\nname = "left"', ".toml"),
    VALUE := Rule("SC104", "a value is invalid", E, SCENES,
        "The value has a wrong type or is out of range.",
        IF1 + "axes.X.limits = [100, 0]", ".toml"),
    SCENE := Rule("SC110", "the scene cannot be built", E, SCENES,
        "Each table of the scene is valid, but the tables together are not valid.  A scene cannot be built, for "
        "example, if a wire refers to a pin that does not exist, or if two controllers have the same name.",
        IF1 + '[[wire]]\nfrom = "if1.output1"\nto = "if1.inptu1"', ".toml"),
)  # fmt: skip
