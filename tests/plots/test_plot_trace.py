"""Pictures of traces, and comparison of traces: `axistwin plot TRACE` and `axistwin diff`."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from axistwin import Bench
from axistwin.cli.program import main
from axistwin.core.units import MS, S
from axistwin.records.plots import picture
from axistwin.records.plots.chart import Fault
from axistwin.records.plots.trace_chart import messages, of_trace
from axistwin.records.traces.differences import Tolerance, compare
from axistwin.records.traces.reading import Track, read
from axistwin.records.traces.trace import tracing

SUFFIXES = "csv", "vcd", "parquet"
SIGNALS = ("default", "motor.RPE", "motor.RBt", "if1.state")


def session(path: Path, target: int = 300, early_s: float = 0.0, seconds: float = 2.0) -> Path:
    bench = Bench()
    if1, motor = bench.add("if1"), bench.add("smartmotor", "motor", shaft={"motor": "frame23"})
    with tracing(bench, path, SIGNALS):
        bench.run(1.5)
        for message in ("(", "U61\r"):
            if1.serial.write(message.encode())
            bench.run(1.2)
        bench.run(0.1 - early_s)
        if1.serial.write(b"X40@1000S1$\r")
        bench.run(0.1 + early_s)
        motor.serial.write(b"UCI UDI ZS A=100 V=400000 MP O=0 P=%d G RP " % target)
        bench.run(seconds)
    return path


@pytest.fixture(scope="module")
def directory(tmp_path_factory) -> Path:
    made = tmp_path_factory.mktemp("plots")
    for suffix in SUFFIXES:
        session(made / f"a.{suffix}")
    session(made / "b.csv", target=310)
    session(made / "early.csv", early_s=0.003)
    session(made / "short.csv", seconds=1.0)
    return made


def texts(svg: Path) -> list[str]:
    return [element.text or "" for element in ET.parse(svg).iter("{http://www.w3.org/2000/svg}text")]


def run(capsys, *arguments: object) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    said = capsys.readouterr()
    return ended.value.code, said.out, said.err


# Pictures


def test_a_picture_of_a_trace(directory, tmp_path, capsys):
    code, *_ = run(capsys, "plot", directory / "a.csv", "-o", tmp_path / "a.svg", "--title", "the same")
    found = texts(tmp_path / "a.svg")
    assert code == 0
    assert {"if1.X  velocity", "if1.X  position", "motor.shaft  following", "motor.RPE", "if1.output1"} <= set(found)
    assert {"host to if1", "host to motor", "motor", "seconds", "the same"} <= set(found)
    assert r"> X40@1000S1$\r" in found and "if1.Y  velocity" not in found


@pytest.mark.parametrize("suffix", ["vcd", "parquet"])
def test_the_chart_is_the_same_for_all_kinds(directory, suffix):
    assert of_trace(read(directory / f"a.{suffix}")) == of_trace(read(directory / "a.csv"))


def test_without_a_name_the_picture_is_written_beside_the_trace(directory, capsys):
    code, out, err = run(capsys, "plot", directory / "a.csv", "--signals", "if1.X.velocity")
    assert (code, out, err) == (0, "", f"axistwin: {directory / 'a.png'}\n")
    assert (directory / "a.png").read_bytes().startswith(b"\x89PNG")


def test_options_select_signals_and_a_time_span(tmp_path, directory, capsys):
    options = ("--signals", "if1.X.velocity,if1.output1", "--from", 4, "--to", 4.2, "-o", tmp_path / "a.svg")
    run(capsys, "plot", directory / "a.csv", *options)
    found = texts(tmp_path / "a.svg")
    assert {"if1.X  velocity", "a.csv"} <= set(found) and "if1.X  position" not in found
    assert not any("motor" in text for text in found)


def test_a_chart_contains_the_whole_motion(directory):
    chart = of_trace(read(directory / "a.csv"), from_ns=0)
    position = next(panel for panel in chart.panels if panel.label.startswith("if1.X  position"))
    assert position.lines[0].curve.values[-1] == 40
    shaft = next(panel for panel in chart.panels if panel.label.startswith("motor.shaft  position"))
    assert abs(shaft.lines[0].curve.values[-1] - 300) <= 3 and shaft.lines[1].curve.values[-1] == 300
    error = next(panel for panel in chart.panels if "following" in panel.label).lines[0].curve
    assert 1 < max(map(abs, error.values)) < 100
    assert chart.states["if1.state"][-1].text == "ready" and "motor.RBt" in chart.lanes


def test_faults_are_marked_and_have_no_lane(tmp_path):
    bench = Bench()
    bench.add("if1", X={"encoder": {}})
    bench.faults.add("stuck", "if1.input3", level="high")
    with tracing(bench, tmp_path / "a.csv"):
        bench.faults.add("power_cut", "if1", at=1.0, duration=0.5)
        bench.faults.add("push", "if1.X", counts=3, at=1.25)
        bench.run(2)
    chart = of_trace(read(tmp_path / "a.csv"), from_ns=0)
    assert chart.faults == [
        Fault("stuck", 0, None),
        Fault("power_cut", 1 * S, 1 * S + 500 * MS),
        Fault("push", 1 * S + 250 * MS, 1 * S + 250 * MS),
    ]
    assert not any("faults" in name for name in chart.states)
    assert not of_trace(read(tmp_path / "a.csv"), ("if1.led",)).faults, (
        "faults are drawn only if their signal is selected"
    )


def test_messages_are_complete():
    track = Track("if1.host_says", "string")
    for n, text in enumerate(("", "a", "ab", "", "ab", "c", r"c\x20", "c d")):  # the escape for a space at the end
        track.add(n, text)
    assert [(word.time_ns, word.text) for word in messages(track)] == [(1, "ab"), (4, "ab"), (5, "c d")]


def test_a_trace_in_which_nothing_happens(tmp_path, capsys):
    bench = Bench()
    bench.add("if1")
    with tracing(bench, tmp_path / "a.csv", ("if1.X.*",)):
        bench.run(1)
    assert run(capsys, "plot", tmp_path / "a.csv", "-o", tmp_path / "a.svg")[0] == 0
    assert "no signal changes in this time" in texts(tmp_path / "a.svg")


def test_the_picture_of_an_ideal_motor(tmp_path, capsys):
    """The error is 0, so its scale has whole counts; the legend is above the curves, and no row is empty.

    The title is that of the scene.
    """
    from matplotlib.figure import Figure

    (tmp_path / "s.toml").write_text("""title = "One $ two $"\n[[controller]]\nmodel = "smartmotor"\nname = "m"
program = "p.sms"\n""")
    (tmp_path / "p.sms").write_text("UCI UDI ZS A=100 V=400000 MP O=0 P=300 G TWAIT END\n")
    files = ("--trace", tmp_path / "a.csv", "--plot", tmp_path / "b.svg")
    assert run(capsys, "run", tmp_path / "s.toml", "--for", 1, *files)[0] == 0
    chart = of_trace(read(tmp_path / "a.csv"))
    assert not chart.words
    figure = picture._Picture(chart).draw(Figure())
    figure.draw_without_rendering()
    _, position, error, _ = figure.axes
    assert error.get_ylim() == (-1, 1)
    assert position.get_legend().get_window_extent().y0 >= position.get_window_extent().y1 - 1
    run(capsys, "plot", tmp_path / "a.csv", "-o", tmp_path / "a.svg")
    assert "One $ two $" in texts(tmp_path / "a.svg") and texts(tmp_path / "a.svg") == texts(tmp_path / "b.svg")
    assert not any("e−" in text for text in texts(tmp_path / "a.svg"))


def test_wrong_options_are_rejected(tmp_path, directory, capsys):
    trace = directory / "a.csv"
    for arguments, message in (
        ((trace, "--from", 2, "--to", 1), "--from 2 --to 1: expected --to after --from"),
        ((trace, "--from", 1000), "invalid --from 1000: expected a time before the end of the trace at "),
        ((trace, "--from", 1e300), "1e+300 s is too long: expected less than 292 years"),
        (
            (trace, "-o", tmp_path / "a.pdf"),
            "invalid file name 'a.pdf' for a picture: expected a name that ends in .svg or .png",
        ),
        ((trace, "--signals", "if1.Q.*"), "no signal matches 'if1.Q.*': there are if1."),
        ((tmp_path / "no.csv",), "cannot be read: No such file or directory"),
    ):
        code, _, err = run(capsys, "plot", *arguments)
        assert code == 2 and message in err


def test_without_a_screen(directory, capsys):
    code, _, err = run(capsys, "plot", directory / "a.csv", "--show")
    assert (code, err) == (2, "axistwin: no screen is available: write the picture to a file, e.g. --out chart.svg\n")


# Differences


@pytest.mark.parametrize(("other", "code", "expected"), [
    ("a.parquet", 0, "no difference in "),
    ("short.csv", 1, "one ends at 6.100000000 s, the other at 5.100000000 s\n")], ids=["equal", "shorter"])  # fmt: skip
def test_traces_without_a_different_value(directory, capsys, other, code, expected):
    found = run(capsys, "diff", directory / "a.csv", directory / other)
    assert (found[0], found[1][: len(expected)]) == (code, expected)


def test_the_first_difference(directory, capsys):
    code, out, _ = run(capsys, "diff", directory / "a.csv", directory / "b.csv")
    first, _, *rows = out.splitlines()
    assert code == 1
    assert first.startswith("first difference at 4.100000000 s: motor.host_says is UCI")
    assert rows[0].startswith("4.100000000  motor.host_says")
    times = [float(row.split()[0]) for row in rows]
    assert times == sorted(times) and not any("if1" in row for row in rows)


def test_differences_as_json(directory, capsys):
    import json

    code, out, _ = run(capsys, "diff", directory / "a.csv", directory / "b.csv", "--json", "--signals", "motor.shaft.*")
    told = json.loads(out)
    assert code == 1 and not told["equal"]
    assert {d["signal"] for d in told["differences"]} == {"motor.shaft.position", "motor.shaft.commanded"}
    first = told["differences"][0]
    assert first["first"] != first["second"]


def test_a_picture_of_the_difference(tmp_path, directory, capsys):
    run(capsys, "diff", directory / "a.csv", directory / "b.csv", "--plot", tmp_path / "a.svg")
    assert {"first difference: motor.host_says", "motor.shaft.position", "first", "second"} <= set(
        texts(tmp_path / "a.svg")
    )


def test_a_signal_of_only_one_trace(tmp_path, directory, capsys):
    bench = Bench()
    bench.add("if1")
    with tracing(bench, tmp_path / "a.csv", ("if1.output1",)):
        bench.run(6.1)
    code, out, _ = run(capsys, "diff", directory / "a.csv", tmp_path / "a.csv", "--signals", "if1.output*")
    assert code == 1 and "if1.output2  0  |  missing" in out


def tracks(*changes: tuple[int, int]) -> Track:
    track = Track("a.b", "integer")
    for time_ns, value in changes:
        track.add(time_ns, str(value))
    return track


@pytest.mark.parametrize(("one", "other", "tolerance", "at_ns"), [
    (((0, 1), (5, 2)), ((0, 1), (5, 2)), Tolerance(), None), (((0, 1), (5, 2)), ((0, 1), (6, 2)), Tolerance(), 5),
    (((0, 1), (5, 2)), ((0, 1), (6, 2)), Tolerance(time_ns=1), None),
    (((0, 1), (5, 2), (20, 3)), ((0, 1), (6, 2), (22, 3)), Tolerance(time_ns=1), 20),
    (((0, 1), (5, 2)), ((0, 1), (5, 4)), Tolerance(value=2), None),
    (((0, 1), (5, 2)), ((0, 1), (5, 5)), Tolerance(value=2), 5),
    (((0, 1), (5, 2)), ((0, 1),), Tolerance(time_ns=10), 5),
    (((0, 1), (50, 2), (51, 1)), ((0, 1),), Tolerance(time_ns=1), 50),
    (((0, 1), (50, 2), (52, 3), (54, 4)), ((0, 1), (53, 2), (55, 3), (57, 4)), Tolerance(time_ns=3), None),
    (((0, 1), (50, 2), (52, 3), (54, 4)), ((0, 1), (53, 2), (55, 3), (57, 4)), Tolerance(time_ns=2), 50),
    (((0, 1), (7, 2), (7, 3)), ((0, 1), (7, 3)), Tolerance(), None)])  # fmt: skip
def test_what_is_a_difference(directory, one, other, tolerance, at_ns):
    first, second = read(directory / "a.csv"), read(directory / "a.csv")
    first.tracks, second.tracks = {"a.b": tracks(*one)}, {"a.b": tracks(*other)}
    found = compare(first, second, tolerance).differences
    assert [difference.time_ns for difference in found] == ([] if at_ns is None else [at_ns])


def test_a_tolerance_in_time(directory, capsys):
    """The IF1 of the second trace receives the command 3 ms earlier, so all its changes are 3 ms earlier."""
    traces = directory / "a.csv", directory / "early.csv"
    first = compare(*map(read, traces)).differences[0]
    assert first.signal == "if1.host_says" and first.time_ns == 4 * S - 3 * MS
    assert run(capsys, "diff", *traces, "--time-tolerance", 0.0031, "--signals", "if1.*")[0] == 0


def test_colours_repeat_after_the_last(tmp_path, directory):
    chart = of_trace(read(directory / "a.csv"), ("if1.X.velocity",))
    all_of_them = len(picture.COLOURS)
    chart.panels = [replace(chart.panels[0], colour=colour) for colour in (0, all_of_them + 1, 10 * all_of_them + 2)]
    picture.save(chart, tmp_path / "a.svg")
    drawn = (tmp_path / "a.svg").read_text()
    assert [colour.lower() in drawn for colour in picture.COLOURS] == [True] * 3 + [False] * (all_of_them - 3)
