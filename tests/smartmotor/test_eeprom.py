"""Section 6 of the base language: variables in the data EEPROM."""

import json

import pytest

from axistwin import Bench

from .talking import ask, clear, load, ready, send


def test_variables_survive_without_power(bench, motor):
    """VST stores variables, and after a power cut VLD loads them."""
    assert send(bench, motor, "x=-5 y=70000 z=3 EPTR=100 VST(x,3) REPTR") == b"112\r"
    motor.power_cycle()
    clear(bench, motor)
    assert send(bench, motor, "Rx EPTR=100 VLD(a,3) Ra Rb Rc REPTR") == b"0\r-5\r70000\r3\r112\r"


def test_the_pointer_moves_by_the_size_of_what_is_stored(bench, motor):
    """VST advances EPTR by 4 bytes per variable, 1 per ab[] and 2 per aw[]; three variables are 12 bytes."""
    send(bench, motor, "EPTR=4000")
    pointers = [ask(bench, motor, f"VST({run}) REPTR") for run in ("hh,1", "ab[7],1", "aw[7],1", "x,3", "al[3],2")]
    assert pointers == ["4004", "4005", "4007", "4019", "4027"]


def test_the_most_significant_byte_comes_first(bench, motor):
    assert send(bench, motor, "EPTR=0 a=16909060 VST(a,1) EPTR=0 VLD(ab[0],4) Rab[0] Rab[3]") == b"1\r4\r"
    assert send(bench, motor, "EPTR=0 VLD(aw[10],2) Raw[10] Raw[11]") == b"258\r772\r"


def test_bytes_and_words_are_signed(bench, motor):
    assert send(bench, motor, "ab[0]=-2 aw[1]=-3 EPTR=0 VST(ab[0],1) VST(aw[1],1) ab[0]=0 aw[1]=0") == b""
    assert send(bench, motor, "EPTR=0 VLD(ab[0],1) VLD(aw[1],1) Rab[0] Raw[1]") == b"-2\r-3\r"


def test_what_was_never_written_is_erased(bench, motor):
    assert send(bench, motor, "EPTR=7000 VLD(a,1) Ra VLD(ab[0],1) Rab[0]") == b"-1\r-1\r"


@pytest.mark.parametrize(
    "command",
    ["VST(x,4)", "VLD(x,4)", "VST(aa,27)", "VST(zzz,2)", "VST(a,0)", "VST(a,-1)", "VST(ab[203],2)", "VST(aw[101],2)",
     "VST(al[50],2)", "VST(ab[204],1)", "VST(ab[-1],1)", "VST(ab[a,1)", "VST(a[0],1)", "VST(A,1)", "VST(a)", "VST()",
     "VST(a,)", "VST(,1)", "VST(ab[0]x,1)", "VLD(P,1)", "VST"],
)  # fmt: skip
def test_a_run_that_goes_beyond_its_group_is_invalid(bench, motor, command):
    """6: a run of variables must stay within a…z, aa…zz or aaa…zzz; otherwise EPTR does not change and Bs is set."""
    assert send(bench, motor, f"EPTR=40 {command} REPTR RBs") == b"40\r1\r"


@pytest.mark.parametrize("run", ["x,3", "aa,26", "aaa,26", "ab[0],204", "aw[0],102", "al[0],51", "a,26"])
def test_a_whole_group_is_valid(bench, motor, run):
    assert send(bench, motor, f"EPTR=0 VST({run}) EPTR=0 VLD({run}) RBs") == b"0\r"


def test_an_index_may_be_an_expression(bench, motor):
    assert send(bench, motor, "n=4 ab[5]=77 EPTR=9 VST(ab[n+1],1) EPTR=9 VLD(ab[0],n-3) Rab[0]") == b"77\r"


def test_the_eeprom_has_8000_bytes(bench, motor):
    """6: EPTR is 0 to 7999."""
    assert send(bench, motor, "EPTR=7996 VST(a,1) REPTR RBs") == b"8000\r0\r"
    assert (
        send(bench, motor, "VST(ab[0],1) REPTR RBs Zs EPTR=8000 REPTR RBs Zs EPTR=-1 RBs") == b"8000\r1\r8000\r1\r1\r"
    )
    assert send(bench, motor, "Zs EPTR=7997 VST(a,1) REPTR RBs") == b"7997\r1\r"


def test_its_size_is_an_option(bench):
    motor = ready(bench, data_bytes=256)
    assert send(bench, motor, "EPTR=255 VST(ab[0],1) REPTR EPTR=256 RBs") == b"256\r1\r"


def test_writing_takes_a_program_5_ms(bench, motor):
    """The manuals give no time; 21 samples are 5.16 ms, the write cycle of an EEPROM.  Reading takes one statement."""
    load(bench, motor, "CLK=0\nVST(a,1)\na=CLK\nVLD(b,1)\nb=CLK\nEND\n")
    send(bench, motor, "RUN", 0.1)
    assert send(bench, motor, "Ra Rb") == b"22\r24\r"


def test_what_is_written_is_on_the_disk_at_once(bench, tmp_path):
    motor = ready(bench, state=tmp_path)
    send(bench, motor, "EPTR=2 a=1 VST(a,1)")
    assert json.loads((tmp_path / "smartmotor.json").read_text())["eeprom"] == "ffff00000001"
    other = Bench()
    again = ready(other, state=tmp_path)
    assert send(other, again, "EPTR=2 VLD(a,1) Ra") == b"1\r"


def test_writing_what_is_there_already_changes_nothing(bench, tmp_path):
    motor = ready(bench, state=tmp_path)
    send(bench, motor, "a=1 VST(a,1)")
    kept = (tmp_path / "smartmotor.json").stat().st_ino
    send(bench, motor, "EPTR=0 VST(a,1)")
    assert (tmp_path / "smartmotor.json").stat().st_ino == kept
    send(bench, motor, "EPTR=0 a=2 VST(a,1)")
    assert (tmp_path / "smartmotor.json").stat().st_ino != kept
