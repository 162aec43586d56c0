"""Section 9 of the base language, and chapter 6: reports and PRINT."""

import pytest

from .talking import ask, load, send


@pytest.mark.parametrize(
    ("command", "answer"),
    [
        # 16: power-on defaults; 10: flags after UCI UDI ZS
        ("RP", "0"), ("RPE", "0"), ("RV", "0"), ("RA", "0"), ("RD", "0"), ("RE", "1000"), ("RT", "0"), ("RI", "0"),
        ("RW", "128"), ("RS", "128"), ("RPW", "0,128"), ("RMODE", "B"), ("RSP", "24576/476"), ("RCTR", "0"),
        ("RU", "127"), ("RUA", "1"), ("RUG", "1"), ("RUAA", "1023"), ("RUGA", "1023"),
        ("Ra", "0"), ("Rzzz", "0"), ("Rab[203]", "0"), ("Raw[101]", "0"), ("Ral[50]", "0"),
        ("RAINA1", "0"), ("RDINH63", "0"), ("RAMPS", "1023"), ("RKS", "1"), ("RKV", "0"), ("RADDR", "0"),
        ("REPTR", "0"), ("RBASE", "0"), ("RSIZE", "0"), ("RCHN", "0"), ("RCHN0", "0"), ("RCHN1", "0"), ("RCS", "0"),
        ("RCS1", "0"), ("RCKS", "000000 000000 P"),
        ("RBo", "1"), ("RBt", "0"), ("RBr", "0"), ("RBl", "0"), ("RBi", "0"), ("RBw", "0"), ("RBe", "0"), ("RBh", "0"),
        ("RBx", "0"), ("RBp", "0"), ("RBm", "0"), ("RBd", "0"), ("RBu", "0"), ("RBs", "0"), ("RBa", "0"), ("RBk", "0"),
        ("RBb", "0"), ("RBc", "0"), ("RBf", "0"),
    ],
)  # fmt: skip
def test_reports_after_power_up(bench, motor, command, answer):
    """9: a report is its text and CR, without leading blanks or padding."""
    assert send(bench, motor, command) == answer.encode() + b"\r"
    assert ask(bench, motor, "RBs") == "0"


@pytest.mark.parametrize(
    ("assignment", "report", "answer"),
    [
        ("A=100", "RA", "100"), ("D=-7", "RD", "-7"), ("E=32000", "RE", "32000"), ("T=-1023", "RT", "-1023"),
        ("AMPS=100", "RAMPS", "100"), ("KP=42", "RKP", "42"), ("KI=1", "RKI", "1"), ("KD=2", "RKD", "2"),
        ("KL=3", "RKL", "3"), ("KS=4", "RKS", "4"), ("KV=5", "RKV", "5"), ("KA=6", "RKA", "6"), ("KG=7", "RKG", "7"),
        ("BASE=8000", "RBASE", "8000"), ("SIZE=8", "RSIZE", "8"), ("EPTR=7", "REPTR", "7"), ("SADDR7", "RADDR", "7"),
        ("a=-2147483648", "Ra", "-2147483648"), ("zzz=2147483647", "Rzzz", "2147483647"), ("aw[3]=-1", "Raw[3]", "-1"),
        ("O=-1234", "RP", "-1234"), ("ab[9]=200", "Rab[9]", "-56"), ("n=2 al[3]=9", "Ral[n+1]", "9"),
    ],
)  # fmt: skip
def test_a_report_tells_the_buffered_value(bench, motor, assignment, report, answer):
    assert send(bench, motor, f"{assignment} {report} RBs") == answer.encode() + b"\r0\r"


def test_clk_counts_samples(bench, motor):
    """1: CLK counts samples of 245,760 ns each."""
    send(bench, motor, "CLK=0", 0)
    bench.run(1000 * 245_760e-9)
    assert send(bench, motor, "RCLK", 0) == b"1000\r"


@pytest.mark.parametrize(("rate", "period"), [(1, 24576), (2, 49152), (4, 98304), (8, 196608)])
def test_rsp_reports_the_period_of_the_servo_and_the_firmware(bench, motor, rate, period):
    """Page 1: RSP reports 24576/476; PIDn multiplies the period."""
    assert send(bench, motor, f"PID{rate} RSP") == f"{period}/476\r".encode()


def test_ri_clears_bi(bench, motor):
    """10: Bi is cleared by RI.  The index mark is 500 counts from the shaft's first position."""
    send(bench, motor, "MP P=600 V=100000 A=1000 G", 1)
    assert send(bench, motor, "RBi RI RBi") == b"1\r500\r0\r"


def test_an_index_outside_the_array_is_not_reported(bench, motor):
    """8.2: a report of such an element returns nothing and sets Bu."""
    assert send(bench, motor, "Rab[204] Raw[102] Ral[51] Rab[-1] RBu RBs") == b"1\r0\r"


@pytest.mark.parametrize("command", ["RFOO", "R", "Rp2", "RAIN", "RAINA5", "RAINI1", "RDINA64", "RAA", "RUH", "RUAB"])
def test_what_is_no_report_sets_bs(bench, motor, command):
    assert send(bench, motor, f"{command} RBs") == b"1\r"


def test_print_adds_nothing(bench, motor):
    """9: PRINT sends texts, decimal values and one byte for #n, and no CR of its own."""
    assert send(bench, motor, 'a=-5 PRINT("a=",a,"  ",a*a,#13,#10,#0,#255)') == b"a=-5  25\r\n\0\xff"


def test_print_of_something_without_a_value_prints_nothing(bench, motor):
    assert send(bench, motor, 'PRINT("x",1/0) RBd') == b"1\r"


@pytest.mark.parametrize("device", "ABCDEFGH")
def test_print_to_a_device_that_is_not_there_is_lost(bench, motor, device):
    assert send(bench, motor, f'PRINT{device}("x") RBs') == b"0\r"


def test_a_program_reports_as_a_host_does(bench, motor):
    load(bench, motor, 'Ra PRINT("b=",b,#13)\nRPW\nEND\n')
    assert send(bench, motor, "RUN", 0.1) == b"0\rb=0\r0,128\r"
