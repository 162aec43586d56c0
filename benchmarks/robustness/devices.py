"""`device_checks` with many seeds, for our models and the example devices: failures, with the seeds that repeat them.

    python benchmarks/robustness/devices.py [--seeds 20] [--first 1] [MODEL ...]

Exit code 0: all checks pass with all seeds.
"""

import argparse
import sys
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin.controllers.registry import OURS
from axistwin.devices import load
from axistwin.testing import device_checks

FILES = Path(__file__).resolve().parents[2] / "examples" / "devices"
EXAMPLES = ("esp300", "mdrive", "tmcl")
SEEDS = 20


def failures(model: str, seeds: range) -> list[str]:
    """Return the first line of each failure of a model, with its seed."""
    found = []
    for seed in seeds:
        for each in device_checks(model, seed=seed):
            (check,) = each.values
            try:
                check()
            except Exception as error:  # noqa: BLE001  # that is what is looked for
                found.append(f"{model} {each.id} seed {seed}: {type(error).__name__}: {str(error).splitlines()[0]}")
            except BaseException as skipped:  # pytest's Skipped is no Exception
                if type(skipped).__name__ != "Skipped":
                    raise
    return found


def main() -> int:
    """Print failures and the verdict."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", default=[*OURS, *EXAMPLES])
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument("--first", type=int, default=1)
    given = parser.parse_args()
    for name in EXAMPLES:
        load(FILES / f"{name}.py")
    bad = []
    for model in given.models:
        began = process_time()
        found = failures(model, range(given.first, given.first + given.seeds))
        bad += found
        print(f"{model:10} {given.seeds} seeds, {process_time() - began:.0f} s of computing, {len(found)} failures")
        for line in found:
            print(f"  {line}")
    print("verdict:", "BAD" if bad else "good")
    return 1 if bad else 0


if __name__ == "__main__":
    raise SystemExit(main())
