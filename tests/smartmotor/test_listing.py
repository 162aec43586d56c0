"""The stored program as lines, the running line, and the sample in which each line begins."""

import json
from pathlib import Path
from random import Random

import pytest

from axistwin import Bench, tracing
from axistwin.bench import Controller
from axistwin.controllers.smartmotor.kernel import state

from .reference.inventing import program as invented
from .scripts import play, scripts
from .talking import SAMPLE_NS, advance, ask, load, ready, send, wired


def listing(motor: Controller):
    return motor.programs["program"]


def running(motor: Controller) -> int | None:
    """Return the number of the running line; the first line is 1."""
    index = listing(motor).running
    return None if index is None else index + 1


def motor_with(bench: Bench, program: str, **options: object) -> Controller:
    """Return a motor without faults, at a whole sample, with this program, not started."""
    motor = ready(bench, **options)
    load(bench, motor, program)
    advance(bench, 1)
    return motor


def watched(bench: Bench, motor: Controller) -> list[tuple[int, int]]:
    """Return a list that receives, for each line that begins, the time in samples from now and the line number."""
    found: list[tuple[int, int]] = []
    zero_ns = bench.now

    def watch(program: str, index: int) -> None:
        assert program == "program"
        assert running(motor) == index + 1 and motor.registers["line"].read() == index + 1
        sample, beside = divmod(bench.now - zero_ns, SAMPLE_NS)
        assert beside == 0
        found.append((sample, index + 1))

    motor.subscribe_lines(watch)
    return found


def started(bench: Bench, motor: Controller, count: int, command: str = "RUN") -> list[tuple[int, int]]:
    """Return the lines that begin within `count` samples after this command."""
    found = watched(bench, motor)
    send(bench, motor, command, 0)
    advance(bench, count)
    return found


@scripts({
    # Running
    "With option statements_per_sample=2, two statements are executed in each sample":
    "with statements_per_sample=2; load a=1 / b=2 / c=3 / d=4 / e=5; 1 sample; watch lines; RUN; 10 samples; "
    "lines 1@1 2@1 3@2 4@2 5@3",
    "A line begins when it is entered from another line, even in its middle, or when it jumps back within "
    "itself":
    "load a=1 GOSUB5 b=2 / c=3 END / C5 d=4 RETURN; 1 sample; watch lines; RUN; 20 samples; "
    "lines 1@1 3@3 1@5 2@6",
    "WHILE, a=a+1, LOOP: three samples per pass":
    "load a=0 / WHILE a<3 a=a+1 LOOP / END; 1 sample; watch lines; RUN; 20 samples; "
    "lines 1@1 2@2 2@5 2@8 2@11 3@12",
    "4.3: RUN? ends a program that power-up has started; RUN then starts it from the top":
    "load a=a+1 / RUN? / b=1 / END; 1 sample; power cycle; watch lines; 0.3 s; lines 1 2; no line; "
    "UCI UDI ZS RUN; 0.01 s; lines 1 2 1 2 3 4",
    "Between RUN and the next sample the running line is the first line":
    "load a=1 / b=1 / END; 1 sample; RUN; 0.01 s; 1 sample; RUN; line 1; 0.0002 s; line 1",
    "Base 8: if no program is running, a GOSUB from the host ends at its RETURN":
    "load a=1 / END / C5 / b=1 / RETURN; 1 sample; watch lines; GOSUB5; 10 samples; lines 4@1 5@2; no line; "
    "Ra -> 0",
    'F=64: WAIT is "the only motor instruction that will be truncated" by C2; the statement after it follows':
    "wired; load UGI F=64 / WAIT=4000 / c=1 / END / C2 / b=1 / RETURNI; 1 sample; watch lines; RUN; "
    "20 samples; line 2; G low; 10 samples; lines 1 2 6 7 3 4",
    "An invalid statement sets Bs when reached":
    "load a=1 / NONSENSE / b=GETCHR / END; 1 sample; watch lines; RUN; 10 samples; lines 1@1 2@2 3@3 4@4; "
    "RBs -> 1",
    # Lines
    "3 and 15: comments and needless blanks are not stored; line numbers count stored lines":
    "load ' a table<CR><LF>A=100   V=200 ' slowly<CR><LF><CR><LF>  C5<CR><LF>a=a+1<CR>GOTO5; "
    "lists A=100 V=200 / C5 / a=a+1 / GOTO5",
    "a program in one line has a line for each statement":
    'load A=100 IF a==3 PRINT("two words",a) aw[0] 1 2 3. ENDIF END; '
    'lists A=100 / IF a==3 / PRINT("two words",a) / aw[0] 1 2 3. / ENDIF / END',
    "LOCKP prevents uploads; the listing still shows the program":
    "load a=1 / END; LOCKP; title stored program, locked; lists a=1 / END",
    # Running
    "Ruling 14: the first statement is executed in the sample after RUN; LOOP and WHILE take a sample, C5 none":
    "load a=0 / WHILE a<2 / a=a+1 / GOSUB5 / LOOP / END / C5 / b=b+1 / RETURN; 1 sample; watch lines; RUN; "
    "20 samples; "
    "lines 1@1 2@2 3@3 4@4 8@5 9@6 5@7 2@8 3@9 4@10 8@11 9@12 5@13 2@14 6@15; no line; b is 2",
    "WAIT=40 is executed in sample 2, so the next statement is executed in sample 42":
    "load a=1 / WAIT=40 / b=1 / END; 1 sample; watch lines; RUN; 3 samples; "
    + 38 * "line 2; 1 sample; "
    + "lines 1@1 2@2; 1 sample; line 3; lines 1@1 2@2 3@42",
    # the move takes 30 samples, at one count per sample, and begins in the sample of G
    "Bt becomes 0 in the sample that commands the target; the next sample executes the statement after TWAIT":
    "load A=65536 V=65536 P=30 MP / G / TWAIT / b=1 / END; 1 sample; watch lines; RUN; 6 samples; line 3; "
    "40 samples; "
    "lines 1@1 2@5 3@6 4@35 5@36",
    "Base 8: `!` holds the program in its line until the host sends a character":
    "load a=1 / ! / b=1 / END; 1 sample; RUN; 100 samples; line 2; sends <SP>; 0.01 s; no line",
    "host commands are no lines":
    "load a=1 / END; 1 sample; watch lines; b=1 WAIT=3 A=100 Rb -> 1; 10 samples; lines",
    "what ends the program ends its line":
    [f"load a=1 / WAIT=4000 / END; 1 sample; RUN; 10 samples; line 2; {how}; no line"
     for how in ("END", "sends LOAD<SP> -> *", "Z", "power off")],
    "15: LOAD ends the running program; the subscriber then receives the lines of the new program":
    "load WHILE 1 / a=a+1 / LOOP; 1 sample; RUN; 10 samples; a > 0; load b=1 / b=2 / b=3 / b=4 / END; "
    "watch lines; RUN; "
    "0.01 s; lines 1 2 3 4 5",
})  # fmt: skip
def test_listing(script):
    play(script)


# Lines


def test_a_motor_that_was_never_programmed_has_an_empty_program(bench):
    motor = bench.add("smartmotor")
    assert listing(motor).lines == () and listing(motor).title == "stored program"
    assert running(motor) is None


def test_lines_that_take_no_time_are_marked(bench):
    """Labels, ENDIF, ENDS and DEFAULT take no sample; a CASE, ELSE, LOOP or BREAK that is reached takes one."""
    text = "C1\nIF a\nELSE\nENDIF\nSWITCH a\nCASE 1\nBREAK\nDEFAULT\nENDS\nWHILE 0\nLOOP\nC2 END\n"
    motor = motor_with(bench, text)
    lines = listing(motor).lines
    assert [lines[n] for n in sorted(listing(motor).silent)] == ["C1", "ENDIF", "DEFAULT", "ENDS"]


def test_a_download_that_is_cut_off_leaves_a_program_that_is_not_valid(bench):
    """15: an incomplete program does not run and sets Bk, also after a power cycle."""
    motor = motor_with(bench, "a=1\nEND\n")
    assert send(bench, motor, b"LOAD ") == b"\x06" and listing(motor).lines == ()
    assert listing(motor).title == "stored program, not valid: flag Bk"
    send(bench, motor, b"b=1\nb=2\n")
    motor.power_cycle()
    assert (listing(motor).lines, running(motor)) == ((), None)
    bench.run(1)
    assert listing(motor).title == "stored program, not valid: flag Bk"


def test_a_damaged_program_is_shown_and_never_runs(bench, motor):
    """15: if an image that states its length loses a character on the line, RCKS reports F, and it never runs."""
    image = b"$4000000100000009000000" + b"0000a=1\nEND\n"
    send(bench, motor, b"LOAD ")
    for at in range(0, len(image), 8):
        send(bench, motor, image[at : at + 8])
    send(bench, motor, b"\xff\xff ")
    assert ask(bench, motor, "RCKS").endswith("F")
    found = started(bench, motor, 10)
    assert (listing(motor).lines, running(motor), found) == (("a=1", "END"), None, [])
    assert listing(motor).title == "stored program, not valid: flag Bk"


def test_the_program_is_there_without_power_and_on_disk(bench, tmp_path):
    motor = ready(bench, state=tmp_path)
    load(bench, motor, "WHILE 1\nLOOP\n")
    send(bench, motor, "RUN", 0.1)
    assert running(motor) is not None
    motor.power(False)
    assert (listing(motor).lines, running(motor), motor.registers["line"].read()) == (("WHILE 1", "LOOP"), None, 0)
    again = Bench().add("smartmotor", name="smartmotor", state=tmp_path)
    assert listing(again).lines == ("WHILE 1", "LOOP")


def test_a_broken_memory_on_disk(tmp_path):
    kept = {"version": 1, "program": "a=1\nb=", "broken": True, "locked": False, "eeprom": ""}
    (tmp_path / "smartmotor.json").write_text(json.dumps(kept))
    motor = Bench().add("smartmotor", state=tmp_path)
    assert listing(motor).lines == ("a=1", "b=") and listing(motor).running is None


# Running


def test_a_report_holds_the_program_in_its_line(bench):
    """While its 100 characters wait for the transmitter at 9600 baud, the line of a report is the running line."""
    motor = motor_with(bench, f'a=1\nPRINT("{"x" * 100}")\nPRINT("y")\nEND\n')
    found = started(bench, motor, 0)
    motor.serial.instant = False
    advance(bench, 425)
    assert running(motor) == 2
    advance(bench, 5)
    assert found == [(1, 1), (2, 2), (426, 3), (427, 4)], "104,166,667 ns behind sample 2 is in sample 426"
    assert running(motor) is None


def test_c1_and_c2_run_their_bodies(bench):
    """7.0, F=32 and F=64: the program continues where it was interrupted."""
    motor = wired(bench)
    load(bench, motor, "UGI F=96\nWHILE 1\nLOOP\nEND\nC1\na=1\nRETURNF\nC2\nb=1\nRETURNI\n")
    advance(bench, 1)
    found = started(bench, motor, 20)
    motor.pins["C"].drive(True)
    advance(bench, 8)
    motor.pins["G"].drive(False)
    advance(bench, 12)
    calls = [line for _, line in found if line > 4]
    assert calls == [6, 7, 9, 10]
    assert [sample for sample, _ in found[1:]] == list(range(3, 3 + len(found) - 1)), "a statement in each sample"


def test_a_protection_fault_ends_the_program_in_its_line(bench):
    """4.1 without F=32: the program ends in the sample of the fault."""
    motor = ready(bench, shaft={"motor": "frame23"})
    load(bench, motor, "E=10 MP A=100 V=100000 P=100000 G\nWHILE 1\nLOOP\n")
    motor.axes["shaft"].jam(True)
    send(bench, motor, "RUN", 0)
    assert bench.run_until(lambda: running(motor) is None, 2) and ask(bench, motor, "RBe") == "1"


# At any time


def test_the_line_is_right_at_any_time_of_a_block_computed_ahead(bench):
    """Read at any time, without a subscriber, the running line is the one that a subscriber receives."""
    text = "a=0\nWHILE a<40\na=a+1\nIF a==20\nWAIT=25\nELSE\nb=b+a\nENDIF\nLOOP\nEND\n"
    motor = motor_with(bench, text)
    twin = Bench()
    other = motor_with(twin, text)
    assert twin.now == bench.now
    zero_ns, found = bench.now, started(twin, other, 400)
    send(bench, motor, "RUN", 0)
    random = Random(11)
    for moment in sorted(random.sample(range(SAMPLE_NS, 300 * SAMPLE_NS), 200)):
        bench.clock.run_to(zero_ns + moment)
        begun = [line for sample, line in found if sample * SAMPLE_NS <= moment]
        wanted = None if begun[-1] == 10 and moment >= (found[-1][0]) * SAMPLE_NS else begun[-1]
        assert running(motor) == wanted and motor.registers["line"].read() == (wanted or 0)


def arrays(motor: Controller) -> tuple[object, ...]:
    """Return the processor's state without obsolete return addresses and without the PC of a stopped program."""
    processor = motor._device._motor
    processor.catch_up()
    i = list(processor.i)
    depth = i[state.DEPTH]
    i[state.RETURNS + depth : state.RETURNS + 10] = [0] * (10 - depth)
    if i[state.PROGRAM] == state.STOPPED:
        i[state.PC] = 0
    return i, list(processor.v), list(processor.f)


def session(seed: int, *, watch: bool) -> list[object]:
    """Run a random program, disturbed by a host and switches; return everything read meanwhile."""
    bench, random = Bench(), Random(seed)
    options = {"statements_per_sample": random.choice([1, 1, 3]), "debounce_samples": 1}
    motor = wired(bench, **options)
    load(bench, motor, "UGI F=96 A=6553 V=65536 MP\n" + invented(random) + "\n")
    ends = [motor.subscribe_lines(lambda *_: None)] if watch else []
    seen: list[object] = []
    for _ in range(12):
        act, line = random.randrange(7), random.choice([None, ("program", random.randrange(9))])
        if act < 3:
            motor.serial.write(
                random.choice(["RUN ", "GOSUB1 ", "a=1 ", "P=P+50 G ", "Ra RP ", "END ", "RETURN "]).encode()
            )
        elif act == 3:
            motor.pins["G"].drive(random.random() < 0.5)
        elif act == 4:
            motor.pins["C"].drive(random.random() < 0.2)
        elif act == 5 and watch and ends:
            ends.pop()()
        elif act == 6 and watch and not ends:
            ends.append(motor.subscribe_lines(lambda *_: None, line))
        bench.clock.run_to(bench.now + random.randrange(40 * SAMPLE_NS))
        seen += [bench.now, motor.serial.read(), motor.axes["shaft"].position, running(motor)]
    for end in ends:
        end()
    return [*seen, arrays(motor)]


@pytest.mark.parametrize("seed", range(30))
def test_subscribers_make_no_difference(seed):
    """Subscribers that come and go at any time do not change the processor's final state."""
    assert session(seed, watch=True) == session(seed, watch=False)


def test_a_subscriber_may_unsubscribe_in_its_callback(bench):
    """If the subscriber unsubscribes during its own call, the program continues as without a subscriber."""
    motor = motor_with(bench, "a=0\nWHILE a<9\na=a+1\nGOSUB5\nLOOP\nEND\nC5\nb=b+1\nRETURN\n")
    found = []

    def watch(program, index):
        found.append(index)
        if len(found) == 6:
            unsubscribe()

    unsubscribe = motor.subscribe_lines(watch)
    send(bench, motor, "RUN", 0.05)
    assert found == [0, 1, 2, 3, 7, 8]
    assert (ask(bench, motor, "Rb"), running(motor)) == ("9", None)


def test_a_second_watcher_sees_the_same(bench):
    motor = motor_with(bench, "a=1\nb=2\nEND\n")
    one, two = watched(bench, motor), watched(bench, motor)
    send(bench, motor, "RUN", 0.01)
    assert one == two == [(1, 1), (2, 2), (3, 3)]


@pytest.mark.parametrize("line", range(1, 11))
def test_one_followed_line_is_reported_as_among_all_lines(bench, line):
    """The times of one line are the same, whether one line or all lines are followed."""
    text = "a=0\nWHILE a<4\na=a+1 GOSUB5 c=c+1\nLOOP\nd=0 WHILE d<3 d=d+1 LOOP\nEND\nC5\nb=b+1 RETURN\nc=9\nd=9\n"
    motor = motor_with(bench, text)
    every, one = watched(bench, motor), []
    motor.subscribe_lines(lambda program, index: one.append(index + 1), ("program", line - 1))
    send(bench, motor, "RUN", 0.05)
    again = Bench()
    other, alone = motor_with(again, text), []
    other.subscribe_lines(lambda program, index: alone.append(again.now), ("program", line - 1))
    send(again, other, "RUN", 0.05)
    assert [line] * len(alone) == one == [found for _, found in every if found == line]
    zero_ns = bench.now - 50_000_000
    assert alone == [zero_ns + sample * SAMPLE_NS for sample, found in every if found == line]


def test_the_next_program_is_watched_at_the_line_of_that_number(bench):
    motor, found = motor_with(bench, "a=1\nEND\n"), []
    motor.subscribe_lines(lambda program, index: found.append(index), ("program", 2))
    send(bench, motor, "RUN", 0.01)
    assert found == []
    load(bench, motor, "b=1\nb=2\nb=3\nEND\n")
    send(bench, motor, "RUN", 0.01)
    motor.power_cycle()
    bench.run(0.3)
    assert found == [2, 2]


def test_without_subscribers_nothing_is_announced(bench):
    """After the last subscriber has gone, the code in the memory contains no announcements."""
    motor = motor_with(bench, "WHILE 1\na=a+1\nLOOP\n")
    plain = list(motor._device._motor.core.code)
    unsubscribe = motor.subscribe_lines(lambda *_: None)
    assert list(motor._device._motor.core.code) != plain
    unsubscribe()
    assert list(motor._device._motor.core.code) == plain


# In a trace


def traced(path: Path, *, watch: bool) -> bytes:
    bench = Bench()
    motor = motor_with(bench, "A=100 V=65536 MP\nC5\nP=a*9 G TWAIT\na=a+1\nIF a<20\nGOTO5\nENDIF\nPRINT(a)\nEND\n")
    if watch:
        motor.subscribe_lines(lambda *_: None)
    with tracing(bench, path, ("*", "smartmotor.line")):
        motor.serial.write(b"RUN ")
        bench.run(0.5)
    return path.read_bytes()


def test_a_trace_of_everything_is_the_same_byte_for_byte(tmp_path):
    seen, unseen = traced(tmp_path / "a.csv", watch=True), traced(tmp_path / "b.csv", watch=False)
    assert seen == unseen and unseen.count(b",smartmotor.line,") > 10


def test_the_line_is_followed_in_its_samples(bench):
    """A trace has the number of the running line; it is 0 after the end of the program and without power."""
    motor = motor_with(bench, "a=1\nC5\nWAIT=3\na=a+1\nIF a<3\nGOTO5\nENDIF\nEND\n")
    changes = []
    zero = bench.now // SAMPLE_NS
    end = motor.follow(["Ra", "line"], lambda *told: changes.extend(zip(*told, strict=True)))
    send(bench, motor, "RUN", 0)
    advance(bench, 30)
    lines = [(ns // SAMPLE_NS - zero, value) for ns, which, value in changes if which == 1]
    assert lines == [(0, 1), (2, 3), (5, 4), (6, 5), (7, 6), (8, 3), (11, 4), (12, 5), (13, 0)], (
        "END ends in the sample in which it begins"
    )
    values = [(ns // SAMPLE_NS - zero, value) for ns, which, value in changes if which == 0]
    assert values == [(1, 1), (5, 2), (11, 3)]
    changes.clear()
    send(bench, motor, "GOTO5", 0)
    motor.power(False)
    advance(bench, 3)
    assert [value for _, which, value in changes if which == 1] == [3, 0]
    end()
