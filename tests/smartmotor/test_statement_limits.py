"""How much one statement may ask for, and what a statement that asks for more leaves behind."""

import pytest

from .talking import load, send


@pytest.mark.parametrize(("values", "taken"), [(16, True), (17, False)])
def test_sixteen_values_from_outside_in_one_statement(bench, motor, values, taken):
    """Base 6: GETCHR of an empty buffer is 0.  With a seventeenth such value the statement sets Bs and does nothing."""
    load(bench, motor, "a=7\na=a+{}+1\nb=1\nEND\n".format("+".join(["GETCHR1"] * values)))
    send(bench, motor, "ZS RUN", 0.05)
    assert send(bench, motor, "Ra RBs Rb", 0) == (b"8\r0\r1\r" if taken else b"7\r1\r1\r")


def test_both_channels_count_their_characters(bench, motor):
    """Base 2: LEN and LEN1 are the characters that wait on channel 0 and on channel 1, in data mode."""
    send(bench, motor, "OCHN(RS4,1,N,9600,1,8,D)", 0)
    motor.rs485.write(b"xyz")
    bench.run(0.1)
    assert send(bench, motor, "PRINT(LEN,#32,LEN1,#32,GETCHR1,#32,LEN1,#13)", 0) == b"0 3 120 2\r"


def test_a_displaced_shaft_comes_back_to_where_the_servo_holds_it(bench, motor):
    """13: the servo holds the position: a push within E lasts a sample of a motor that follows without error."""
    send(bench, motor, "MP A=65536 V=655360 P=500 G", 1.0)
    motor.axes["shaft"].encoder.displace(100)
    bench.run(0.001)
    assert motor.axes["shaft"].position == 500
    assert send(bench, motor, "RP RPE RS", 0) == b"500\r0\r8\r"


@pytest.mark.parametrize(
    ("text", "statements", "wrong"), [("aw[0] 5 6.", 1, 0), ("aw[0 5 6.", 3, 1), ("aw[0]5 6.", 2, 1)]
)
def test_values_in_a_row_are_one_statement_and_without_their_bracket_none(bench, motor, text, statements, wrong):
    """1.1: "aw[0] 0 100 500 700." is one assignment.  3: a space ends a command, so an open bracket ends there."""
    load(bench, motor, f"ZS\nCLK=0\n{text}\na=CLK\nEND\n")
    send(bench, motor, "RUN", 0.05)
    assert send(bench, motor, "Ra RBs", 0) == f"{statements + 1}\r{wrong}\r".encode()
    assert send(bench, motor, "Raw[0] Raw[1]", 0) == (b"0\r0\r" if wrong else b"5\r6\r")
