"""Refused lines are told once, with port, line, reason and remedy; accepted ones never."""

import pytest

from axistwin import Bench
from axistwin.bench import host_of
from axistwin.scenes.diagnostics.refused_lines import RefusedLines


def telling(bench: Bench) -> list[str]:
    told: list[str] = []
    RefusedLines(told.append).watch(bench)
    return told


def ready(model: str, **options) -> tuple[Bench, list[str]]:
    """Return a bench with an initialised controller, and the lines that are told from now on."""
    bench = Bench()
    bench.add(model, **options)
    bench.run(1.5)
    if model == "if1":
        say(bench, "(", "U61\r", seconds=2)
    return bench, telling(bench)


def say(bench: Bench, *lines: str, seconds: float = 0.5) -> None:
    """Send lines, in hex to a board, each when the one before has been processed."""
    (controller,) = bench.controllers.values()
    board = controller.product.language is not None
    with host_of(controller) as host:
        for line in lines:
            host.write(bytes.fromhex(line) if board else line.encode("latin-1"))
            bench.run(seconds)


DEFAULT = "31 00 00 00 00 61 A8 00 03 D0 90"  # 25,000 steps/s, 250,000 steps/s²
STREAMING = "51 01 04 00 00 00 00"
MOVE_OFF = "UCI UDI ZS A=100 V=100000 P=4000 G "

IF1 = [
    (("x100\r",), ["if1: refused x100: unknown character 'x': commands are upper case; write X [DP101]"]),
    (("X100 E\r",), ["if1: refused X100 E: E (busy) must be the only command in its message [DP103]: Send a status"]),
    (("@25001\r",), ["if1: refused @25001: speed 25001 is above 25000 steps/s, the maximum of range 1 [DP301]: The h"]),
    # the range is of an earlier message
    ((">4\r", "@4001\r"), ["if1: refused @4001: speed 4001 is above 4000 steps/s, the maximum of range 4 [DP301]"]),
    (("@10001\r", "X200/Y100$\r"), ["if1: refused X200/Y100$: in linear interpolation, "]),
    (("%\r",), ["if1: refused %: % gives control back to a sequence, but no sequence has given control"]),
    (("[\r", "X1$\r", "[\r", "E\r"), ["if1: refused X1$: the interface is locked by ["]),
    (("(U61\r",), ["if1: refused (U61: "]),
    (("X100$\r", "@400\r", "E\r", ":X1:$\r", "H1X10$\r", "#\r", " \r", "\r\n"), []),
]  # fmt: skip
SMARTMOTOR = [
    (("FLY\r",), ["smartmotor: refused FLY: unknown command FLY [SM101]: The motor sets the status bit Bs"]),
    (("A100 ",), ["smartmotor: refused A100: A100: an assignment needs its equal sign, A=100; insert"]),
    (("WAIT=5\r",), ["smartmotor: refused WAIT=5: WAIT= is valid only in a program [SM108]"]),
    (("E=40000\r",), ["smartmotor: refused E=40000: 40000 is out of range: expected 0 to 32000"]),
    # the value is known only to the motor
    (("v=40000 E=v\r",), ["smartmotor: refused E=v: 40000 is out of range: expected 0 to 32000"]),
    (("b=0 a=1/b\r",), ["smartmotor: refused a=1/b: it cannot be computed or stored"]),
    (("ab[204]=1\r",), ["smartmotor: refused ab[204]=1: it cannot be computed or stored"]),
    (("SLE SLP=10\r",), ["smartmotor: refused SLP=10: the software limits are enabled: send SLD first"]),
    (("P" * 65 + "\r",), ["smartmotor: refused " + "P" * 60 + "…: it has more than 64 characters (Bc)"]),
    (("RP\x81",), ["smartmotor: refused RP: the byte 81h came before its end"]),
    ((MOVE_OFF, "RP\r", "ab[0] 1 2 3.\r", "SLEEP\r", "FLY\r", "WAKE\r", 'PRINT("x",a)\r'), []),
]  # fmt: skip
BOARD = [
    (("02",), ["1811: refused 02: no command 02: ignored [CM101]: An opcode is the first byte of a command. Some"]),
    (("33 00 00",), ["1811: refused 33 00 00: go_relative (33) has 2 parameter bytes: expected 4 [CM103]"]),
    (("40 07",), ["1811: refused 40 07: move 7 is not defined here [CM304]"]),
    (("41 02",), ["1811: refused 41 02: sequence 2 is not defined here [CM209]"]),
    (("C8 33 51 00 00 61 A8 00 03 D0 90 00 00 00 0A",), ["1811: refused C8 33 51 00 00 61 A8 00 03 D0 90 00 00 00 0A"]),
    (("29 00 00 00 01",), ["1811: refused 29 00 00 00 01: wait_milliseconds (29) is valid in a sequence only [CM202]"]),
    (("42",), ["1811: refused 42: it is valid in a streaming mode only: send 51, 52 or 53 first"]),
    ((STREAMING, "40 01", "42"), ["1811: refused 40 01: it is not valid in streaming mode 51: send 50 (indexer",
                                  "1811: refused 42: the streaming buffer is empty: send data"]),
    ((STREAMING, "E1" + " 00" * 14), ["1811: refused E1" + " 00" * 14 + ": the data are for mode 52, but the pre"]),
    ((DEFAULT, "33 00 10 00 00", "33 00 00 00 01", "30", "70"),
     ["1811: refused 33 00 00 00 01: the move, search or joystick before has not ended",
      "1811: refused 30: the motor is moving, or the joystick is enabled"]),
    ((DEFAULT, "D9 01", "33 00 00 10 00", "70", "D8"), ["1811: refused 70: it cannot be in a sequence: send D8 first"]),
    ((DEFAULT, "33 00 00 00 64", "83", "88", "D9 01", "83", "D8", "41 01", "70"), []),
]  # fmt: skip
CASES = [
    (model, *case) for model, cases in (("if1", IF1), ("smartmotor", SMARTMOTOR), ("1811", BOARD)) for case in cases
]


@pytest.mark.parametrize(("model", "lines", "expected"), CASES, ids=lambda value: str(value)[:40])
def test_a_refused_line_is_told_with_reason_and_remedy(model, lines, expected):
    bench, told = ready(model)
    say(bench, *lines, seconds=2)
    assert [text[: len(begin)] for text, begin in zip(told, expected, strict=False)] == expected
    assert len(told) == len(expected), told[len(expected) :]
    assert not any("\n" in text for text in told)


def test_a_move_that_a_fault_inhibits_is_told_with_the_way_out():
    bench, told = ready("if1")
    bench["if1"].pins["limit_plus"].drive(False)
    say(bench, "X100$\r", "X-100$\r", "K\r", "X-100$\r")
    assert told == [
        "if1: refused X100$: the fault limit inhibits motion: send K, then move away from limit_plus",
        "if1: refused X-100$: the fault limit inhibits motion: send K",
    ]
    assert bench["if1"].axes["X"].position == -100


def test_what_is_said_about_a_loaded_program_is_true_and_helps():
    bench, told = ready("smartmotor")
    say(bench, "LOAD\r", "UCI UDI ZS ", "LOAD ", "C5 a=1 END \xff\xff", "GOSUB5 ")
    assert len(told) == 1 and "UCI UDI ZS" in told[0]


@pytest.mark.parametrize("model", ["if1", "smartmotor"])
def test_a_line_may_come_in_pieces_and_with_others(model):
    bench, told = ready(model, line="instant")
    say(bench, "x", "y", "z\rE\rx", "yz\r" if model == "if1" else "yz\nRP ")
    say(bench, "xyz\rxyz\r")
    assert [text.split(":")[1] for text in told] == [" refused xyz"] + [" refused E"] * (model == "smartmotor")


@pytest.mark.parametrize(("model", "on"), [("if1", "U62\r"), ("smartmotor", "ECHO ")])
def test_echoes_change_nothing(model, on):
    """Formats 2, 5 and 6 of the second digit echo; a SmartMotor echoes after ECHO."""
    bench = Bench()
    bench.add(model)
    bench.run(1.5)
    told = telling(bench)
    say(bench, *(["("] if model == "if1" else []), on, "xyz\r", seconds=2)
    assert len(told) == 1 and f"{model}: refused xyz: " in told[0]


def test_a_polling_host_does_not_flood():
    bench, told = ready("if1", line="instant")
    refused = RefusedLines((late := []).append)
    refused.watch(bench)
    for _ in range(42):
        say(bench, "xyz\r", "E\r", seconds=0.01)
    refused.close()
    assert [text.partition(" (the ")[2] for text in told[1:]] == ["same 9 times more)"]
    assert [text.partition(" (the ")[2] for text in late[1:]] == ["same 9 times more)", "same 41 times more)"]


def test_ever_different_lines_do_not_flood():
    """100 lines are told; the 900 others are told as 10 and 100, and as 900 at the end."""
    bench, _ = ready("if1", line="instant")
    refused = RefusedLines((told := []).append)
    refused.watch(bench)
    for number in range(1000):
        say(bench, f"x{number}\r", seconds=0.001)
    refused.close()
    assert told[100:] == [f"if1: refused {count} further lines" for count in (10, 100, 900)]


def test_in_a_chain_only_the_motor_that_is_addressed_refuses():
    bench = Bench()
    motors = [bench.add("smartmotor", name=f"motor{number}") for number in (1, 2)]
    chain = bench.chain(*motors, name="chain")
    bench.run(1)
    chain.write(b"\x80SADDR1 ECHO \x81SLEEP \x80SADDR2 ECHO \x81WAKE ")
    bench.run(1)
    told = telling(bench)
    chain.write(b"\x82FLY \x81RP ")
    bench.run(1)
    assert [text.partition(": unknown")[0] for text in told] == ["chain (motor2): refused FLY"]


def test_the_second_channel_is_named():
    bench = Bench()
    motor = bench.add("smartmotor")
    port = motor.rs485
    bench.run(1)
    motor.serial.write(b"OCHN(RS4,1,N,9600,1,8,C) ")
    bench.run(1)
    told = telling(bench)
    port.write(b"FLY ")
    bench.run(1)
    assert [text.partition(": unknown")[0] for text in told] == ["smartmotor.rs485: refused FLY"]


def test_a_program_and_its_download_are_not_lines_of_the_host():
    bench, told = ready("smartmotor")
    say(bench, "UCI UDI ZS LOAD ", "FLY a=1/0 GOSUB9 END \xff\xff", "RUN\r")
    answers = []
    with host_of(bench["smartmotor"]) as host:
        host.subscribe_received(answers.append)
        say(bench, "RBs\r")
    assert (told, b"".join(answers)) == ([], b"1\r")


def test_when_nobody_listens_nothing_is_checked():
    bench, told = ready("if1")
    end = RefusedLines(told.append).watch(bench)
    end()
    say(bench, "x1\r")
    assert len(told) == 1  # of the first listener


RATIO = "B0 00 01 00 01"
LOOP = (RATIO, "B1 00 00 61 A8", "B2 00 00 00 00", "B3 01 10 50 00 00 61 A8", "B4 00 00 00 32")
PAIRS = "E0" + " 20 00 7F FF" * 3  # a quarter of the clock's maximum, for 32,767 pulses each
FAR = "33 00 10 00 00"  # 1,048,576 pulses at 25,000 pulses/s: 42 s
NEAR = "33 00 00 00 01"
WAITS = "28 00"

REMEDIES = [
    ("if1", ["["], "X1$", "send ] first", ["]"]),
    ("if1", [":%:$"], ":X1:$", "a sequence has given control to the host: send % first", ["%"]),
    ("if1", [":%:$"], ":X1:$", "or # to cancel it", ["#"]),
    ("smartmotor", ["SLE"], "SLP=10", "send SLD first", ["SLD"]),
    ("smartmotor", ["MFDIV=0"], "MFR", "MFDIV=1", ["MFDIV=1"]),
    ("smartmotor", ["SIZE=101 BASE=100"], "MC", "BASE at least SIZE: set them first", ["BASE=101"]),
    ("smartmotor", [], "LOAD", "in a limit fault, as pins C and D are not held low: give", ["UCI UDI ZS"]),
    ("smartmotor", ["EPTR=7999"], "VST(a,1)", "or a lower EPTR", ["EPTR=0"]),
    ("smartmotor", [], "GOSUB5", "the stored program has no label C5: load one that has",
     ["UCI UDI ZS", "LOAD", "END C5 RETURN \xff\xff"]),
    ("1811", [], NEAR, "31 (default velocity and acceleration) must be sent first", [DEFAULT]),
    ("1811", [DEFAULT], "39 00", "38 (define home) must be sent first", ["38 01 00 32 00"]),
    ("1811", ["38 01 00 32 00"], "39 00", "31 (default velocity and acceleration) must be sent first", [DEFAULT]),
    ("1811", [DEFAULT, "12 01"], NEAR, "the motor is shut down: send 12 00 first", ["12 00"]),
    ("1811", ["13 01"], "12 01", "send 13 00 first", ["13 00"]),
    ("1811", [DEFAULT, "18 01"], NEAR, "send 18 00 first", ["18 00"]),
    ("1811", [DEFAULT, "38 01 00 32 00"], "3A 00", "send 18 01 first", ["18 01"]),
    ("1811", [STREAMING], "32 00", "send 50 (indexer mode) first", ["50", DEFAULT]),
    ("1811", [], PAIRS, "send 51, 52 or 53 first", [STREAMING]),
    ("1811", [STREAMING], "42", "send data (E0, E1 or E3) first", [PAIRS]),
    ("1811", ["53 01 04 00 00 00 00 00 02"], PAIRS, "send 51", [STREAMING]),
    ("1811", ["D9 01"], "70", "send D8 first", ["D8"]),
    ("1811", ["74 01 01 00"], "AC 01 01", "trigger 1 already has the function 74: disable it first", ["74 01 00 00"]),
    ("1811", [DEFAULT, FAR], "30", "wait until 88h reports rest", ["70"]),
    ("1811", ["11"], "30", "send 10 (disable joystick)", ["10"]),
    ("1811", [DEFAULT, FAR], NEAR, "or end it by 73 or 70", ["70"]),
    ("1811", [DEFAULT, "11"], NEAR, "the move, search or joystick before has not ended", ["10"]),
    ("1811", ["D9 01", WAITS, "D8", "41 01"], "41 01", "or end it by 79", ["79"]),
    ("1811", [STREAMING, PAIRS, "42"], STREAMING, "or end it by 7B", ["7B", "70"]),
    ("1811", [DEFAULT], "35 00 00 00 01", "B0 to B4 (ratio, resolution, sigma, algorithm, teeth) must", LOOP),
    ("1811", ["D4 01 50 00 00 61 A8 00 03 D0 90 00 00 00 01"], "40 01", "B0 (ratio) must be sent first", [RATIO]),
    ("1811", [DEFAULT, *LOOP], "37", "send 35 or 36 first", ["35 00 00 00 00"]),
]  # fmt: skip


@pytest.mark.parametrize(("model", "before", "line", "words", "remedy"), REMEDIES, ids=lambda value: str(value)[:30])
def test_who_does_what_is_said_is_out_of_trouble(model, before, line, words, remedy):
    bench, told = ready(model, line="instant") if model != "1811" else ready(model)
    refused = []
    bench[model].subscribe_refusals(refused.append)
    end = "" if model == "1811" else "\r"
    say(bench, *(f"{each}{end}" for each in before))
    assert refused == []
    say(bench, f"{line}{end}")
    assert [text for text in told if text.startswith(f"{model}: refused {line}: ") and words in text], told
    say(bench, *(f"{each}{end}" for each in remedy), seconds=3)
    refused.clear()
    say(bench, f"{line}{end}")
    assert refused == []
