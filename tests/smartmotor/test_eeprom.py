"""Section 6 of the base language: variables in the data EEPROM."""

import json

from axistwin import Bench

from .scripts import play, scripts
from .talking import ask, ready, send


@scripts({
    "VST stores variables, and after a power cut VLD loads them":
    "x=-5 y=70000 z=3 EPTR=100 VST(x,3) REPTR -> 112; power cycle; clear; "
    "Rx EPTR=100 VLD(a,3) Ra Rb Rc REPTR -> 0 -5 70000 3 112",
    "the most significant byte comes first":
    "EPTR=0 a=16909060 VST(a,1) EPTR=0 VLD(ab[0],4) Rab[0] Rab[3] -> 1 4; "
    "EPTR=0 VLD(aw[10],2) Raw[10] Raw[11] -> 258 772",
    "bytes and words are signed":
    "ab[0]=-2 aw[1]=-3 EPTR=0 VST(ab[0],1) VST(aw[1],1) ab[0]=0 aw[1]=0; "
    "EPTR=0 VLD(ab[0],1) VLD(aw[1],1) Rab[0] Raw[1] -> -2 -3",
    "what was never written is erased":
    "EPTR=7000 VLD(a,1) Ra VLD(ab[0],1) Rab[0] -> -1 -1",
    "6: a run of variables must stay within a…z, aa…zz or aaa…zzz; otherwise EPTR does not change and Bs is "
    "set":
    [f"EPTR=40 {command} REPTR RBs -> 40 1"
     for command in (
         "VST(x,4)", "VLD(x,4)", "VST(aa,27)", "VST(zzz,2)", "VST(a,0)", "VST(a,-1)", "VST(ab[203],2)",
         "VST(aw[101],2)", "VST(al[50],2)", "VST(ab[204],1)", "VST(ab[-1],1)", "VST(ab[a,1)", "VST(a[0],1)",
         "VST(A,1)", "VST(a)", "VST()", "VST(a,)", "VST(,1)", "VST(ab[0]x,1)", "VLD(P,1)", "VST",
     )],
    "a whole group is valid":
    [f"EPTR=0 VST({run}) EPTR=0 VLD({run}) RBs -> 0"
     for run in ("x,3", "aa,26", "aaa,26", "ab[0],204", "aw[0],102", "al[0],51", "a,26")],
    "an index may be an expression":
    "n=4 ab[5]=77 EPTR=9 VST(ab[n+1],1) EPTR=9 VLD(ab[0],n-3) Rab[0] -> 77",
    "6: EPTR is 0 to 7999":
    "EPTR=7996 VST(a,1) REPTR RBs -> 8000 0; "
    "VST(ab[0],1) REPTR RBs Zs EPTR=8000 REPTR RBs Zs EPTR=-1 RBs -> 8000 1 8000 1 1; "
    "Zs EPTR=7997 VST(a,1) REPTR RBs -> 7997 1",
    "its size is an option":
    "with data_bytes=256; EPTR=255 VST(ab[0],1) REPTR EPTR=256 RBs -> 256 1",
    "The manuals give no time; 21 samples are 5.16 ms, the write cycle of an EEPROM. Reading takes one "
    "statement":
    "load CLK=0 / VST(a,1) / a=CLK / VLD(b,1) / b=CLK / END; RUN; 0.1 s; Ra Rb -> 22 24",
})  # fmt: skip
def test_eeprom(script):
    play(script)


def test_the_pointer_moves_by_the_size_of_what_is_stored(bench, motor):
    """VST advances EPTR by 4 bytes per variable, 1 per ab[] and 2 per aw[]; three variables are 12 bytes."""
    send(bench, motor, "EPTR=4000")
    pointers = [ask(bench, motor, f"VST({run}) REPTR") for run in ("hh,1", "ab[7],1", "aw[7],1", "x,3", "al[3],2")]
    assert pointers == ["4004", "4005", "4007", "4019", "4027"]


def test_what_is_written_is_on_the_disk_at_once(bench, tmp_path):
    send(bench, ready(bench, state=tmp_path), "EPTR=2 a=1 VST(a,1)")
    assert json.loads((tmp_path / "smartmotor.json").read_text())["eeprom"] == "ffff00000001"
    other = Bench()
    assert send(other, ready(other, state=tmp_path), "EPTR=2 VLD(a,1) Ra") == b"1\r"


def test_writing_what_is_there_already_changes_nothing(bench, tmp_path):
    motor = ready(bench, state=tmp_path)
    send(bench, motor, "a=1 VST(a,1)")
    kept = (tmp_path / "smartmotor.json").stat().st_ino
    send(bench, motor, "EPTR=0 VST(a,1)")
    assert (tmp_path / "smartmotor.json").stat().st_ino == kept
    send(bench, motor, "EPTR=0 a=2 VST(a,1)")
    assert (tmp_path / "smartmotor.json").stat().st_ino != kept
