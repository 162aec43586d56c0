"""The commands for SmartMotors: programs, conversations, recordings, traces, plots, scenes, ports, term."""

import json
import re

import pytest

from axistwin import Bench, Scene
from axistwin.bench.talk.conversation import parse, write
from axistwin.bench.talk.player import play
from axistwin.bench.talk.recorder import recording
from axistwin.core.errors import ProgramError, SceneError
from axistwin.plant.counts import Samples
from axistwin.plant.servo_axis import ServoAxis
from axistwin.records.plots.picture import save
from axistwin.records.plots.trace_chart import of_trace
from axistwin.records.traces.memory import tracing_in_memory
from axistwin.records.traces.trace import tracing
from axistwin.scenes.reports.servo_moves import ServoMoves
from axistwin.sim.clock import Clock

from ..command import ended, run, serving
from ..links.serving import dial

MS = 10**6

TALK = """\
; model: smartmotor
; options: shaft.limits=[-9000,9000]
+0.3
> RSP\\r
< 24576/476\\r
> MP A=100 V=100000 P=2000 G\\r
+1
= shaft.position 2000
= shaft.commanded 2000
= shaft.velocity 0
! A 2.5V
= A.volts 2.5
> RUAA\\r
< 512\\r
! A low
= A low
= A.volts 0
! A release
= A high
= shaft.temperature 25
! ambient 40
= ambient 40
> MF0\\r
! master 4000 in 2
+1
= master 2000
! shaft.push 5
= shaft.encoder 2005
! brake release
"""

PROGRAM = """\
UCI 'C and D are no limit switches here: \xb5
UDI
ZS
RUN?
MP
A=100
V=100000
D=2000
PRINT("off we go",#13)
a=0
WHILE a<2
  G
  TWAIT
  a=a+1
  WAIT=1000
LOOP
RP
END
"""


def motor_on_a_bench(**options):
    bench = Bench()
    motor = bench.add("smartmotor", **({"shaft": {"limits": (-9000, 9000)}} | options))
    bench.run(0.3)
    return bench, motor


def tell(bench, motor, text, seconds=0.1):
    motor.serial.write(text.encode())
    bench.run(seconds)
    return motor.serial.read()


# Conversations


def test_a_conversation():
    bench = Bench()
    bench.add("smartmotor", shaft={"limits": (-9000, 9000)})
    assert play(parse(TALK), bench) is None


@pytest.mark.parametrize(("line", "words"), [
    ("! A 2,5V", "invalid level '2,5V': expected high, on, low, off, release or a voltage, e.g. 2.5V"),
    ("! A 24V", "voltage 24V would destroy the pin: expected 0 to 5 V"),
    (
        "! master 4000",
        (
            "invalid value '4000' of the action `! master` (external encoder): "
            "expected `COUNTS in SECONDS` or `on CONTROLLER.AXIS times RATIO`, e.g. `4000 in 2`"
        ),
    ),
    ("! ambient hot", "'hot' is not a number"),
    ("! dtr low", "unknown name 'dtr': expected one of A, B, C, D, E, F, G, brake, index, power, break, line"),
    ("= dtr low", "unknown name 'dtr'"),
    ("= shaft.pulses 3", "unknown name 'shaft.pulses'"),
    ("= brake.volts 3", "unknown name 'brake.volts'"),
    ("chain: > RP", "unknown controller 'chain': expected one of smartmotor"),
    ("nobody.rs485: > RP", "no controller 'nobody.rs485' on the bench: expected one of smartmotor")])  # fmt: skip
def test_what_a_motor_does_not_have_is_told_before_anything_is_done(line, words):
    bench, _ = motor_on_a_bench()
    with pytest.raises(ProgramError, match=re.escape(words)):
        play(parse(f"> ZS\\r\n{line}\n"), bench)
    assert bench["smartmotor"].serial.pending == 0


def test_a_conversation_with_the_second_channel():
    bench, _ = motor_on_a_bench()
    talk = "; model: smartmotor\n> OCHN(RS4,1,N,9600,1,8,C)\\r\n+0.1\nsmartmotor.rs485: > RSP\\r\n"
    assert play(parse(f"{talk}smartmotor.rs485: < 24576/476\\r\n<\n"), bench) is None
    assert play(parse(f"{talk}smartmotor.rs485: < 24576/477\\r\n"), bench).got == r"24576/476\r"


def test_a_conversation_with_a_chain():
    """The first ECHO reaches the first motor, the second ECHO the second motor; then all characters pass through."""
    bench = Bench()
    bench.chain(bench.add("smartmotor", "left"), bench.add("smartmotor", "right"))
    talk = """\
+0.3
chain: > ECHO\\r
+0.1
chain: > ECHO\\r
+0.1
chain: <
left: ! A low
chain: > RUA\\r
chain: < RUA\\r1\\r0\\r
left: = A low
chain: ! line 1200
"""
    assert play(parse(talk), bench) is None and bench.port("chain").host.baudrate == 1200
    with pytest.raises(
        ProgramError,
        match=r"missing controller name before `= A low`: expected one of left, right, e\.g\. `left: = A low`",
    ):
        play(parse("> RP\\r\n= A low"), bench)


def test_a_recording_is_played_again_to_the_nanosecond():
    bench, motor = motor_on_a_bench()
    with recording(bench) as recorder:
        tell(bench, motor, "MP A=100 V=100000 P=2000 G\r", 0.2)
        motor.pins["A"].drive(1.25)
        tell(bench, motor, "RUAA\r")
        motor.pins["A"].drive(True)
        bench.run(0.1)
        motor.pins["A"].drive(False)
        bench.run(0.1)
        motor.pins["A"].release()
        tell(bench, motor, "RP RUA\r", 1)
    text = write(recorder.conversation())
    assert "! A 1.25V\n" in text and "! A high\n" in text
    assert "! A release\n" in text and text.endswith("= shaft.position 2000\n")
    again = Bench()
    again.add("smartmotor", shaft={"limits": (-9000, 9000)})
    assert play(parse(text), again) is None and again.now == bench.now


# Programs


def test_a_stored_program(tmp_path):
    program, trace, plot = tmp_path / "p.sms", tmp_path / "t.csv", tmp_path / "p.svg"
    program.write_bytes(PROGRAM.encode("latin-1"))
    code, told, noted = run("run", "smartmotor", program, "--trace", trace, "--plot", plot)
    assert (code, noted) == (0, "")
    lines = [line[14:].strip() for line in told.splitlines() if re.match(r" +\d", line)]
    assert lines[0] == r"> RUN\r" and r"< off we go\r" in lines
    assert lines[-1] == r"< 4000\r"
    moves = [line for line in lines if line.startswith("shaft")]
    assert [re.sub(", until.*", "", move) for move in moves] == [
        "shaft 0 → 2000, up to 6358 counts/s", "shaft 2000 → 4000, up to 6358 counts/s",
    ]  # fmt: skip
    assert "smartmotor.shaft.position,4000" in trace.read_text()
    assert plot.read_text().startswith("<?xml")


def test_a_program_that_never_ends(tmp_path):
    program = tmp_path / "p.sms"
    program.write_text("WHILE 1\n  WAIT=4069\n  a=a+1\nLOOP\n")
    _, _, noted = run("run", "smartmotor", program)
    assert "the program does not end: stopped after 60 s, set another time with --for SECONDS" in noted
    assert run("run", "smartmotor", program, "--for", "2")[2] == ""


def test_a_program_as_json(tmp_path):
    program = tmp_path / "p.sms"
    program.write_bytes(PROGRAM.encode("latin-1"))
    result = json.loads(run("run", "smartmotor", program, "--json")[1])
    assert [(move["from"], move["to"]) for move in result["moves"]] == [(0, 2000), (2000, 4000)]
    assert result["axes"] == [{"controller": "smartmotor", "axis": "shaft", "position": 4000, "commanded": 4000}]
    assert result["complete"]


def test_a_move_ends_at_a_reversal(tmp_path):
    program = tmp_path / "p.sms"
    program.write_text("UCI UDI ZS A=100 V=800000\nWHILE a<3 P=2000 G TWAIT P=0 G TWAIT a=a+1 LOOP\nEND\n")
    result = json.loads(run("run", "smartmotor", program, "--json")[1])
    assert [(move["from"], move["to"]) for move in result["moves"]] == [(0, 2000), (2000, 0)] * 3
    assert "12000" in run("run", "smartmotor", program)[1].splitlines()[-1].split()


def test_a_program_that_does_not_fit(tmp_path):
    program = tmp_path / "p.sms"
    program.write_text("a=1\n" * 100)
    code, _, told = run("run", "smartmotor", program, "--option", "program_bytes=256")
    assert code == 1
    assert "too many for the program memory of the motor: shorten the program, or increase the option" in told


def test_a_program_for_nobody(tmp_path):
    program = tmp_path / "p.sms"
    program.write_text("END\n")
    assert (
        "p.sms: the simulation has 0 SmartMotors, but an .sms file needs exactly one" in run("run", "if1", program)[2]
    )
    assert run("run", "smartmotor", tmp_path / "q.sms")[2].endswith("q.sms cannot be read: No such file or directory\n")


def test_a_program_for_a_motor_in_a_chain(tmp_path):
    program, scene = tmp_path / "p.sms", tmp_path / "s.toml"
    program.write_text("END\n")
    scene.write_text('controller = [{model = "smartmotor", name = "left"}]\nchain = [{motors = ["left"]}]\n')
    assert (
        "p.sms: cannot load an .sms file into left on a shared serial line: use a .talk file, or connect the motor"
        in run("run", scene, program)[2]
    )


def test_a_program_is_kept_with_its_motor(tmp_path):
    program, state = tmp_path / "p.sms", tmp_path / "state"
    program.write_text('PRINT("here",#13)\nEND\n')
    run("run", "smartmotor", program, "--state", state)
    bench = Bench()
    motor = bench.add("smartmotor", state=state)
    bench.run(0.5)
    assert motor.serial.read() == b"here\r"


def test_a_source_is_checked_in_whatever_code_its_comments_are(tmp_path):
    program = tmp_path / "p.sms"
    program.write_bytes(b"' 20 \xb5m\n\tMP\n\tA100\nEND\n")
    code, told, _ = run("check", "smartmotor", program)
    assert code == 1
    assert told.startswith(f"{program}:3:2: error: A100: an assignment needs its equal sign")


@pytest.mark.parametrize(
    "source",
    [
        b"' wait\x85 A100\n' and\x1c LIMH\nRP\n",  # characters that Python takes for line ends
        b"\xef\xbb\xbfRP ' gr\xc3\xbc\xc3\x9fe\r\n",
        "RP\r\nEND ' größer\r\n".encode("utf-16"),
        b"RP\r\nEND\r\n\x1a\x1aA100\r\n",
        b"RP\rEND\r",
        b"RP '" + b"x" * 40_000 + b"\nEND\n",
    ],
    ids=["cp1252", "utf-8", "utf-16", "ctrl-z", "cr", "long comment"],
)
def test_sources_as_editors_leave_them(tmp_path, source):
    program = tmp_path / "P.SMS"
    program.write_bytes(source)
    assert run("check", "smartmotor", program)[:2] == (0, "")
    code, told, noted = run("run", "smartmotor", program)
    assert (code, noted) == (0, "")
    assert [line.split()[-1] for line in told.splitlines() if " < " in line] == [r"0\r"]


def test_a_source_that_only_begins_like_utf_8(tmp_path):
    program = tmp_path / "p.sms"
    program.write_bytes(b"\xef\xbb\xbf\xfc")
    code, _, told = run("run", "smartmotor", program)
    assert code == 2 and "p.sms cannot be read as utf-8: expected a text file" in told


def test_a_comment_in_quotes_is_sent(tmp_path):
    program = tmp_path / "p.sms"
    program.write_text("PRINT(\"it's\",#13) 'said\nEND\n")
    assert r"< it's\r" in run("run", "smartmotor", program)[1]


def test_errors_in_a_program_that_runs_are_told(tmp_path):
    program = tmp_path / "p.sms"
    program.write_text("A100\nLIMH\nRP\n")
    code, _, noted = run("run", "smartmotor", program)
    assert (code, noted) == (1, f"axistwin: 2 lines refused: axistwin check smartmotor {program}\n")
    program.write_text("A100\nWHILE 1\nLOOP\n")
    assert "with --for SECONDS; 1 line refused" in json.loads(run("run", "smartmotor", program, "--json")[1])["note"]


def test_a_program_on_a_line_that_the_motor_does_not_understand(tmp_path):
    program = tmp_path / "p.sms"
    program.write_text("END\n")
    code, _, told = run("run", "smartmotor", program, "--option", "line=1200 7E1")
    assert code == 1
    assert "the motor did not send the byte 06 after LOAD: check that the motor uses the line format 1200 7E1" in told


@pytest.mark.parametrize(("model", "name", "models"), [
    ("if1", "p.sms", "smartmotor"), ("1811", "p.if1", "if1 or if2"), ("smartmotor", "p.181x", "1810 or 1811")
])  # fmt: skip
def test_a_program_is_checked_for_its_own_family(tmp_path, model, name, models):
    (tmp_path / name).write_text("END\n")
    code, _, told = run("check", model, tmp_path / name)
    assert code == 2 and f"{name} is a program for {models}, not for {model}" in told


# Histories, traces, plots


def test_a_servo_has_position_and_commanded_in_a_trace(tmp_path):
    bench, motor = motor_on_a_bench()
    with tracing(bench, tmp_path / "a.csv"), tracing(bench, tmp_path / "a.vcd"):
        tell(bench, motor, "MP A=100 V=100000 P=2000 G\r", 1)
        motor.pins["A"].drive(2.5)
        bench.run(0.1)
    lines = [line for line in (tmp_path / "a.csv").read_text().splitlines() if not line.startswith("#")]
    rows = [line.split(",") for line in lines[1:]]
    assert [int(row[0]) for row in rows] == sorted(int(row[0]) for row in rows)
    positions = [(int(time), int(value)) for time, name, value in rows if name == "smartmotor.shaft.position"]
    commanded = [(int(time), int(value)) for time, name, value in rows if name == "smartmotor.shaft.commanded"]
    assert positions[0][1] == 0 and positions[-1][1] == 2000
    assert len({value for _, value in positions}) == len(positions)  # each change once
    assert positions[1:] == commanded[1:]  # an ideal motor
    assert [row[1:] for row in rows][-1] == ["smartmotor.A_volts", "2.5"]
    assert "$var real 64" in (tmp_path / "a.vcd").read_text()


def test_a_traced_bench_does_the_same_as_one_that_is_not(tmp_path):
    def session(trace):
        bench, motor = motor_on_a_bench(shaft={"motor": "frame23"})
        tell(bench, motor, "UCI UDI ZS\r")
        if trace:
            with tracing(bench, tmp_path / "a.csv"):
                answers = tell(bench, motor, "MP A=200 V=100000 P=500 G\rRP\r", 0.07) + tell(bench, motor, "RP RPE\r")
        else:
            answers = tell(bench, motor, "MP A=200 V=100000 P=500 G\rRP\r", 0.07) + tell(bench, motor, "RP RPE\r")
        return answers, motor.axes["shaft"].pulse_times().tolist(), bench.now

    assert session(trace=True) == session(trace=False)


def test_a_plot_has_position_and_following_error(tmp_path):
    bench, motor = motor_on_a_bench(shaft={"motor": "frame23"})
    with tracing_in_memory(bench) as memory:
        tell(bench, motor, "UCI UDI ZS MP A=200 V=100000 P=500 G\r", 0.5)
    save(of_trace(memory.trace()), tmp_path / "a.svg")
    text = (tmp_path / "a.svg").read_text()
    for words in ("shaft  position", "shaft  following", "error, counts", "position", "commanded"):
        assert f">{words}<" in text


def record_of(*stretches):
    """Return a record of an axis from samples (first ms, positions, commanded)."""
    axis = ServoAxis(Clock(), "shaft")
    record = ServoMoves("motor", "shaft", axis)
    axis.subscribe(record.add_samples)
    for first, positions, commanded in stretches:
        axis.publish(Samples(first * MS, MS, positions, commanded))
    return record


def test_moves_are_parted_by_rests():
    """Two moves: 3 counts in 3 ms, and from 199 ms on back to 1 count; actual and commanded positions agree."""
    record = record_of((0, [0, 1, 2, 3, 3], [0, 1, 2, 3, 3]), (199, [3, 2, 1], [3, 2, 1]))
    moves = record.moves_until(10**12)
    assert [(m.origin, m.target, m.start_ns, m.end_ns) for m in moves] == [
        (0, 3, 0, 3 * MS), (3, 1, 199 * MS, 201 * MS),
    ]  # fmt: skip


def test_trembling_about_the_place_is_no_move():
    assert record_of((1, [1, 0, -1, 0, 1] * 100, [0] * 500)).moves_until(10**12) == []


def test_a_shaft_that_is_turned_by_hand_moves():
    record = record_of((0, [0, 40], [0, 40]), (500, [40, 45, 50], [40, 40, 40]))
    assert [(move.origin, move.target) for move in record.moves_until(10**12)] == [(0, 40), (40, 50)]


def test_a_move_tells_where_the_shaft_settles():
    record = record_of((1, [10, 20, 33, 31, 30], [10, 20, 30, 30, 30]))
    assert [(move.target, move.high) for move in record.moves_until(10**12)] == [(30, 33)]


def test_a_velocity_is_taken_over_16_samples():
    """2 counts per ms are 2000 counts/s; one step of 7 counts does not make it 7000 counts/s."""
    positions = [2 * n + (3 if n == 50 else 0) for n in range(1, 101)]
    (move,) = record_of((1, positions, positions)).moves_until(10**12)
    assert move.top_rate == (2 * 16 + 3) / 0.016


def test_a_velocity_is_the_same_in_however_small_pieces_it_comes():
    positions = [2 * n for n in range(1, 101)]
    (whole,) = record_of((1, positions, positions)).moves_until(10**12)
    (pieces,) = record_of(*((n + 1, [two], [two]) for n, two in enumerate(positions))).moves_until(10**12)
    assert pieces.top_rate == whole.top_rate == 2000


def test_a_push_is_no_velocity():
    axis = ServoAxis(Clock(), "shaft")
    record = ServoMoves("motor", "shaft", axis)
    axis.subscribe(record.add_samples)
    axis.publish(Samples(0, MS, [0, 1, 2], [0, 1, 2]))
    axis.publish(Samples(3 * MS, 0, [500], [2]))
    axis.publish(Samples(3 * MS, MS, [501, 502], [3, 4]))
    (move,) = record.moves_until(10**12)
    assert move.top_rate == 2 / 0.016


# Scenes and ports

SCENE = """\
[[controller]]
model = "smartmotor"
name = "left"
axes.shaft = { limits = [-100, 5000], motor = "frame23", load = { inertia_kg_m2 = 1e-5 } }

[[controller]]
model = "smartmotor"
name = "right"

[[chain]]
motors = ["left", "right"]
ports = ["tcp://127.0.0.1:0"]

[[rs485]]
name = "field"
motors = ["right", "left"]
"""


@pytest.fixture
def scene(tmp_path):
    def load(text):
        (tmp_path / "s.toml").write_text(text)
        return Scene.load(tmp_path / "s.toml")

    return load


def test_a_scene_with_a_chain_and_a_line(scene):
    made = scene(SCENE)
    assert made.ports == [("chain", "tcp://127.0.0.1:0")]
    bench = made.build()
    assert list(bench.ports) == ["chain", "field"]
    assert [motor.name for motor in bench.lines["field"].motors] == ["right", "left"]
    assert bench["left"].axes["shaft"].motor.counts_per_rev == 2000 and bench["left"].pins["C"].level is False


WRONG = {
    "a key of a servo axis": (
        SCENE.replace("limits =", "limit ="), "4:16: axis shaft has no option 'limit': expected one of limits, motor",
    ),
    "a data sheet": (SCENE.replace('"frame23"', '"frame99"'), "4:39: invalid option of axis shaft: unknown motor"),
    "a load": (SCENE.replace("inertia_kg_m2", "mass"), "4:67: invalid option of axis shaft: unknown parameter 'mass'"),
    "a motor that is not there": (SCENE.replace('["left",', '["middle",'),
                                  "11:11: the scene has no controller 'middle': expected one of left, right"),
    "a motor twice": (SCENE.replace('["left", "right"]', '["left", "left"]'), "10:1: motor left is given twice"),
    "no motors": (SCENE.replace('["left", "right"]', "[]"), "11:1: chain.motors: list should have at least 1 item"),
    "a port": (SCENE.replace("tcp://127.0.0.1:0", "tcp"), "12:10: invalid port URL 'tcp'"),
    "a stepper in a chain": (
        SCENE.replace('"right"\n\n[[chain', '"right"\n[[controller]]\nmodel = "if1"\n[[chain').replace(
            '["left", "right"]', '["if1"]'
        ),
        "11:1: if1 cannot be in a daisy chain",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "message"), WRONG.values(), ids=WRONG.keys())
def test_a_wrong_scene_names_place_and_remedy(scene, tmp_path, text, message):
    with pytest.raises(SceneError) as caught:
        scene(text).build()
    assert str(caught.value).startswith(f"{tmp_path}/s.toml:{message}")


def answers(*arguments, sessions):
    """Return the answers of a server: each session is the name of a port, data to send, the end of the answer."""
    found = []
    with serving(*arguments, "--speed", "max", ports=len({name for name, _, _ in sessions})) as (program, ports):
        for name, data, end in sessions:
            with dial(dict(ports)[name]) as host:
                host.sendall(data)
                answer = b""
                while not answer.endswith(end):
                    answer += host.recv(100)
                found.append(answer)
        assert ended(program)[0] == 0
    return found


def test_serve_gives_a_chain_one_port(tmp_path):
    """Neither motor has an address: both answer, and the first motor's answer is a command to the second motor."""
    (tmp_path / "s.toml").write_text(SCENE)
    (answer,) = answers(tmp_path / "s.toml", sessions=[("chain", b"\x80ECHO \x80ECHO RCTR ", b"0\r")])
    assert answer.endswith(b"0\r")


def test_serve_gives_both_channels_of_a_motor_a_port():
    sessions = [
        ("smartmotor", b"ECHO OCHN(RS4,1,N,9600,1,8,C) ", b") "),
        ("smartmotor.rs485", b"RSP ", b"\r"),
        ("smartmotor", b"RSP ", b"\r"),
    ]
    assert answers("smartmotor", "--tcp", ":0", "--rs485", ":0", sessions=sessions)[1:] == [
        b"24576/476\r",
        b"RSP 24576/476\r",
    ]


# Term


def test_term():
    lines = ":drive A 2.5V\n:drive B low\n:drive ambient 30\nRSP\n:wait 0.2\n:pins\n:axes\n"
    code, told, _ = run("term", "smartmotor", "--speed", "max", typed=lines)
    assert code == 0
    rows = [line.split() for line in told.splitlines()]
    assert ["A", "high", "2.5V", "driven"] in rows and ["B", "low", "0V", "driven"] in rows
    assert ["C", "high", "5V"] in rows and ["brake", "high"] in rows
    assert ["shaft", "0", "at", "rest", "commanded", "0"] in rows
    assert "< 24576/476<CR>" in told


def test_a_motor_that_a_fault_keeps_from_moving_is_told_of(tmp_path):
    """3.1: with nothing wired "No motor shaft movement can be commanded until Limit switch errors are cleared"."""
    (tmp_path / "z.sms").write_text("ZS\nMP A=100 V=1000 P=100 G\nEND\n")
    code, _, message = run("run", "smartmotor", tmp_path / "z.sms")
    assert code == 0
    assert "axistwin: smartmotor: in a limit fault, as pins C and D are not held low: give" in message


def test_an_injected_fault_is_in_the_listing_and_in_json(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        '[[controller]]\nmodel = "if1"\naxes.X = { limits = [-100, 9000] }\nhost = "feed.if1"\n'
        '[[fault]]\nkind = "open_limit"\non = "if1"\nside = "plus"\nat = 5\n'
    )
    (tmp_path / "feed.if1").write_text("X8000@1000$\n")
    listing = run("run", scene)[1].splitlines()
    opened = next(n for n, line in enumerate(listing) if "! fault open_limit if1 side=plus" in line)
    assert listing[opened].split()[0] == "5.000000" and any("= limit_plus low" in line for line in listing[opened:])
    (fault,) = json.loads(run("run", scene, "--json")[1])["faults"]
    assert (fault["time_ns"], fault["controller"], fault["act"]) == (5_000_000_000, "if1", "fault")
