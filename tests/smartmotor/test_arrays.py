"""Chapter 8: variables and arrays."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .talking import load, ready, send, value, values

LETTERS = "abcdefghijklmnopqrstuvwxyz"
LONGS = [2 * letter for letter in LETTERS] + [3 * letter for letter in LETTERS[:25]]
WIDTH = {"ab": 1, "aw": 2, "al": 4}
LAST = {"ab": 203, "aw": 101, "al": 50}


# 8.1 Forced equal sign


@pytest.mark.parametrize(
    "words",
    ["A100", "V100", "P100", "D100", "E100", "T100", "KP100", "x5", "aa5", "ab[0]5", "BASE8", "SIZE8", "AMPS9", "SLN0",
     "P1000", "aw[0]5"],
)  # fmt: skip
def test_the_equal_sign_must_be_present(bench, motor, words):
    """8.1: "A100 is no longer accepted": the command is a syntax error (base 3) and has no other effect."""
    name = words.rstrip("0123456789")
    before = value(bench, motor, name)
    assert send(bench, motor, f"{words} RBs", 0) == b"1\r"
    assert value(bench, motor, name) == before


@pytest.mark.parametrize("words", ["O100", "WAIT5", "F33", "CLK5", "MFMUL3", "TH50", "SLP5", "EPTR7"])
def test_nor_are_these_without_it(bench, motor, words):
    assert send(bench, motor, f"{words} RBs RP RMODE", 0) == b"1\r0\rB\r"


def test_with_it_they_are_accepted(bench, motor):
    send(bench, motor, "A=100 V=101 P=102 x=103 aa=104 ab[0]=105 KP=106", 0)
    assert send(bench, motor, "RBs", 0) == b"0\r"
    assert values(bench, motor, ["A", "V", "P", "x", "ab[0]", "KP"]) == [100, 101, 102, 103, 105, 106]


# 8.2 Multiple arrays, table 8.1


@pytest.mark.parametrize(("kind", "last"), list(LAST.items()))
def test_the_last_element(bench, motor, kind, last):
    """8.2: ab[203], aw[101] and al[50] exist; the next index is an array index error, Bu."""
    send(bench, motor, f"{kind}[{last}]=-7", 0)
    assert send(bench, motor, f"R{kind}[{last}] RBu", 0) == b"-7\r0\r"
    send(bench, motor, f"{kind}[{last + 1}]=5", 0)
    assert send(bench, motor, "RBu RBs", 0) == b"1\r0\r"
    assert values(bench, motor, [f"{kind}[{last}]", f"{kind}[0]", "zzz", "a"]) == [-7, 0, 0, 0]


@pytest.mark.parametrize(
    "where",
    ["ab[204]", "ab[-1]", "aw[102]", "aw[-1]", "al[51]", "al[-1]", "ab[2147483647]", "al[-2147483648]", "al[a*1]"],
)
def test_beyond_the_array_the_command_is_ignored(bench, motor, where):
    """6, 10: reading or writing beyond the array sets Bu, and Zu and ZS clear Bu."""
    send(bench, motor, "a=-1 x=5", 0)
    for words in (f"{where}=1", f"x={where}", f"R{where}"):
        assert send(bench, motor, words + "", 0) == b""
        assert send(bench, motor, "RBu Rx Zu RBu", 0) == b"1\r5\r0\r"


def test_table_8_1_first_location(bench, motor):
    """Table 8.1: al[0] shares memory with aw[0] aw[1] and ab[0] … ab[3], the most significant byte first."""
    send(bench, motor, "al[0]=16909060", 0)  # 01020304h
    assert values(bench, motor, ["aw[0]", "aw[1]", "ab[0]", "ab[1]", "ab[2]", "ab[3]"]) == [0x102, 0x304, 1, 2, 3, 4]
    send(bench, motor, "ab[1]=-1", 0)
    assert values(bench, motor, ["aw[0]", "al[0]"]) == [0x1FF, 0x1FF0304]


def test_table_8_1_last_location(bench, motor):
    """Table 8.1: al[50] shares memory with aw[100] aw[101] and ab[200] … ab[203]."""
    send(bench, motor, "ab[200] 1 2 3 4.", 0)
    assert values(bench, motor, ["aw[100]", "aw[101]", "al[50]"]) == [0x102, 0x304, 0x1020304]
    send(bench, motor, "aw[101]=-2", 0)
    assert values(bench, motor, ["ab[202]", "ab[203]", "al[50]"]) == [-1, -2, 0x102FFFE]


@pytest.mark.parametrize(("index", "name"), list(enumerate(LONGS)))
def test_the_long_variables_lie_in_the_same_memory(bench, motor, index, name):
    """6: al[0] is aa, al[25] is zz, al[26] is aaa, al[50] is yyy."""
    send(bench, motor, f"{name}={index + 1}", 0)
    assert value(bench, motor, f"al[{index}]") == index + 1
    send(bench, motor, f"al[{index}]=-5", 0)
    assert value(bench, motor, name) == -5


def test_zzz_and_single_letters_lie_elsewhere(bench, motor):
    """6: the arrays share memory with 51 variables, aa…zz (26) and aaa…yyy (25); zzz and a…z are not among them."""
    send(bench, motor, "zzz=9 a=8 z=7", 0)
    assert {value(bench, motor, f"al[{index}]") for index in range(51)} == {0}
    assert values(bench, motor, ["zzz", "a", "z"]) == [9, 8, 7]


def test_without_the_overlay_names_and_arrays_are_apart(bench):
    """With the option array_overlay=False, the arrays and the variables share no memory."""
    motor = ready(bench, array_overlay=False)
    send(bench, motor, "aa=5 al[0]=6 yyy=7 al[50]=8", 0)
    assert values(bench, motor, ["aa", "al[0]", "yyy", "al[50]"]) == [5, 6, 7, 8]


@pytest.mark.parametrize(
    ("where", "stored", "read"),
    [("ab[7]", 127, 127), ("ab[7]", 128, -128), ("ab[7]", 256, 0), ("ab[7]", -129, 127), ("aw[7]", 32_767, 32_767),
     ("aw[7]", 32_768, -32_768), ("aw[7]", 65_536, 0), ("aw[7]", -32_769, 32_767),
     ("al[7]", 2_147_483_647, 2_147_483_647), ("al[7]", -2_147_483_648, -2_147_483_648)],
)  # fmt: skip
def test_storing_truncates_and_reading_extends_the_sign(bench, motor, where, stored, read):
    """6: an element keeps the low 8 or 16 bits of a value, and reading it extends the sign."""
    send(bench, motor, f"{where}={stored}", 0)
    assert value(bench, motor, where) == read
    assert send(bench, motor, "RBs RBd RBu", 0) == b"0\r0\r0\r"


# Lists


def test_the_summarys_list(bench, motor):
    """1.1: "aw[0] 0 100 500 700." sets four consecutive elements."""
    send(bench, motor, "aw[4]=9 aw[0] 0 100 500 700.", 0)
    assert values(bench, motor, (f"aw[{index}]" for index in range(5))) == [0, 100, 500, 700, 9]


@pytest.mark.parametrize("kind", WIDTH)
def test_lists_of_every_kind_begin_where_their_index_says(bench, motor, kind):
    send(bench, motor, f"n=3 {kind}[n+1] -1 2 -3.", 0)
    assert values(bench, motor, (f"{kind}[{index}]" for index in range(3, 8))) == [0, -1, 2, -3, 0]
    assert send(bench, motor, "RBs RBu", 0) == b"0\r0\r"


def test_the_whole_array_in_one_list(bench, motor):
    """9.0: one list may fill the array up to aw[101], that is 102 values."""
    wanted = [(index * 643) % 65_536 - 32_768 for index in range(102)]
    send(bench, motor, "aw[0] " + " ".join(map(str, wanted)) + ".", 0)
    assert [value(bench, motor, f"aw[{index}]") for index in range(102)] == wanted


def test_a_list_that_is_too_long_sets_bu(bench, motor):
    send(bench, motor, "aw[100] 1 2 3.", 0)
    assert send(bench, motor, "RBu Rzzz", 0) == b"1\r0\r"


def test_a_list_in_a_program(bench, motor):
    """9.4: the program of example 3 contains a list of values for an array."""
    load(bench, motor, "aw[0] 0 700 1100 2200 3300 2200.\nx=aw[5]\nEND\n")
    send(bench, motor, "RUN", 0)
    bench.run(0.05)
    assert values(bench, motor, ["x", "aw[1]", "aw[4]"]) == [2200, 700, 3300]


@pytest.mark.parametrize(("index", "element"), [("n", 3), ("n+1", 4), ("n*2", 6), ("n-3", 0), ("ab[0]", 9), ("n%2", 1)])
def test_an_index_may_be_an_expression(bench, motor, index, element):
    """6: an index is a number, a variable or one binary operation."""
    send(bench, motor, f"n=3 ab[0]=9 aw[{index}]=77", 0)
    assert values(bench, motor, [f"aw[{element}]", "n"]) == [77, 3]


# Beyond


def test_they_are_lost_when_the_power_is_cut(bench, motor):
    send(bench, motor, "aw[0] 1 2 3. zz=4 zzz=5 a=6", 0)
    motor.power_cycle()
    bench.run(0.5)
    assert values(bench, motor, ["aw[0]", "aw[1]", "al[25]", "zzz", "a"]) == [0, 0, 0, 0, 0]


@st.composite
def stores(draw):
    kind = draw(st.sampled_from(list(WIDTH)))
    return kind, draw(st.integers(-1, LAST[kind] + 1)), draw(st.integers(-(2**31), 2**31 - 1))


@settings(deadline=None, max_examples=20)
@given(written=st.lists(stores(), max_size=25))
def test_the_three_arrays_are_one_memory_of_204_bytes(written):
    """8.2 item 3: the three arrays share 204 bytes."""
    bench = Bench()
    motor, memory = ready(bench), bytearray(204)
    for kind, index, number in written:
        send(bench, motor, f"{kind}[{index}]={number}", 0)
        if 0 <= index <= LAST[kind]:
            width = WIDTH[kind]
            memory[index * width : (index + 1) * width] = (number % 256**width).to_bytes(width)
    for kind, width in WIDTH.items():
        found = send(bench, motor, "".join(f"R{kind}[{index}] " for index in range(LAST[kind] + 1)), 0)
        elements = [memory[at : at + width] for at in range(0, 204, width)]
        assert found.split() == [b"%d" % int.from_bytes(element, signed=True) for element in elements]


@pytest.mark.parametrize(
    ("text", "statements", "wrong"), [("aw[0] 5 6.", 1, 0), ("aw[0 5 6.", 3, 1), ("aw[0]5 6.", 2, 1)]
)
def test_values_in_a_row_are_one_statement_and_without_their_bracket_none(bench, motor, text, statements, wrong):
    """1.1: "aw[0] 0 100 500 700." is one assignment.  3: a space ends a command, so an open bracket ends there."""
    load(bench, motor, f"ZS\nCLK=0\n{text}\na=CLK\nEND\n")
    send(bench, motor, "RUN", 0.05)
    assert send(bench, motor, "Ra RBs", 0) == f"{statements + 1}\r{wrong}\r".encode()
    assert send(bench, motor, "Raw[0] Raw[1]", 0) == (b"0\r0\r" if wrong else b"5\r6\r")


@pytest.mark.parametrize(("values", "taken"), [(16, True), (17, False)])
def test_sixteen_values_from_outside_in_one_statement(bench, motor, values, taken):
    """Base 6: GETCHR of an empty buffer is 0.  A statement with a seventeenth such value only sets Bs."""
    load(bench, motor, "a=7\na=a+{}+1\nb=1\nEND\n".format("+".join(["GETCHR1"] * values)))
    send(bench, motor, "ZS RUN", 0.05)
    assert send(bench, motor, "Ra RBs Rb", 0) == (b"8\r0\r1\r" if taken else b"7\r1\r1\r")
