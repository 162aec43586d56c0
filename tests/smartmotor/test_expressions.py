"""Expressions: operators, precedence, 32 bits, variables and arrays (7 of the base language, 8 of the manual)."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.chapters.variables import TABLE, find
from axistwin.controllers.smartmotor.kernel import state
from axistwin.controllers.smartmotor.kernel.interpreter import STACK, evaluate
from axistwin.controllers.smartmotor.language.expressions import Malformed, Reader

LOWEST, HIGHEST = -2147483648, 2147483647


def machine(**values):
    """Return the arrays with these slots and one-letter variables."""
    i, v = [0] * state.INTS, [0] * state.VARIABLES
    i[state.DIRECTION], i[state.ARRAY_BASE] = 1, state.DOUBLES
    for name, value in values.items():
        if name.isupper():
            i[getattr(state, name)] = value
        else:
            v[ord(name) - ord("a")] = value
    return i, v


def value(text, i=None, v=None):
    """Return the value of an expression, or None if it has no value."""
    blank = machine()
    i, v = i if i is not None else blank[0], v if v is not None else blank[1]
    reader = Reader(text)
    expression = reader.expression()
    assert reader.at == len(text)
    stack = [0] * STACK
    return stack[0] if evaluate(i, v, stack, expression.code, 0) >= 0 else None


# Division truncates towards zero; unary minus has the highest precedence; powers go from left to right; comparisons
# have precedence over &.  The first three stand in 4.3 and 10.2.
VALUES_OF = {
    "8*25": 200, "537*600": 322200, "4*65536": 262144, "2+3*4": 14, "(2+3)*4": 20, "2-3-4": -5, "100/10/5": 2,
    "7/2": 3, "-7/2": -3, "7/-2": -3, "7%3": 1, "-7%3": -1, "2^4": 16, "2*3^2": 18, "-2^2": 4, "2^3^2": 64, "5==5": 1,
    "5!=5": 0, "1<2": 1, "2<=2": 1, "3>4": 0, "3>=3": 1, "1+1==2": 1, "6&3": 2, "6|3": 7, "6!|3": 5, "1|6&2": 3,
    "7!|3&1": 6, "1|3!|1": 3, "5&4==4": 1, "--5": 5, "3--2": 5, "-(3)": -3, "255&191": 191, "2147483647": HIGHEST,
    "-2147483648": LOWEST, "000123": 123, "3^0": 1, "-3^3": -27,
}  # fmt: skip


def test_the_value_of_an_expression():
    assert {text: value(text) for text in VALUES_OF} == VALUES_OF


@pytest.mark.parametrize("text", [
    "1/0", "1%0", "a/a", "2147483647+1", "-2147483647-2", "65536*65536", "2147483648", "-(-2147483648)",
    "--2147483648", "-2147483648/-1", "10^10", "2^5", "2^-1", "99999999999999999999", "(2147483647+1)-1", "b*b"
])  # fmt: skip
def test_an_overflow_or_a_division_by_zero_sets_bd(text):
    """7 of the base language: overflow, division by zero, and powers above 4 abandon the statement and set Bd."""
    i, v = machine(b=100_000)
    assert value(text, i, v) is None and (i[state.BD], i[state.BU]) == (1, 0)


@pytest.mark.parametrize("text", ["ab[204]", "ab[-1]", "aw[102]", "al[51]", "al[-1]", "aw[b]", "ab[aw[0]-1]"])
def test_an_index_outside_the_array_sets_bu(text):
    """8.2: the elements are ab[0…203], aw[0…101] and al[0…50]; any other index sets Bu."""
    i, v = machine(b=1000)
    assert value(text, i, v) is None and (i[state.BD], i[state.BU]) == (0, 1)


def test_the_arrays_share_memory_most_significant_byte_first():
    """Table 8.1: ab[0] is the most significant byte of aw[0], and aw[0] is the most significant word of al[0]."""
    i, v = machine()
    v[state.DOUBLES] = 0x0102_0384
    assert [value(f"ab[{n}]", i, v) for n in range(4)] == [1, 2, 3, 0x84 - 0x100]
    assert [value(f"aw[{n}]", i, v) for n in range(2)] == [0x0102, 0x0384]
    assert value("al[0]", i, v) == value("aa", i, v) == 0x0102_0384
    v[state.DOUBLES + 50] = -2
    assert [value(f"ab[{n}]", i, v) for n in (200, 203)] == [-1, -2]
    assert [value(f"aw[{n}]", i, v) for n in (100, 101)] == [-1, -2]
    assert value("al[50]", i, v) == value("yyy", i, v) == -2


def test_the_array_can_lie_by_itself():
    i, v = machine()
    i[state.ARRAY_BASE] = state.ALONE
    v[state.DOUBLES], v[state.ALONE] = 5, 7
    assert (value("aa", i, v), value("al[0]", i, v)) == (5, 7)


def test_positions():
    """@P and @PE in counts; commanded positions are kept in 1/65536 count."""
    i, v = machine(SHAFT=100, ORIGIN=7, DIRECTION=-1, COMMANDED=-90 << 16, VELOCITY=-65536)
    assert (value("@P", i, v), value("@PE", i, v), value("@V", i, v)) == (-93, 3, -65536)
    i[state.ORIGIN] = 1 << 31
    assert value("@P", i, v) == HIGHEST - 99


def test_clock_status_and_pins():
    i, v = machine(SAMPLE=1000, CLK_ZERO=300, BT=1, BO=1, BX=1, BK=1, BC=1, PINS=0b1000101)
    assert value("CLK", i, v) == 700 and (value("W", i, v), value("S", i, v)) == (1 + 128 + 256 + 32768, 129)
    assert [value(f"B{bit}", i, v) for bit in "toxkcs"] == [1, 1, 1, 1, 1, 0] and value("U", i, v) == 69
    assert [value(f"U{pin}I", i, v) for pin in "ABCDEFG"] == [1, 0, 1, 0, 0, 0, 1]
    assert [value(f"U{pin}", i, v) for pin in "ABCDEFG"] == [1, 0, 1, 0, 0, 0, 1]
    i[state.ANALOG + 6] = 1023
    assert value("UGA", i, v) == 1023


def test_using_i_clears_bi():
    """Bi is cleared by using I (10 of the base language)."""
    i, v = machine(INDEX=-500, BI=1)
    assert value("Bi", i, v) == 1 and value("I+1", i, v) == -499
    assert value("Bi", i, v) == 0


def test_every_variable_can_be_read():
    names = [variable.name for variable in TABLE] + ["AINA1", "AINH4", "DINA0", "DINH63"]
    assert all(value(name) is not None for name in names if find(name).fetch is None) and len({*names}) == len(names)
    assert [name for name in names if find(name).fetch] == ["GETCHR", "GETCHR1", "AINA1", "AINH4", "DINA0", "DINH63"]


@pytest.mark.parametrize("name", [
    "AINA0", "AINA5", "DINA64", "AINI1", "ba", "abc", "aaaa", "UH", "Bq", "PP", "ab", "@X"])  # fmt: skip
def test_names_that_are_no_variables(name):
    with pytest.raises(Malformed):
        Reader(name).expression()


@pytest.mark.parametrize(("text", "position"), [
    ("", 0), ("1+", 2), ("*2", 0), ("(1", 2), ("ab", 2), ("ab[1", 4), ("1+K", 2), ("a+=", 2), ("#", 0), ("()", 1),
    ("(" * 30 + "1", 21), ("aw[]", 3), ("é", 0)])  # fmt: skip
def test_what_is_no_expression_is_told_with_its_place(text, position):
    with pytest.raises(Malformed) as caught:
        Reader(text).expression()
    assert caught.value.problem.position == position


@pytest.mark.parametrize("text", ["1a", "1=2", "2 +3", "a]", "5.", "3!4", "a!"])
def test_an_expression_ends_where_it_ends(text):
    reader = Reader(text)
    reader.expression()
    assert reader.at < len(text)


# Against a calculation in Python

OPERATIONS = {
    "|": (0, lambda a, b: a | b), "!|": (1, lambda a, b: a ^ b), "&": (2, lambda a, b: a & b),
    "==": (3, lambda a, b: int(a == b)), "<": (3, lambda a, b: int(a < b)), ">=": (3, lambda a, b: int(a >= b)),
    "+": (4, lambda a, b: a + b), "-": (4, lambda a, b: a - b),
    "*": (5, lambda a, b: a * b), "/": (5, lambda a, b: truncated(a, b)),
    "%": (5, lambda a, b: a - b * truncated(a, b)),
    "^": (6, lambda a, b: a**b if 0 <= b <= 4 else 1 << 40),
}  # fmt: skip


def truncated(a, b):
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


leaves = st.one_of(st.integers(0, 10), st.integers(0, HIGHEST), st.sampled_from("abc"))
trees = st.recursive(leaves, lambda inner: st.tuples(st.sampled_from(sorted(OPERATIONS)), inner, inner), max_leaves=12)
VALUES = {"a": -3, "b": 70_000, "c": LOWEST}


def written(tree, level=0):
    """Return the text of an expression with as few parentheses as precedence allows."""
    if not isinstance(tree, tuple):
        return str(tree)
    operator, left, right = tree
    own = OPERATIONS[operator][0]
    text = f"{written(left, own)}{operator}{written(right, own + 1)}"
    return f"({text})" if own < level else text


def calculated(tree):
    """Return the value, calculated in unbounded integers; raise ArithmeticError beyond 32 bits."""
    if not isinstance(tree, tuple):
        return VALUES.get(tree, tree)
    operator, left, right = tree
    result = OPERATIONS[operator][1](calculated(left), calculated(right))
    if not LOWEST <= result <= HIGHEST:
        raise OverflowError
    return result


@settings(max_examples=50)
@given(trees)
def test_every_expression_has_the_value_that_python_calculates(tree):
    i, v = machine(**VALUES)
    try:
        expected = calculated(tree)
    except ArithmeticError:
        expected = None
    assert value(written(tree), i, v) == expected and i[state.BD] == (expected is None)


@settings(max_examples=50)
@given(st.text(alphabet="ab[]()1-+*/%^&|!=<>.#@PUBtwl ", max_size=60))
def test_any_text_is_an_expression_or_malformed(text):
    i, v = machine()
    try:
        evaluate(i, v, [0] * STACK, Reader(text).expression().code, 0)
    except Malformed as malformed:
        place = malformed.problem.position
    else:
        place = 0
    assert 0 <= place <= len(text)
