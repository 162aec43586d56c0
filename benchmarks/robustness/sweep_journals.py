"""Damaged results of sweeps and tunings: each damage is one line, or changes nothing; none is another table.

    python benchmarks/robustness/sweep_journals.py [--seed 1] [--damages 1400] [--pairs 10]

The part files of an interrupted sweep, the file of a finished one, and the study of a tuning are cut, and bytes are
changed, removed, repeated and replaced.  The same command must then end with the right table, or with one line; after
the file in this line is deleted, as the line says, the command must end with the right table.  In each of the pairs,
two processes start one sweep at once.  The verdict is the last line; exit code 1 if anything was found.
"""

import argparse
import random
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from shutil import copytree, rmtree
from tempfile import TemporaryDirectory
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin.core.errors import AxistwinError
from axistwin.sweeps import Sweep, Tuning, digest

RUNS, STOP = 6, (2, 4)
"""Number of runs, and the runs after which the sweep is interrupted; each interruption leaves a part file."""
LONGEST_LINE = 400
SCENE = {"controller": [{"model": "if1", "axes": {"X": {"limits": [-100, 100]}}}]}
Again = Callable[[Path], str]
"""Executes the command again in a folder, and returns a text that is equal for equal results."""


class StoppedError(Exception):
    """Interrupts a sweep."""


def sweep(folder: Path, stop: int | None = None) -> str:
    """Run or continue the sweep of a folder."""

    def progress(done: int, *_: object) -> None:
        if done == stop:
            raise StoppedError

    made = Sweep(SCENE).vary("seed", f"0..{RUNS - 1}").vary("if1.X.limits.1", "100..200:2")
    made.measure("end", "final if1.X.position").claim("low", "never if1.X passes 90")
    return digest(made.run(folder / "a.parquet", workers=0, seconds=0.01, progress=progress))


def tune(folder: Path) -> str:
    """Run or continue the tuning of a folder."""
    made = Tuning(SCENE, "final if1.X.position").change("if1.X.limits.1", "100..200")
    return repr(made.run(folder / "a.db", trials=4, workers=0, seconds=0.01).trials)


def changed(data: bytes, chance: random.Random) -> tuple[str, bytes]:
    """Return a damage in words, and the damaged contents of a file."""
    at, length = chance.randrange(len(data)), chance.choice((1, 1, 2, 8, 64, 512))
    end = min(at + length, len(data))
    match chance.randrange(7):
        case 0:
            return f"cut at {at}", data[:at]
        case 1:
            return f"{length} bytes removed at {at}", data[:at] + data[end:]
        case 2:
            return f"{length} bytes replaced at {at}", data[:at] + chance.randbytes(end - at) + data[end:]
        case 3:
            return f"{length} bytes zero at {at}", data[:at] + bytes(end - at) + data[end:]
        case 4:
            return f"{length} bytes repeated at {at}", data[:end] + data[at:]
        case 5:
            bit = 1 << chance.randrange(8)
            return f"bit {bit} at {at}", data[:at] + bytes([data[at] ^ bit]) + data[at + 1 :]
        case _:
            return f"{length} bytes appended", data + chance.randbytes(length)


def damaged(folder: Path, name: str, chance: random.Random) -> str:
    """Damage one file of a folder, and return the damage in words."""
    file = folder / name
    others = sorted(path for path in file.parent.glob(f"*{file.suffix}") if path != file)
    match chance.randrange(20):
        case 0:
            file.unlink()
            return "deleted"
        case 1:
            file.unlink()
            file.mkdir()
            return "a directory"
        case 2 if others:
            file.write_bytes(others[0].read_bytes())
            return f"contents of {others[0].name}"
        case 3:
            (file.parent / f"{file.stem} (copy){file.suffix}").write_bytes(file.read_bytes())
            return "a copy beside it"
    words, data = changed(file.read_bytes(), chance)
    file.write_bytes(data)
    return words


class Campaign:
    """Damages files of a folder, one at a time, and notes what is wrong."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.seed = folder, seed
        self.found: list[str] = []
        self.ends: Counter[str] = Counter()
        for name in ("whole", "parts", "study"):
            (folder / name).mkdir()
        self.right: dict[Again, str] = {sweep: sweep(folder / "whole"), tune: tune(folder / "study")}
        for stop in STOP:
            with suppress(StoppedError):
                sweep(folder / "parts", stop)

    def files(self) -> list[tuple[Path, str, Again]]:
        """Return each file: its folder, its name, and the command that continues."""
        parts = sorted((self.folder / "parts" / "a.parquet.parts").glob("part-*"))
        assert len(parts) == len(STOP)
        listed = [(self.folder / "parts", f"a.parquet.parts/{part.name}", sweep) for part in parts]
        return [*listed, (self.folder / "whole", "a.parquet", sweep), (self.folder / "study", "a.db", tune)]

    def run(self, count: int) -> None:
        """Make `count` damages."""
        files = self.files()
        for number in range(count):
            chance = random.Random(f"{self.seed} {number}")
            source, name, again = files[number % len(files)]
            folder = self.folder / "damaged"
            rmtree(folder, ignore_errors=True)
            copytree(source, folder)
            words = damaged(folder, name, chance)
            if wrong := self._wrong(folder, name, again):
                self.found.append(f"number {number}: {name}, {words}: {wrong}")

    def _wrong(self, folder: Path, name: str, again: Again) -> str:
        """Return what is wrong after a damage; "" if nothing is."""
        kind = f"{(folder / name).suffix} {{}}"
        try:
            made = again(folder)
            self.ends[kind.format("the right results")] += 1
            return "" if made == self.right[again] else "other results"
        except AxistwinError as error:
            line = str(error)
        except Exception as error:  # noqa: BLE001  # whatever it is, it is to be seen
            return f"{type(error).__name__}: {error}"
        if not line.isprintable() or len(line) > LONGEST_LINE:
            return f"no short line: {line!r}"
        self.ends[kind.format("one line")] += 1
        return "" if again is tune else self._remedied(folder, line, again)

    def _remedied(self, folder: Path, line: str, again: Again) -> str:
        """Delete the damaged files, as each line says, and continue; return what is wrong then."""
        for _ in range(3):
            file = next((path for path in folder.rglob("*.parquet") if str(path) in line), None)
            if file is None or "delete" not in line:
                return f"no remedy: {line}"
            if file.is_dir():
                file.rmdir()
            else:
                file.unlink()
            try:
                return "" if again(folder) == self.right[again] else f"other results after the remedy of: {line}"
            except AxistwinError as error:
                line = str(error)
        return f"still refused: {line}"

    def pairs(self, count: int) -> None:
        """Start two processes with one sweep at once, several times."""
        code = f"import sys; sys.path[:0] = {[sys.path[0], str(Path(__file__).parent)]!r}\n"
        code += "from sweep_journals import *\ntry: print(sweep(Path(sys.argv[1])))\n"
        code += "except AxistwinError as error: print('refused', error)"
        for number in range(count):
            folder = self.folder / f"pair{number}"
            folder.mkdir()
            two: list[Any] = [
                subprocess.Popen([sys.executable, "-c", code, folder], stdout=subprocess.PIPE, text=True)
                for _ in range(2)
            ]
            said = [each.communicate(timeout=120)[0].strip() for each in two]
            good = [words == self.right[sweep] for words in said]
            refused = [words.startswith("refused") and " is being written by " in words for words in said]
            self.ends["second process refused"] += sum(refused)
            self.ends["second process reads the results"] += all(good)
            if not any(good) or not all(a or b for a, b in zip(good, refused, strict=True)):
                self.found.append(f"pair {number}: {said}")
            if sorted(path.name for path in folder.iterdir()) != ["a.parquet"]:
                self.found.append(f"pair {number} leaves {[*folder.rglob('*')]}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign, and print the findings and the verdict."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--damages", type=int, default=1400)
    parser.add_argument("--pairs", type=int, default=10)
    given = parser.parse_args(arguments)
    with TemporaryDirectory() as directory:
        campaign = Campaign(Path(directory), given.seed)
        campaign.run(given.damages)
        campaign.pairs(given.pairs)
    for line in campaign.found:
        print(line)
    for end, count in sorted(campaign.ends.items()):
        print(f"{count:6} {end}")
    verdict = "FAILED" if campaign.found else "passed"
    print(f"{verdict}: seed {given.seed}, {given.damages} damages, {given.pairs} pairs: {len(campaign.found)} found")
    return 1 if campaign.found else 0


if __name__ == "__main__":
    sys.exit(main())
