"""`axistwin run`."""

import json
import os
import re
from hashlib import sha256
from html import escape
from pathlib import Path

import pytest

from axistwin import Bench
from axistwin.cli.common.working import RunProgress
from axistwin.cli.program import execute, main


@pytest.fixture
def axistwin(tmp_path, monkeypatch, capsys):
    """Run the program in an empty directory; returns exit code, stdout and stderr."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as caught:
            main(["run", *arguments])
        return (caught.value.code, *capsys.readouterr())

    return call


TALK = "+1.5\n> (\n< U\\r\n> U61\\r\n+1.5\n> X100$\\r\n+1\n= X.position {}\n"


def test_command_lines(axistwin):
    Path("a.if1").write_text("S1$\nX1000@1000$\nN\n")
    code, out, err = axistwin("if1", "a.if1")
    assert (code, err) == (0, "")
    said, _, summary = out.partition("\n\n")
    times = [float(line[:14]) for line in said.splitlines()]
    assert times == sorted(times) and times[1] == 1.5
    assert [line[16:].partition(", until")[0] for line in said.splitlines()] == [
        "= led low", "> (", r"< U\r", r"> U61\r", "= led low", r"> S1$\r", r"> X1000@1000$\r", "= output1 high",
        "  X 0 → 1000, up to 1000 pulses/s", r"> N\r", r"< 1000\r",
    ]  # fmt: skip
    assert summary.splitlines() == [
        "axis  from    to  pulses      moving  moves",
        "X        0  1000    1000  1.042000 s      1",
    ]


def test_json(axistwin):
    Path("a.if1").write_text("X1000@1000$\nN\n")
    code, out, err = axistwin("if1", "a.if1", "--json")
    told = json.loads(out)
    assert (code, err) == (0, "")
    answer = told["said"][-1]
    assert 0 < answer.pop("time_ns") < answer.pop("end_ns") <= told["end_ns"]
    assert answer == {"controller": "if1", "by": "controller", "text": r"1000\r", "errors": []}
    assert [(m["axis"], m["from"], m["to"], m["top_rate"]) for m in told["moves"]] == [("X", 0, 1000, 1000.0)]
    assert told["axes"][0] == {"controller": "if1", "axis": "X", "position": 1000, "pulses": 1000}
    assert told["difference"] is None and told["complete"] is True


def test_a_conversation_that_holds(axistwin):
    Path("a.talk").write_text(TALK.format(100))
    code, out, err = axistwin("if1", "a.talk")
    assert (code, err) == (0, "") and "X 0 → 100" in out


def test_a_conversation_that_differs(axistwin):
    Path("a.talk").write_text(TALK.format(99))
    code, out, err = axistwin("if1", "a.talk")
    assert code == 1 and "X 0 → 100" in out
    assert err.startswith("axistwin: a.talk:8: at 4.003229167 s X.position is different\n  expected  99\n")
    assert json.loads(axistwin("if1", "a.talk", "--json")[1])["difference"]["line"] == 8


def test_a_conversation_says_which_options_it_needs(axistwin):
    Path("a.talk").write_text("; options: wiring=3-wire\n; line: 2400 8N2\n+1.5\n! dtr off\n> (\n< U\\r\n")
    assert axistwin("if1", "a.talk")[0] == 0 and axistwin("if1", "a.talk", "--option", "wiring=5-wire")[0] == 1


def test_for(axistwin):
    Path("a.if1").write_text("X@1000G$\n")
    out = axistwin("if1", "a.if1", "--for", "20")[1]
    assert "X 0 → 17" in out and "still moving at 20.000000" in out
    Path("a.talk").write_text(TALK.format(100))
    assert json.loads(axistwin("if1", "a.talk", "--for", "9", "--json")[1])["end_ns"] == 9_000_000_000


def test_what_never_ends_is_told(axistwin):
    Path("a.if1").write_text(":X400:=0,1:$\n")
    code, _, err = axistwin("if1", "a.if1")
    assert code == 0
    assert err == "axistwin: the program does not end: stopped after 3600 s, set another time with --for SECONDS\n"


def test_options_of_the_model_and_of_axes(axistwin):
    Path("a.if1").write_text("X1000$\nK\n")
    out = axistwin("if1", "a.if1", "--option", "X.limits=[-10,100]", "--option", "recalculation_s=0.1")[1]
    assert "= limit_plus low" in out and r"< 64\r" in out


def test_a_motor_that_stalls_is_told(axistwin):
    Path("a.if1").write_text("X1000@1000$\n")
    out = axistwin(
        "if1", "a.if1", "--option", "X.motor={torque=[[0,0.5],[900,0.0]]}", "--option", "X.load={torque=0.1}"
    )[1]
    assert "X is at " in out and " pulses" in out.splitlines()[-1]


def test_state_is_kept(axistwin, tmp_path):
    Path("a.if1").write_text("@777\n[\n")
    assert axistwin("if2", "a.if1", "--state", "battery")[0] == 0
    assert [file.name for file in (tmp_path / "battery").glob("*.json*")] == ["if2.json"]


def test_traces_and_a_plot(axistwin, tmp_path):
    Path("a.if1").write_text("S1$\nX100Y-50$\n")
    code, _, err = axistwin("if1", "a.if1", "--trace", "a.csv", "--trace", "a.vcd", "--plot", "a.svg")
    assert (code, err) == (0, "")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.csv", "a.gtkw", "a.if1", "a.svg", "a.vcd"]


def test_a_report_is_one_page_with_picture_conversation_verdict_and_provenance(axistwin):
    Path("a.if1").write_text("S1$\nX100$\n")
    code, out, _ = axistwin("if1", "a.if1", "--report", "a.html", "--option", "self_test_s=0.5")
    page = Path("a.html").read_text(encoding="utf-8")
    assert code == 0
    assert re.search(r'<p class="verdict good">completed at [\d.]+ s of virtual time</p>', page)
    assert page.count("<svg") == 1
    for line in filter(None, out.splitlines()):
        assert escape(line) in page
    assert f"a.if1, SHA-256 {sha256(b'S1$' + os.linesep.encode() + b'X100$' + os.linesep.encode()).hexdigest()}" in page
    assert "<th>controller if1</th><td>if1 {&quot;self_test_s&quot;: 0.5}</td>" in page
    assert not re.search(r"<script|<link|src=|@import|url\((?!#)", page)


def test_a_report_has_extreme_positions_and_opened_limits(axistwin):
    Path("a.if1").write_text("X1500@1000$\n+4\nK\nX-200@1000$\n+4\n")
    code, _, _ = axistwin("if1", "a.if1", "--report", "a.html", "--option", "X.limits=[-100,1000]")
    page = Path("a.html").read_text(encoding="utf-8")
    least, greatest = re.search(r"X: least position (\d+), greatest (\d+) pulses", page).groups()
    assert int(least) == 0 and 1001 <= int(greatest) <= 1100
    assert len(re.findall(r"if1\.limit_plus opened: low", page)) == 1 and code == 0


def test_the_report_of_a_run_that_fails_says_why(axistwin):
    Path("a.talk").write_text("; model: if1\n+2\n> (\n< V\\r\n")
    code, _, err = axistwin("if1", "a.talk", "--report", "a.html")
    page = Path("a.html").read_text(encoding="utf-8")
    assert code == 1
    assert '<p class="verdict bad">failed at' in page and escape(err.strip().removeprefix("axistwin: ")) in page


def test_a_trace_ends_at_its_limit_and_the_run_continues(axistwin):
    Path("a.if1").write_text("X1000$\n")
    code, out, err = axistwin("if1", "a.if1", "--trace", "a.csv", "--trace-limit", "5kB")
    assert (code, "X 0 → 1000" in out) == (0, True)
    assert "the trace a.csv ends at" in err and "because the trace file has reached the size limit of 0.005 MB" in err
    code, _, err = axistwin("if1", "a.if1", "--trace", "a.csv", "--trace-limit", "none")
    assert (code, err) == (0, "") and Path("a.csv").stat().st_size > 5_000


@pytest.mark.parametrize(("arguments", "words"), [
    (("if1", "a.if1", "--report", "a.pdf"), "'a.pdf' is not a name for a report: expected a name that ends in .html"),
    (("if1", "a.if1", "--report", "no/where.html"), "no/where.html cannot be written"),
    (("if1", "a.if1", "--trace-limit", "much"), "invalid size 'much': expected a size or none, e.g. 200MB"),
    (("if1", "none.if1"), "none.if1 cannot be read: No such file"),
    (("if9", "a.if1"), "no model 'if9'"),
    (("if1", "a.if1", "--option", "wires=3"), "no option 'wires'"),
    (("if1", "a.if1", "--option", "wires"), "NAME=VALUE"),
    (("if1", "a.if1", "--plot", "a.pdf"), ".svg or .png"),
    (("if1", "a.if1", "--trace", "a.txt"), ".sigrok.vcd or .parquet"),
    (("if1", "a.if1", "--trace", "no/where.csv"), "no/where.csv cannot be written"),
    (("if1", "a.if1", "--for", "-1"), "Invalid value for '--for'"),
    (("a.toml", "a.if1", "--state", "x"), "make these settings in the scene file"),
    (("if1",), "the PROGRAM is missing: expected a file for an IF1")])  # fmt: skip
def test_wrong_usage(axistwin, arguments, words):
    Path("a.if1").write_text("X1$\n")
    code, out, err = axistwin(*arguments)
    assert (code, out) == (2, "") and words in err


def test_a_program_with_mistakes(axistwin):
    Path("a.talk").write_text("+1\n? what\n")
    code, _, err = axistwin("if1", "a.talk")
    assert code == 1 and err.startswith("axistwin: a.talk:2:1: unknown kind of line")


def test_a_scene(axistwin):
    Path("a.toml").write_text(
        '[[controller]]\nmodel = "if1"\nname = "left"\n[[controller]]\nmodel = "if1"\nname = "right"\n'
    )
    Path("a.talk").write_text("+1.5\nleft: > (\nleft: < U\\r\n")
    code, out, _ = axistwin("a.toml", "a.talk")
    assert code == 0 and r"1.502083  left: < U\r" in out


REFUSED = [
    ("if1", "a.if1", "X1000@99999$\nX100$\nx\n", ["DP301", "DP101"]),
    ("1811", "a.181x", "33 00 00 00 10\n70\n", ["CM305"]),
    ("smartmotor", "a.sms", "UCI UDI ZS\nFOO\nEND\n", ["SM101"]),
    ("if1", "a.talk", "+1.5\n> (\n< U\\r\n> U61\\r\n+1.5\n> x\n> y\\r\n", ["DP101"]),
    ("1811", "a.talk", "; model: 1811\n+1.5\n> 33 00 00 00 10\n", ["CM305"]),
]


@pytest.mark.parametrize(("model", "name", "text", "codes"), REFUSED)
def test_refused_lines_are_marked_in_the_listing(axistwin, model, name, text, codes):
    Path(name).write_text(text)
    code, out, err = axistwin(model, name, "--for", "5")
    marked = [line.split()[1] for line in out.splitlines() if re.match(r" {16}! ", line)]
    assert (code, marked) == (1, codes)
    assert err == f"axistwin: {len(codes)} line{'s' * (len(codes) > 1)} refused: axistwin check {model} {name}\n"
    assert [each["code"] for each in json.loads(axistwin(model, name, "--for", "5", "--json")[1])["refused"]] == codes


ENDLESS = ":X100:X-100:=0,1:$\n"
LOOP = "31 00 00 00 00 61 A8 00 03 D0 90\nD9 01\n21 01\n33 00 00 10 00\nD8\n41 01\n"


@pytest.mark.slow
@pytest.mark.parametrize(("name", "text", "says", "followed", "options"), [
    ("a.if1", "XG$\n", "X still running: run longer with --for SECONDS", "XG$\n", ("--for", "5")),
    ("a.if1", ENDLESS, "stopped after 3600 s, set another time with --for SECONDS", ENDLESS, ("--for", "5")),
    ("a.if1", f"{ENDLESS}#\n", "write +SECONDS above line 2 to send line 2", f"{ENDLESS}+2\n#\n", ()),
    ("a.181x", f"{LOOP}71\n", "write +SECONDS above line 7 to send line 7", f"{LOOP}+2\n71\n", ())])  # fmt: skip
def test_what_a_note_says_leads_out(axistwin, name, text, says, followed, options):
    model = {".if1": "if1", ".181x": "1811"}[Path(name).suffix]
    Path(name).write_text(text)
    assert says in axistwin(model, name)[2]
    Path(name).write_text(followed)
    assert axistwin(model, name, *options)[::2] == (0, "")


def test_a_run_that_ends_too_early(axistwin):
    Path("a.if1").write_text("X100$\n")
    note = axistwin("if1", "a.if1", "--for", "2")[2]
    longer = re.search(r"run longer with --for SECONDS, e\.g\. (--for \S+)", note)[1]
    code, out, err = axistwin("if1", "a.if1", *longer.split())
    assert (code, err) == (0, "") and r"> X100$\r" in out


def test_the_check_that_a_run_names_finds_the_refused_line(axistwin, capsys):
    Path("a.if1").write_text("X100$\nx\n")
    assert execute(axistwin("if1", "a.if1")[2].partition("refused: axistwin ")[2].split()) == 1
    assert capsys.readouterr().out.startswith("a.if1:2:1: error: unknown character 'x'")


def test_a_motor_that_is_left_asleep_is_told(axistwin):
    Path("a.talk").write_text("+0.5\n> UCI UDI ZS A=100 V=100000 MP\\r\n> SLEEP\\r\n> P=500 G\\r\n+1\n")
    code, _, err = axistwin("smartmotor", "a.talk")
    assert (code, err) == (0, "axistwin: smartmotor: asleep, so that it ignores all commands but WAKE: WAKE\n")


def test_a_refused_line_is_marked_below_its_message(axistwin):
    Path("a.if1").write_text("X100$\nx\nX100$\n")
    lines = [line[16:].partition(" up to")[0] for line in axistwin("if1", "a.if1")[1].splitlines()]
    at = lines.index(r"> x\r")
    assert lines[at + 1] == "! DP101 unknown character 'x': commands are upper case  (a.if1:2:1)"
    assert lines[at + 2] == r"> X100$\r"


def test_refused_lines_of_the_hosts_of_a_scene(axistwin):
    two = '[[controller]]\nmodel="if1"\nname="{}"\nhost="{}.if1"\n'
    Path("s.toml").write_text(two.format("a", "a") + two.format("b", "b"))
    Path("a.if1").write_text("X10$\n")
    Path("b.if1").write_text("X10$\nx\n")
    code, out, err = axistwin("s.toml")
    assert (code, err) == (1, "axistwin: 1 line refused: axistwin check s.toml\n")
    assert "b: ! DP101 unknown character" in out and "a: !" not in out


@pytest.mark.parametrize("option", [(), ("--strict",)])
def test_without_a_refused_line_the_exit_code_is_0(axistwin, option):
    Path("a.if1").write_text("X100$\n")
    assert axistwin("if1", "a.if1", *option)[0] == 0


def test_an_interrupted_run_shows_what_was_done(axistwin, monkeypatch):
    def interrupt(bench, deadline_ns):
        bench.run(3)
        raise KeyboardInterrupt

    Path("a.if1").write_text("X1000@1000$\n")
    monkeypatch.setattr("axistwin.bench.programs.running._finish_run", lambda bench, *_: interrupt(bench, 0))
    code, out, err = axistwin("if1", "a.if1", "--plot", "a.svg")
    assert (code, err) == (130, "axistwin: interrupted at 5.71812 s\n")
    assert "X        0  1000" in out and Path("a.svg").stat().st_size > 0


def test_progress_is_in_virtual_time(tmp_path):
    bench = Bench()
    bench.run(30)
    (tmp_path / "t.vcd").write_bytes(bytes(2_500_000))
    shown = str(RunProgress("a.if1", bench, 120.0, (tmp_path / "t.vcd",)).__rich__())
    assert re.fullmatch(r"running a\.if1: 30\.0 s, 25 %, \d+ times real time, trace 2\.5 MB", shown)
