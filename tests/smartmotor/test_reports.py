"""Section 9 of the base language, and chapter 6: reports and PRINT."""

import pytest

from .scripts import play, scripts
from .talking import send


@scripts({
    "a report tells the buffered value":
    [f"{assignment} {report} RBs -> {answer} 0"
     for assignment, report, answer in (
         ("A=100", "RA", "100"), ("D=-7", "RD", "-7"), ("E=32000", "RE", "32000"), ("T=-1023", "RT", "-1023"),
         ("AMPS=100", "RAMPS", "100"), ("KP=42", "RKP", "42"), ("KI=1", "RKI", "1"), ("KD=2", "RKD", "2"),
         ("KL=3", "RKL", "3"), ("KS=4", "RKS", "4"), ("KV=5", "RKV", "5"), ("KA=6", "RKA", "6"),
         ("KG=7", "RKG", "7"), ("BASE=8000", "RBASE", "8000"), ("SIZE=8", "RSIZE", "8"),
         ("EPTR=7", "REPTR", "7"), ("SADDR7", "RADDR", "7"), ("a=-2147483648", "Ra", "-2147483648"),
         ("zzz=2147483647", "Rzzz", "2147483647"), ("aw[3]=-1", "Raw[3]", "-1"), ("O=-1234", "RP", "-1234"),
         ("ab[9]=200", "Rab[9]", "-56"), ("n=2 al[3]=9", "Ral[n+1]", "9"),
     )],
    "1: CLK counts samples of 245,760 ns each":
    "CLK=0; 0.24575999999999998 s; RCLK -> 1000",
    "Page 1: RSP reports 24576/476; PIDn multiplies the period":
    [f"PID{rate} RSP -> {period}/476" for rate, period in ((1, 24576), (2, 49152), (4, 98304), (8, 196608))],
    "10: Bi is cleared by RI. The index mark is 500 counts from the shaft's first position":
    "MP P=600 V=100000 A=1000 G; 1 s; RBi RI RBi -> 1 500 0",
    "8.2: a report of such an element returns nothing and sets Bu":
    "Rab[204] Raw[102] Ral[51] Rab[-1] RBu RBs -> 1 0",
    "9: PRINT sends texts, decimal values and one byte for #n, and no CR of its own":
    'a=-5 PRINT("a=",a,"  ",a*a,#13,#10,#0,#255) => a=-5  25<CR><LF><00><FF>',
    "print of something without a value prints nothing":
    'PRINT("x",1/0) RBd -> 1',
    "print to a device that is not there is lost":
    [f'PRINT{device}("x") RBs -> 0' for device in "ABCDEFGH"],
    "a program reports as a host does":
    'load Ra PRINT("b=",b,#13) / RPW / END; RUN -> 0 b=0 0,128 in 0.1 s',
    "9: a report is its text and CR, without leading blanks or padding":
    [f"{command} => {answer}<CR>; RBs -> 0"
     for command, answer in (
         ("RP", "0"), ("RPE", "0"), ("RV", "0"), ("RA", "0"), ("RD", "0"), ("RE", "1000"), ("RT", "0"),
         ("RI", "0"), ("RW", "128"), ("RS", "128"), ("RPW", "0,128"), ("RMODE", "B"), ("RSP", "24576/476"),
         ("RCTR", "0"), ("RU", "127"), ("RUA", "1"), ("RUG", "1"), ("RUAA", "1023"), ("RUGA", "1023"),
         ("Ra", "0"), ("Rzzz", "0"), ("Rab[203]", "0"), ("Raw[101]", "0"), ("Ral[50]", "0"), ("RAINA1", "0"),
         ("RDINH63", "0"), ("RAMPS", "1023"), ("RKS", "1"), ("RKV", "0"), ("RADDR", "0"), ("REPTR", "0"),
         ("RBASE", "0"), ("RSIZE", "0"), ("RCHN", "0"), ("RCHN0", "0"), ("RCHN1", "0"), ("RCS", "0"),
         ("RCS1", "0"), ("RCKS", "000000 000000 P"), ("RBo", "1"), ("RBt", "0"), ("RBr", "0"), ("RBl", "0"),
         ("RBi", "0"), ("RBw", "0"), ("RBe", "0"), ("RBh", "0"), ("RBx", "0"), ("RBp", "0"), ("RBm", "0"),
         ("RBd", "0"), ("RBu", "0"), ("RBs", "0"), ("RBa", "0"), ("RBk", "0"), ("RBb", "0"), ("RBc", "0"),
         ("RBf", "0"),
     )],
})  # fmt: skip
def test_reports(script):
    play(script)


@pytest.mark.parametrize("command", ["RFOO", "R", "Rp2", "RAIN", "RAINA5", "RAINI1", "RDINA64", "RAA", "RUH", "RUAB"])
def test_what_is_no_report_sets_bs(bench, motor, command):
    assert send(bench, motor, f"{command} RBs") == b"1\r"
