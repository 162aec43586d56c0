"""The fidelity report: every row has its evidence, no row is lost, and the page contains all rows."""

import json
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def report():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "tools"))
        import report

        yield report


@pytest.fixture(scope="module")
def found(report):
    return report.rows()


def test_no_row_is_lost(found):
    kept = (ROOT / "docs" / "report_rows.txt").read_text(encoding="utf-8").splitlines()
    assert kept and sorted(set(kept) - {row.key for row in found}) == []


def test_each_row_has_a_class_of_evidence_and_a_manual(report, found):
    from fidelity.evidence import Evidence

    assert {row.kind for row in found} == set(report.KINDS)
    assert all(isinstance(row.evidence, Evidence) and row.family in report.MANUALS for row in found)
    assert [row.key for row in found if row.kind in ("decision", "timing") and not row.tests] == []


@pytest.mark.parametrize("kind", ["timing", "not modelled", "decision"])
def test_no_line_of_a_document_is_passed_over(found, kind):
    """A line of a table with a cell too many or too few would otherwise give no row."""
    file = {"timing": "timing.md", "not modelled": "not_modelled.md", "decision": "fidelity.md"}[kind]
    lines = (ROOT / "docs" / file).read_text(encoding="utf-8").splitlines()
    heads = [n for n, line in enumerate(lines) if line.startswith("| ---")]
    written = sum(line.startswith("| ") for line in lines) - 2 * len(heads)
    assert len([row for row in found if row.kind == kind]) == written


def test_the_tests_that_rows_name_exist(found):
    for row in found:
        for test in row.tests:
            file, name = test.split("[")[0].split("::")
            assert f"def {name}(" in (ROOT / "tests" / file).read_text(encoding="utf-8"), row.key


@pytest.mark.parametrize(("words", "kind"), [
    ("silent; UARTs signal it with the stop bit", "inferred"), ("Speed: \"above the maximum\"", "manual text"),
    ("appendix 3, sample 10 sends one", "manual example"), ("base 9: four bits", "real host software"),
    ("inferred: 9.4 says nothing", "inferred"), ("one ramp generator", "inferred")])  # fmt: skip
def test_the_class_of_an_entry(report, words, kind):
    from fidelity.evidence import classify

    assert classify(words) == kind


def test_a_lost_row_is_an_error_and_a_new_one_is_not(report, tmp_path, capsys):
    file = tmp_path / "rows.txt"
    file.write_text("a\nb\n")
    assert report.compare({"a", "b", "c"}, file) == 0 and report.compare({"a", "c"}, file) == 1
    assert "lost: b" in capsys.readouterr().err
    assert report.compare({"a", "c"}, file, accept=True) == 1 and file.read_text() == "a\nb\nc\n"
    assert report.compare({"a", "c"}, file, accept=True, drop=True) == 0 and file.read_text() == "a\nc\n"


def test_a_cell_may_hold_a_bar(report):
    from fidelity.documents import cells_of

    assert cells_of(r"| a | `b|c` | d \| e | |") == ("a", "`b|c`", r"d \| e", "")


def test_the_report_is_built_with_every_row(report, found, tmp_path):
    """The run: each test has passed, two commands were given, and one example was measured."""
    example = next(row for row in found if row.key.startswith("example/compumotor/"))
    measured = {"section": "G.1", "words": "262,144 <pulses>", "expected": 5, "obtained": 5.1, "within": 0.2}
    outcomes = {test: "passed" for row in found for test in row.tests}
    run = {
        "outcomes": outcomes,
        "examples": {example.tests[0]: [measured]},
        "asked": {
            "digiplan/X": ["digiplan/test_index.py::test_a"],
            "compumotor/40h": ["compumotor/test_moves.py::test_b"],
        },
    }
    assert report.write(found, run, tmp_path, report.Hardware()) == 0
    result = json.loads((tmp_path / "fidelity.json").read_text(encoding="utf-8"))
    assert [row["key"] for row in result["rows"]] == [row.key for row in found] and result["seen on real hardware"] == 0
    tested = [row["key"] for row in result["rows"] if row["kind"] == "command" and row["more"]["tested"]]
    assert tested == ["command/compumotor/40h", "command/digiplan/X"]
    index = next(c for c in result["chapters"] if c["chapter"] == "Index mode instructions")
    assert index["listed"] == index["implemented"] > index["tested"] == 1
    assert not any(isinstance(count, bool) for chapter in result["chapters"] for count in chapter.values())
    page = (tmp_path / "fidelity.html").read_text(encoding="utf-8")
    assert "262,144 &lt;pulses&gt;" in page and "<td>5.1</td>" in page
    assert all(f'id="{kind.replace(" ", "-")}"' in page for kind in report.KINDS)


def test_a_test_that_fails_makes_the_report_fail(report, found, tmp_path, capsys):
    timing = [row for row in found if row.kind == "timing"]
    outcomes = {test: "passed" for row in timing for test in row.tests} | {timing[0].tests[0]: "failed"}
    assert report.write(timing, {"outcomes": outcomes, "examples": {}, "asked": {}}, tmp_path, report.Hardware()) == 1
    assert f"not passed: {timing[0].key}" in capsys.readouterr().err


def test_the_words_of_a_run(report, tmp_path):
    """The collector receives outcomes, printed numbers, and the commands that a test gives."""
    result = report.runs.run(["tests/digiplan/test_printed_numbers.py::test_backlash_of_20_steps"], tmp_path)
    name = "digiplan/test_printed_numbers.py::test_backlash_of_20_steps"
    assert result["outcomes"] == {name: "passed"}
    assert [(row["expected"], row["obtained"]) for row in result["examples"][name]] == [([120, -20], [120, -20])]
    assert name in result["asked"]["digiplan/B"]


def test_reports_of_probes_fill_the_column_of_real_hardware(report, found, tmp_path):
    probe = {
        "model": "1811",
        "seen_on_real_hardware": {"Requests": 2},
        "results": [
            {"name": "8Ch moving", "section": "Requests", "verdict": "same"},
            {"name": "8Ch moving, followed by 00", "section": "Requests", "verdict": "same"},
            {"name": "94h triggers", "section": "Requests", "verdict": "differs"},
        ],
    }
    (tmp_path / "board.json").write_text(json.dumps(probe))
    rows = [row for row in found if row.kind == "command" and row.family == "compumotor" and row.chapter == "Requests"]
    run = {"outcomes": {}, "examples": {}, "asked": {}}
    assert report.write(rows, run, tmp_path / "out", report.seen(tmp_path)) == 0
    result = json.loads((tmp_path / "out/fidelity.json").read_text())
    assert [chapter["seen on real hardware"] for chapter in result["chapters"]] == [2]
    counts = {row["more"]["code"]: row["more"]["seen on real hardware"] for row in result["rows"]}
    assert (counts["8Ch"], counts["94h"], result["reports of probes"]) == (2, 0, 1)
    assert "2 cases were the same on real hardware" in (tmp_path / "out/fidelity.html").read_text()


def test_a_file_that_is_no_report_of_a_probe(report, tmp_path):
    (tmp_path / "x.json").write_text("[]")
    with pytest.raises(SystemExit, match=r"x\.json is no report of a probe"):
        report.seen(tmp_path)
