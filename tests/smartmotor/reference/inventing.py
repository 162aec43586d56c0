"""Random expressions and programs, as texts."""

SMALL = ["0", "1", "2", "3", "4", "7", "13", "255", "1000"]
LARGE = ["65535", "65536", "46341", "2147483647", "2147483648", "99999999999"]
NAMES = [*"abcdexyz", "aa", "bb", "zz", "aaa", "yyy", "zzz"]
SYSTEM = [
    "@P", "@PE", "@V", "CLK", "CTR", "CX", "I", "W", "S", "U", "UA", "UG", "UGI", "UC", "UAA", "A", "V", "P", "D", "E",
    "T", "F", "Bt", "Bd", "Bu", "Bs", "Bi", "Bx", "KP",
]  # fmt: skip
ARITHMETIC = ["+", "-", "*", "/", "%"]
SIGNS = ["^", "&", "|", "!|", "==", "!=", "<", ">", "<=", ">="]
ARRAYS = {"ab": 204, "aw": 102, "al": 51}


def expression(random, depth=3, *, system=True, fetches=False):
    kind = random.randrange(10) if depth else random.randrange(2)
    if kind == 0:
        return random.choice(random.choice([SMALL, SMALL, SMALL, LARGE]))
    if kind == 1:
        known = random.choice([NAMES, NAMES, SYSTEM if system else NAMES])
        return random.choice([*known, *(["GETCHR"] if fetches else [])])
    inner = expression(random, depth - 1, system=system)
    if kind == 2:
        return f"({inner})"
    if kind == 3:
        return f"-{inner}"
    if kind == 4:
        return element(random, depth)
    sign = random.choice(random.choice([ARITHMETIC, ARITHMETIC, SIGNS]))
    return f"{inner}{sign}{expression(random, depth - 1, system=system)}"


def element(random, depth=1):
    """Return an array element that often exists."""
    array = random.choice(list(ARRAYS))
    size = ARRAYS[array]
    indices = str(random.randrange(size)), str(random.choice([0, size - 1, size])), expression(random, depth - 1)
    return f"{array}[{random.choice(indices)}]"


def assignment(random):
    name = random.choice(NAMES)
    return random.choice([f"{name}={name}+1", f"{name}={expression(random, fetches=True)}"])


def array_assignment(random):
    if random.randrange(3):
        return f"{element(random)}={expression(random)}"
    return f"{element(random)} {' '.join(str(random.randint(-40000, 40000)) for _ in range(random.randint(1, 5)))}."


def plain(random):
    """Return a statement that is not a block."""
    kinds = [
        assignment,
        assignment,
        array_assignment,
        lambda random: f"WAIT={random.choice(['0', '1', '2', '5', 'a', '-3', expression(random, 1)])}",
        lambda random: f"GOSUB{random.randint(1, 4)}",
        lambda random: random.choice(["TWAIT", "G", "MP", "A=100", "P=a*b", "TWAIT 'and a comment"]),
        lambda random: random.choice(["RETURN", "RETURNF", "RETURNI", "STACK", "END", f"GOTO{random.randint(1, 5)}"]),
    ]
    return random.choice(kinds)(random)


def block(random, depth, breaks=False):
    lines = []
    for _ in range(random.randint(0, 3)):
        kind = random.randrange(6) if depth else 0
        if kind < 3:
            lines.append("BREAK" if breaks and random.randrange(5) == 0 else plain(random))
        else:
            lines += (choice_of_two, loop, switch)[kind - 3](random, depth - 1, breaks)
    return lines


def condition(random):
    if random.randrange(20) == 0:
        return f"{random.choice(NAMES)}=3"  # not an expression: sets Bs, and the condition is false
    return random.choice([f"{random.choice(NAMES)}<{random.randint(1, 9)}", expression(random, 2, fetches=True)])


def choice_of_two(random, depth, breaks):
    lines = [f"IF {condition(random)}", *block(random, depth, breaks)]
    for _ in range(random.randint(0, 2)):
        lines += [f"ELSEIF {condition(random)}", *block(random, depth, breaks)]
    if random.randrange(2):
        lines += ["ELSE", *block(random, depth, breaks)]
    return [*lines, "ENDIF"]


def loop(random, depth, breaks):
    return [f"WHILE {condition(random)}", "a=a+1", *block(random, depth, True), "LOOP"]


def switch(random, depth, breaks):
    cases = [*range(4), "a+3"]  # a CASE without a constant sets Bs
    parts = [f"CASE {n}" for n in random.sample(cases, random.randint(0, 3))]
    if random.randrange(2):
        parts.insert(random.randint(0, len(parts)), "DEFAULT")
    lines = [f"SWITCH {random.choice([random.choice('abc') + '&3', condition(random)])}"]
    for part in parts:
        lines += [part, *block(random, depth, True)]
    return [*lines, "ENDS"]


def program(random):
    """Return a program with subroutines C1 to C3; C4 may be anywhere, in a block, or missing."""
    lines = block(random, 3) + block(random, 3)
    if random.randrange(2):
        lines.insert(random.randint(0, len(lines)), "END")
    for label in 1, 2, 3:
        lines += [f"C{label}", *block(random, 1), random.choice(["RETURN", "RETURN", "RETURNF", "RETURNI"])]
    if random.randrange(2):
        places = [n for n, line in enumerate(lines) if not line.startswith("SWITCH")]  # not before a CASE
        lines.insert(random.choice(places) + 1, "C4")
    return "\n".join(lines)
