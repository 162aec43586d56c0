"""Chapter 8: variables and arrays."""

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scripts import play, scripts
from .talking import ready, send, value

LETTERS = "abcdefghijklmnopqrstuvwxyz"
LONGS = [2 * letter for letter in LETTERS] + [3 * letter for letter in LETTERS[:25]]
WIDTH = {"ab": 1, "aw": 2, "al": 4}
LAST = {"ab": 203, "aw": 101, "al": 50}


@scripts({
    # 8.1 Forced equal sign
    "nor are these without it":
    [f"{words} RBs RP RMODE -> 1 0 B"
     for words in ("O100", "WAIT5", "F33", "CLK5", "MFMUL3", "TH50", "SLP5", "EPTR7")],
    "with it they are accepted":
    "A=100 V=101 P=102 x=103 aa=104 ab[0]=105 KP=106; RBs -> 0; A is 100; V is 101; P is 102; x is 103; "
    "ab[0] is 105; KP is 106",
    # 8.2 Multiple arrays, table 8.1
    "8.2: ab[203], aw[101] and al[50] exist; the next index is an array index error, Bu":
    [f"{kind}[{last}]=-7; R{kind}[{last}] RBu -> -7 0; {kind}[{last + 1}]=5; RBu RBs -> 1 0; "
     f"{kind}[{last}] is -7; {kind}[0] is 0; zzz is 0; a is 0"
     for kind, last in list(LAST.items())],
    "6, 10: reading or writing beyond the array sets Bu, and Zu and ZS clear Bu":
    [f"a=-1 x=5; {where}=1; RBu Rx Zu RBu -> 1 5 0; x={where}; RBu Rx Zu RBu -> 1 5 0; R{where}; "
     "RBu Rx Zu RBu -> 1 5 0"
     for where in (
         "ab[204]", "ab[-1]", "aw[102]", "aw[-1]", "al[51]", "al[-1]", "ab[2147483647]", "al[-2147483648]",
         "al[a*1]",
     )],
    "Table 8.1: al[0] shares memory with aw[0] aw[1] and ab[0] … ab[3], the most significant byte first":
    "al[0]=16909060; aw[0] is 258; aw[1] is 772; ab[0] is 1; ab[1] is 2; ab[2] is 3; ab[3] is 4; ab[1]=-1; "
    "aw[0] is 511; al[0] is 33489668",
    "Table 8.1: al[50] shares memory with aw[100] aw[101] and ab[200] … ab[203]":
    "ab[200] 1 2 3 4.; aw[100] is 258; aw[101] is 772; al[50] is 16909060; aw[101]=-2; ab[202] is -1; "
    "ab[203] is -2; al[50] is 16973822",
    "6: al[0] is aa, al[25] is zz, al[26] is aaa, al[50] is yyy":
    [f"{name}={index + 1}; al[{index}] is {index + 1}; al[{index}]=-5; {name} is -5"
     for index, name in list(enumerate(LONGS))],
    "With the option array_overlay=False, the arrays and the variables share no memory":
    "with array_overlay=false; aa=5 al[0]=6 yyy=7 al[50]=8; aa is 5; al[0] is 6; yyy is 7; al[50] is 8",
    "6: an element keeps the low 8 or 16 bits of a value, and reading it extends the sign":
    [f"{where}={stored}; {where} is {read}; RBs RBd RBu -> 0 0 0"
     for where, stored, read in (
         ("ab[7]", 127, 127), ("ab[7]", 128, -128), ("ab[7]", 256, 0), ("ab[7]", -129, 127),
         ("aw[7]", 32767, 32767), ("aw[7]", 32768, -32768), ("aw[7]", 65536, 0), ("aw[7]", -32769, 32767),
         ("al[7]", 2147483647, 2147483647), ("al[7]", -2147483648, -2147483648),
     )],
    # Lists
    "a list that is too long sets bu":
    "aw[100] 1 2 3.; RBu Rzzz -> 1 0",
    "9.4: the program of example 3 contains a list of values for an array":
    "load aw[0] 0 700 1100 2200 3300 2200. / x=aw[5] / END; RUN; 0.05 s; x is 2200; aw[1] is 700; aw[4] is 3300",
    "6: an index is a number, a variable or one binary operation":
    [f"n=3 ab[0]=9 aw[{index}]=77; aw[{element}] is 77; n is 3"
     for index, element in (("n", 3), ("n+1", 4), ("n*2", 6), ("n-3", 0), ("ab[0]", 9), ("n%2", 1))],
    # Beyond
    "they are lost when the power is cut":
    "aw[0] 1 2 3. zz=4 zzz=5 a=6; power cycle; 0.5 s; aw[0] is 0; aw[1] is 0; al[25] is 0; zzz is 0; a is 0",
    '8.1: "A100 is no longer accepted": the command is a syntax error (base 3) and has no other effect':
    [f"keep {name}; {name}100 RBs -> 1; {name} kept"
     for name in (
         "A", "V", "P", "D", "E", "T", "KP", "x", "aa", "ab[0]", "BASE", "SIZE", "AMPS", "SLN", "aw[0]",
     )],
    "6: the arrays share memory with 51 variables, aa…zz (26) and aaa…yyy (25); zzz and a…z are not among them":
    "zzz=9 a=8 z=7; " + "; ".join(f"al[{n}] is 0" for n in range(51)) + "; zzz is 9; a is 8; z is 7",
    # Lists
    '1.1: "aw[0] 0 100 500 700." sets four consecutive elements':
    "aw[4]=9 aw[0] 0 100 500 700.; aw[0] is 0; aw[1] is 100; aw[2] is 500; aw[3] is 700; aw[4] is 9",
    "lists of every kind begin where their index says":
    [f"n=3 {kind}[n+1] -1 2 -3.; {kind}[3] is 0; {kind}[4] is -1; {kind}[5] is 2; {kind}[6] is -3; {kind}[7] is 0; "
     "RBs RBu -> 0 0"
     for kind in WIDTH],
    '1.1: "aw[0] 0 100 500 700." is one assignment. 3: a space ends a command, so an open bracket ends there':
    [f"load ZS / CLK=0 / {text} / a=CLK / END; RUN; 0.05 s; Ra RBs Raw[0] Raw[1] -> {answers}"
     for text, answers in (("aw[0] 5 6.", "2 0 5 6"), ("aw[0 5 6.", "4 1 0 0"), ("aw[0]5 6.", "3 1 0 0"))],
    "Base 6: GETCHR of an empty buffer is 0. A statement with a seventeenth such value only sets Bs":
    [f"load a=7 / a=a+{'+'.join(['GETCHR1'] * most)}+1 / b=1 / END; ZS RUN; 0.05 s; Ra RBs Rb -> {answers}"
     for most, answers in ((16, "8 0 1"), (17, "7 1 1"))],
})  # fmt: skip
def test_arrays(script):
    play(script)


# Lists


def test_the_whole_array_in_one_list(bench, motor):
    """9.0: one list may fill the array up to aw[101], that is 102 values."""
    wanted = [(index * 643) % 65_536 - 32_768 for index in range(102)]
    send(bench, motor, "aw[0] " + " ".join(map(str, wanted)) + ".", 0)
    assert [value(bench, motor, f"aw[{index}]") for index in range(102)] == wanted


# Beyond


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
