"""Mutation score of the command tables and handlers.

python benchmarks/robustness/mutation.py [FAMILY ...]

From each family a seeded sample of changes is taken, one at a time, and the family's tests that run the changed line
are run until one fails.  A change that no test notices is a survivor.  The kernels of the SmartMotor run in plain
Python, so that no compiled copy of an unchanged kernel hides a change.  Exit code 1: a score is below the goal.
"""

import argparse
import json
import os
import sys
import tempfile
from datetime import date
from pathlib import Path
from typing import Any

os.environ["AXISTWIN_JIT"] = "off"
HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT / "src")]

from mutants.campaign import Target, preload, run  # noqa: E402

RESULT, EQUIVALENT = HERE / "mutation.json", HERE / "equivalent.txt"
GOAL, SIZE, SEED = 85.0, 400, 20
CONTROLLERS = ROOT / "src" / "axistwin" / "controllers"
CHECKER = ("checker", "rules")
"""Modules of the checker, which contain no device behaviour and no table."""


def _target(family: str, left_out: tuple[str, ...], tests: tuple[str, ...], skipped: tuple[str, ...] = ()) -> Target:
    package = f"axistwin.controllers.{family}"
    return Target(
        family, package, CONTROLLERS / family, ROOT, (f"tests/{family}", *tests), (*CHECKER, *left_out), skipped
    )


TARGETS = {
    target.name: target
    for target in (
        _target("compumotor", ("front", "listing", "host"), ()),
        _target("digiplan", ("front", "listing"), ("tests/conversations/test_golden.py",)),
        _target(
            "smartmotor",
            ("front", "listing", "vocabulary", "class5", "jit", "log", "registers", "core"),
            ("tests/conversations/test_golden.py", "tests/bench/test_bench_motors.py"),
            ("tests/smartmotor/test_jit.py", "tests/smartmotor/test_overheat.py::test_a_winding_warms_slowly"),
        ),
    )
}  # fmt: skip


def main() -> int:
    """Run the campaign, print the scores, and write the result."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("families", nargs="*", default=[], metavar="FAMILY", help=f"of {', '.join(TARGETS)}; all")
    parser.add_argument("--size", type=int, default=SIZE, help=f"mutants of each family, {SIZE}")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULT, help="file with the result; families not run are kept")
    asked = parser.parse_args()
    preload()
    families = asked.families or list(TARGETS)
    result: dict[str, Any] = json.loads(asked.out.read_text(encoding="utf-8")) if asked.out.exists() else {}
    for family in families:
        with tempfile.TemporaryDirectory() as scratch:
            scores = run(
                TARGETS[family], asked.size, asked.seed, asked.workers, set(equivalents()), Path(scratch), _tell
            )
        result[family] = {"seed": asked.seed, "date": date.today().isoformat(), **scores}  # noqa: DTZ011
        asked.out.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    for family in families:
        print(f"{family}: {result[family]['score']} % of {result[family]['mutants']}, {result[family]['minutes']} min")
    return 0 if all(result[family]["score"] >= GOAL for family in families) else 1


def equivalents() -> dict[str, str]:
    """Return the mutants that have no visible effect, each with its reason, from lines `KEY # REASON`."""
    if not EQUIVALENT.exists():
        return {}
    lines = EQUIVALENT.read_text(encoding="utf-8").splitlines()
    return dict(line.split(" # ", 1) for line in lines if " # " in line and not line.startswith("#"))


def _tell(words: str) -> None:
    print(words, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
