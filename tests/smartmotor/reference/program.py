"""Independent reference of programs and expressions (6 to 8 of the base language): an interpreter of a syntax tree.

Nothing is compiled: statements and blocks refer to each other.  Arrays are bytes, as in table 8.1.
"""

import re
from dataclasses import dataclass, field

LOW, HIGH = -(2**31), 2**31 - 1


class Abandoned(Exception):  # noqa: N818
    """An abandoned statement; `flag` is the error flag."""

    def __init__(self, flag):
        super().__init__(flag)
        self.flag = flag


def fits(value):
    """Return a value of 32 bits; a larger value abandons the statement with Bd."""
    if not LOW <= value <= HIGH:
        raise Abandoned("Bd")
    return value


def truncated(left, right):
    """Divide towards zero."""
    if right == 0:
        raise Abandoned("Bd")
    whole = abs(left) // abs(right)
    return whole if (left >= 0) == (right > 0) else -whole


def power(left, right):
    if not 0 <= right <= 4:
        raise Abandoned("Bd")
    return left**right


OPERATORS = (  # from the lowest precedence to the highest (7)
    {"|": lambda a, b: a | b},
    {"!|": lambda a, b: a ^ b},
    {"&": lambda a, b: a & b},
    {
        "==": lambda a, b: int(a == b),
        "!=": lambda a, b: int(a != b),
        "<=": lambda a, b: int(a <= b),
        ">=": lambda a, b: int(a >= b),
        "<": lambda a, b: int(a < b),
        ">": lambda a, b: int(a > b),
    },
    {"+": lambda a, b: a + b, "-": lambda a, b: a - b},
    {"*": lambda a, b: a * b, "/": truncated, "%": lambda a, b: a - b * truncated(a, b)},
    {"^": power},
)
FETCHING = "IF", "WHILE", "SWITCH", "WAIT", "let", "element"
WIDTHS = {"ab": 1, "aw": 2, "al": 4}


class Memory:
    """Variables and arrays.  With `overlay` al[0]…al[50] are aa…zz and aaa…yyy (6 of the base language)."""

    def __init__(self, overlay=True):
        self.overlay = overlay
        self.bytes = bytearray(204)
        self.named = {}

    def __getitem__(self, name):
        place = self._place(name)
        return self.element("al", place) if place is not None else self.named.get(name, 0)

    def __setitem__(self, name, value):
        place = self._place(name)
        if place is None:
            self.named[name] = value
        else:
            self.set_element("al", place, value)

    def _place(self, name):
        """Return the place of a long in the arrays."""
        place = 26 * (len(name) - 2) + ord(name[0]) - ord("a")
        return place if self.overlay and 0 <= place < 51 else None

    def _slice(self, array, index):
        width = WIDTHS[array]
        if not 0 <= index < 204 // width:
            raise Abandoned("Bu")
        return slice(index * width, (index + 1) * width)

    def element(self, array, index):
        return int.from_bytes(self.bytes[self._slice(array, index)], "big", signed=True)

    def set_element(self, array, index, value):
        part = self._slice(array, index)
        self.bytes[part] = (value % 2**32).to_bytes(4, "big")[-WIDTHS[array] :]


# Expressions: functions of the motor


class Text:
    """The text of an expression, and how far it has been read."""

    def __init__(self, text):
        self.tokens = re.findall(r"@P?E?V?|[A-Z][A-Za-z]*\d*|[a-z]+|\d+|!\||[=!<>]=|.", text)
        assert "".join(self.tokens) == text

    def take(self, *wanted):
        if self.tokens and (not wanted or self.tokens[0] in wanted):
            return self.tokens.pop(0)
        return None

    def binary(self, level=0):
        if level == len(OPERATORS):
            return self.unary()
        left = self.binary(level + 1)
        while sign := self.take(*OPERATORS[level]):
            left = both(OPERATORS[level][sign], left, self.binary(level + 1))
        return left

    def unary(self):
        if not self.take("-"):
            return self.operand()
        if self.tokens[0].isdigit():  # -2147483648 is a number
            number = -int(self.take())
            return lambda motor: fits(number)
        inner = self.unary()
        return lambda motor: fits(-inner(motor))

    def operand(self):
        token = self.take()
        if token.isdigit():
            return lambda motor: fits(int(token))
        if token == "(":
            return self.closed(")")
        if token in WIDTHS:
            self.take("[")
            index = self.closed("]")
            return lambda motor: motor.memory.element(token, index(motor))
        return lambda motor: motor.value(token)

    def closed(self, end):
        inner = self.binary()
        assert self.take(end)
        return inner


def condition(text):
    """Read the condition of IF, ELSEIF, WHILE and SWITCH; an invalid expression has no value and sets Bs."""
    if re.search(r"(?<![=!<>])=(?!=)", text):
        return no_value
    return expression(text)


def no_value(motor):
    raise Abandoned("Bs")


def both(operation, left, right):
    return lambda motor: fits(operation(left(motor), right(motor)))


def expression(text):
    """Return the value as a function of the motor, which may raise Abandoned."""
    reader = Text(text)
    value = reader.binary()
    assert not reader.tokens
    return value


# Statements


@dataclass(eq=False)
class Node:
    """A statement; IF, WHILE and SWITCH include all their parts."""

    number: int
    keyword: str
    text: str
    block: "Block"
    parts: list = field(default_factory=list)
    end: int = 0
    value: object = None
    index: object = None
    array: str = ""


@dataclass(eq=False)
class Block:
    """Consecutive statements after IF, ELSE, WHILE, CASE …; `number` counts the statements before this block."""

    owner: Node | None
    number: int = 0
    value: object = None  # condition, or the constant of a CASE; None: in all other cases
    fetches: bool = False
    nodes: list = field(default_factory=list)

    @property
    def part(self):
        return self.owner.parts.index(self)


@dataclass(frozen=True)
class Step:
    """The unit of execution: a test, a jump at the end of a block, a statement."""

    what: str
    node: Node | None
    part: int = 0
    fetch: bool = False
    """True if a value must be fetched first."""

    def number(self, program):
        match self.what:
            case "end of text":
                return program.count
            case "loop":
                return self.node.end
            case "if" | "leave" | "case":
                return self.node.parts[self.part].number
        return self.node.number


def statements(text):
    """Return the keyword or whole word, and the expression after a blank."""
    words = [word for line in text.split("\n") for word in line.partition("'")[0].split()]
    while words:
        word = words.pop(0)
        if word in ("IF", "ELSEIF", "WHILE", "SWITCH", "CASE"):
            yield word, words.pop(0)
        elif re.match(r"a[bwl]\[.*\]$", word) and "]=" not in word:
            values = [words.pop(0)]
            while not values[-1].endswith("."):
                values.append(words.pop(0))
            yield word, " ".join(values).rstrip(".")
        else:
            yield word, ""


class Program:
    """A program whose blocks are complete."""

    def __init__(self, text):
        self.root = self._block = Block(None)
        self.labels = {}
        self.count = 0
        for word, rest in statements(text):
            self._add(word, rest)
            self.count += 1

    def _add(self, word, rest):
        owner = self._block.owner
        if word in ("IF", "WHILE", "SWITCH"):
            self._open(self._node(word, rest), rest)
        elif word in ("ELSEIF", "ELSE"):
            self._part(owner, condition(rest) if rest else None, rest)
        elif word in ("CASE", "DEFAULT"):
            constant = int(rest) if rest.isdigit() else no_value
            self._part(owner, constant if rest else None, "")
        elif word in ("ENDIF", "LOOP", "ENDS"):
            owner.end = self.count
            self._block = owner.block
        else:
            self._plain(word, rest)

    def _node(self, word, rest):
        node = Node(self.count, word, rest, self._block)
        self._block.nodes.append(node)
        return node

    def _open(self, node, rest):
        node.value = condition(rest)
        if node.keyword == "SWITCH":
            self._block = Block(node)  # the block before the first CASE, in which no statement is allowed
        else:
            self._part(node, node.value, rest)

    def _part(self, owner, value, text):
        self._block = Block(owner, self.count, value, "GETCHR" in text)
        owner.parts.append(self._block)

    def _plain(self, word, rest):
        node = self._node(word, rest)
        name, equals, text = word.partition("=")
        if label := re.fullmatch(r"C(\d+)", word):
            node.keyword = "label"
            self.labels.setdefault(int(label[1]), node)
        elif element := re.fullmatch(r"(a[bwl])\[(.*?)\](?:=(.*))?", word):
            node.keyword, node.array, node.index = "element", element[1], expression(element[2])
            node.text = word
            node.value = [expression(value) for value in ([element[3]] if element[3] else rest.split())]
        elif equals and (name == "WAIT" or name.islower()):
            node.keyword = "WAIT" if name == "WAIT" else "let"
            node.array, node.value, node.text = name, expression(text), word

    # The next statement

    def begin(self, node):
        """Return the first step of a statement; labels take no time."""
        if node.keyword == "label":
            return self.behind(node)
        what = {"IF": "if", "WHILE": "while", "SWITCH": "switch"}.get(node.keyword, "do")
        return Step(what, node, 0, "GETCHR" in node.text and node.keyword in FETCHING)

    def enter(self, block):
        return self.begin(block.nodes[0]) if block.nodes else self.over(block)

    def behind(self, node):
        row = node.block.nodes
        at = row.index(node) + 1
        return self.begin(row[at]) if at < len(row) else self.over(node.block)

    def over(self, block):
        """Return the step after a block; ENDIF and ENDS take no sample, LOOP and the jump past ELSE take one."""
        owner = block.owner
        if owner is None:
            return Step("end of text", None)
        if owner.keyword == "WHILE":
            return Step("loop", owner)
        if block is owner.parts[-1]:
            return self.behind(owner)
        if owner.keyword == "IF":
            return Step("leave", owner, block.part + 1)
        return self.enter(owner.parts[block.part + 1])

    def otherwise(self, step):
        """Continue after a false condition."""
        node = step.node
        if step.what == "while" or step.part + 1 == len(node.parts):
            return self.behind(node)
        following = node.parts[step.part + 1]
        if following.value is None:
            return self.enter(following)
        return Step("if", node, step.part + 1, following.fetches)

    def cases(self, node, after=-1):
        """Return the next CASE to test, or DEFAULT."""
        for at, part in enumerate(node.parts):
            if at > after and part.value is not None:
                return Step("case", node, at)
        return self.default(node)

    def default(self, node):
        blocks = [part for part in node.parts if part.value is None]
        return self.enter(blocks[0]) if blocks else self.behind(node)
