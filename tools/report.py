"""The fidelity report.

python tools/report.py [--out DIRECTORY] [--hardware DIRECTORY] | --check | --accept [--drop]

Without an option the tests of the families are run, and `fidelity.html` and `fidelity.json` are written.  `--check`
compares the names of all rows with `docs/report_rows.txt`, without running a test: exit code 1 if a row is missing.
`--accept` adds the names of new rows to that file; with `--drop` it also removes the names of missing rows.
The column "seen on real hardware" counts cases of the JSON reports of `axistwin probe` in `docs/hardware`.
"""

import argparse
import json
import sys
import tempfile
from collections import Counter, defaultdict
from datetime import date
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "src")]

from axistwin import __version__  # noqa: E402
from fidelity import runs  # noqa: E402
from fidelity.hardware import Hardware, seen  # noqa: E402
from fidelity.page import folded, page, table  # noqa: E402
from fidelity.rows import FAMILIES, MANUALS, Row, rows  # noqa: E402

KEYS = ROOT / "docs" / "report_rows.txt"
MUTATION = ROOT / "benchmarks" / "robustness" / "mutation.json"
HARDWARE = ROOT / "docs" / "hardware"
SEEN = "seen on real hardware"
KINDS = {
    "command": "Commands, chapter by chapter",
    "example": "Examples of the manuals",
    "sentence": "Sentences of the manuals that a test quotes",
    "decision": "Contradictions and silences",
    "timing": "Timing figures",
    "not modelled": "What is not modelled",
}


def main() -> int:
    """Run the function of the options."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "report", help="directory for the two files")
    parser.add_argument("--check", action="store_true", help="is a row lost?")
    parser.add_argument("--accept", action="store_true", help="keep the names of new rows")
    parser.add_argument("--drop", action="store_true", help="with --accept: forget the names of lost rows")
    parser.add_argument("--hardware", type=Path, default=HARDWARE, help="directory of reports of axistwin probe, JSON")
    asked = parser.parse_args()
    found = rows()
    if asked.check or asked.accept:
        return compare({row.key for row in found}, KEYS, accept=asked.accept, drop=asked.drop)
    hardware = seen(asked.hardware)
    with tempfile.TemporaryDirectory() as scratch:
        run = runs.run(tests_of(found), Path(scratch))
    return write(found, run, asked.out, hardware)


def compare(keys: set[str], file: Path, *, accept: bool = False, drop: bool = False) -> int:
    """Compare the names of rows with those in the file; return 1 if a row is missing."""
    kept = set(file.read_text(encoding="utf-8").splitlines()) if file.exists() else set()
    lost, new = sorted(kept - keys), sorted(keys - kept)
    for key in lost:
        print(f"{'dropped' if drop else 'lost'}: {key}", file=sys.stderr)
    if accept:
        wanted = keys if drop else keys | kept
        file.write_text("".join(f"{key}\n" for key in sorted(wanted)), encoding="utf-8")
        print(f"{file.name}: {len(wanted)} rows, {len(new)} of them new")
    elif new:
        print(f"fidelity report: {len(new)} new rows: `make report-rows` keeps their names")
    if lost and not drop:
        print(f"fidelity report: {len(lost)} rows are lost: restore them, or python tools/report.py --accept --drop")
        return 1
    return 0


def tests_of(found: list[Row]) -> list[str]:
    """Return the folders and tests of the rows, as arguments for pytest."""
    folders = {f"tests/{family}" for family in FAMILIES} | {"tests/conversations/test_golden.py"}
    named = {f"tests/{test}" for row in found for test in row.tests}
    return sorted(folders | {name for name in named if not name.startswith(tuple(folders))})


def write(found: list[Row], run: dict[str, Any], out: Path, hardware: Hardware) -> int:
    """Write the page and the JSON; return 1 if a test of a row has not passed."""
    lines = [filled(row, run, hardware) for row in found]
    mutation = json.loads(MUTATION.read_text(encoding="utf-8")) if MUTATION.exists() else {}
    result = {
        "version": __version__, "date": date.today().isoformat(), SEEN: sum(hardware.sections.values()),  # noqa: DTZ011
        "reports of probes": hardware.reports, "chapters": chapters(lines, hardware), "rows": lines,
        "mutation": mutation,
    }  # fmt: skip
    out.mkdir(parents=True, exist_ok=True)
    (out / "fidelity.json").write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    (out / "fidelity.html").write_text(html(result), encoding="utf-8")
    bad = [line["key"] for line in lines if line["outcome"] not in ("passed", "")]
    print(f"{out / 'fidelity.html'}: {len(lines)} rows, {len(bad)} whose tests did not pass")
    for key in bad:
        print(f"not passed: {key}", file=sys.stderr)
    return 1 if bad else 0


def filled(row: Row, run: dict[str, Any], hardware: Hardware) -> dict[str, Any]:
    """Return a row with the results of the run: outcome, tests of a command, obtained value."""
    line = row.as_dict()
    if row.kind == "command":
        line["tests"] = run["asked"].get(f"{row.family}/{row.more['code']}", [])
        line["more"]["tested"] = bool(line["tests"])
        line["more"][SEEN] = hardware.commands[row.family, str(row.more["code"])]
    outcomes = {run["outcomes"].get(test, "not run") for test in row.tests}
    line["outcome"] = next((worst for worst in ("failed", "not run", "skipped", "passed") if worst in outcomes), "")
    if row.kind == "example" and "expected" in row.more:
        line["more"]["obtained"] = "the same, byte for byte" if line["outcome"] == "passed" else line["outcome"]
    elif row.kind == "example":
        line["more"]["numbers"] = run["examples"].get(row.tests[0], [])
    return line


def chapters(lines: list[dict[str, Any]], hardware: Hardware) -> list[dict[str, Any]]:
    """Count the commands of each chapter: listed, implemented, tested; and cases seen on real hardware."""
    counted: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for line in lines:
        if line["kind"] == "command":
            count = counted[line["family"], line["chapter"]]
            more = line["more"]
            count.update(listed=1, implemented=int(more["implemented"]), tested=int(more["tested"]))
    return [
        {"family": family, "chapter": chapter, **count, SEEN: hardware.sections[family, chapter]}
        for (family, chapter), count in counted.items()
    ]


def html(result: dict[str, Any]) -> str:
    """Return the page."""
    sections = [("summary", "Summary", _summary(result))]
    for kind, title in KINDS.items():
        lines = [line for line in result["rows"] if line["kind"] == kind]
        parts = [
            f"<h3>{MANUALS[family]}</h3>" + CONTENT[kind](result, [line for line in lines if line["family"] == family])
            for family in MANUALS
            if any(line["family"] == family for line in lines)
        ]
        sections.append((kind.replace(" ", "-"), title, "".join(parts)))
    sections.append(("mutation", "Mutation score", _mutation(result["mutation"])))
    words = (
        f"axistwin {result['version']}, {result['date']}. Each row names its evidence: manual text, manual example, "
        f"real host software, or inferred. <b>{_hardware(result)}</b>"
    )
    return page("Fidelity report", sections, words)


def _hardware(result: dict[str, Any]) -> str:
    if not result["reports of probes"]:
        return "Nothing here has been seen on real hardware yet: that column is 0 everywhere."
    return f"{result[SEEN]} cases were the same on real hardware, in {result['reports of probes']} reports of probes."


def _summary(result: dict[str, Any]) -> str:
    classes = sorted({str(line["evidence"]) for line in result["rows"]})
    counts = Counter((line["kind"], str(line["evidence"])) for line in result["rows"])
    lines = [[title, *(counts[kind, name] for name in classes)] for kind, title in KINDS.items()]
    return table(["rows", *classes], lines)


def _commands(result: dict[str, Any], lines: list[dict[str, Any]]) -> str:
    family = lines[0]["family"]
    head = ["chapter", "listed", "implemented", "tested", SEEN]
    whole = table(head, ([c[name] for name in head] for c in result["chapters"] if c["family"] == family))
    each = table(
        ["code", "command", "chapter", "models", "implemented", "tests", "on hardware", "evidence"],
        (
            [f"`{line['more']['code']}`", line["what"], line["chapter"], ", ".join(line["more"]["models"]),
             line["more"]["implemented"], len(line["tests"]), line["more"][SEEN], line["evidence"]]
            for line in lines
        ),
    )  # fmt: skip
    return whole + folded(f"The {len(lines)} commands", each)


def _examples(_: dict[str, Any], lines: list[dict[str, Any]]) -> str:
    numbers = [
        [n["section"], n["words"], str(n["expected"]), str(n["obtained"]), n["within"] or "exactly",
         f"`{line['tests'][0]}`", line["evidence"]]
        for line in lines
        for n in line["more"].get("numbers", ())
    ]  # fmt: skip
    talks = [
        [line["chapter"], line["more"]["acts"], f"`{line['more']['expected']}`", line["more"]["obtained"],
         f"`{line['tests'][0]}`", line["evidence"]]
        for line in lines
        if "expected" in line["more"]
    ]  # fmt: skip
    parts = (
        table(["section", "example", "expected", "obtained", "within", "test", "evidence"], numbers) if numbers else ""
    )
    head = ["section", "answers and places", "expected", "obtained", "test", "evidence"]
    return parts + (folded(f"{len(talks)} conversations", table(head, talks)) if talks else "")


def _sentences(_: dict[str, Any], lines: list[dict[str, Any]]) -> str:
    body = ([line["what"], f"`{line['tests'][0]}`", line["outcome"], line["evidence"]] for line in lines)
    return folded(f"{len(lines)} tests", table(["section and words", "test", "outcome", "evidence"], body))


def _decisions(_: dict[str, Any], lines: list[dict[str, Any]]) -> str:
    head = ["chapter", "question", "the manual", "decision", "option", "test", "outcome", "evidence"]
    return table(head, (
        [line["chapter"], line["what"], line["more"]["evidence"], line["more"]["decision"], line["more"]["option"],
         ", ".join(f"`{test}`" for test in line["tests"]), line["outcome"], line["evidence"]]
        for line in lines
    ))  # fmt: skip


def _timing(_: dict[str, Any], lines: list[dict[str, Any]]) -> str:
    head = ["figure", "the manual", "claimed", "option", "test", "outcome", "evidence"]
    return table(head, (
        [line["what"], line["more"]["manual"], line["more"]["claimed"], line["more"]["option"],
         ", ".join(f"`{test}`" for test in line["tests"]), line["outcome"], line["evidence"]]
        for line in lines
    ))  # fmt: skip


def _not_modelled(_: dict[str, Any], lines: list[dict[str, Any]]) -> str:
    body = ([line["what"], line["more"]["manual"], line["more"]["instead"], line["evidence"]] for line in lines)
    return table(["what", "where it would show", "what happens instead", "evidence"], body)


CONTENT = {
    "command": _commands, "example": _examples, "sentence": _sentences, "decision": _decisions, "timing": _timing,
    "not modelled": _not_modelled,
}  # fmt: skip


def _mutation(scores: dict[str, Any]) -> str:
    if not scores:
        return "<p>Not measured yet: <code>python benchmarks/robustness/mutation.py</code></p>"
    head = ["family", "mutants", "of", "killed", "timeout", "survived", "equivalent", "score", "seed", "date"]
    whole = table(head, ([family, *(score[name] for name in head[1:])] for family, score in scores.items()))
    named = (
        folded(
            f"{family}: {len(score['survivors'])} survivors",
            table(["survivor"], ([f"`{s}`"] for s in score["survivors"])),
        )
        for family, score in scores.items()
    )
    return (
        "<p>A small change is made to a command table or a handler; the score is the share that the tests notice.</p>"
        + (whole + "".join(named))
    )


if __name__ == "__main__":
    sys.exit(main())
