"""Journals of a stand-in that were cut or damaged: which positions does the next start believe?

    python benchmarks/robustness/journals.py [--seed 1] [--mutations 20000] [--disks 300]

Journals of two runs with two axes are cut at every byte, and mutated: bytes that are changed, removed, repeated,
inserted or swapped, and lines that are removed or repeated.  The positions must be those of the end of the last run,
or unknown.  Then the disk is full from a random byte of a run on, for the rest of the run or for a while: the run must
go on, and the end must say whether the positions are written.  Prints the errors and a verdict; the exit code is 1 if
there are errors.
"""

import argparse
import errno
import random
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin.real.standin.journal import Journal, last_positions

AXES = ("table.X", "table.Y")


def write(path: Path, rng: random.Random, runs: int = 2) -> dict[str, int]:
    """Write a journal of several runs; return the last positions."""
    positions = {}
    for _ in range(runs):
        journal = Journal(path, ", ".join(AXES))
        for _ in range(3):
            journal.note(f"pulses table.X +1 {rng.randrange(2**32)} {rng.randrange(9999)} 2 0")
            journal.note(f"position table.Y {rng.randrange(-99999, 99999)}")
        positions = {axis: rng.randrange(10_000, 99_999) * rng.choice((-1, 1)) for axis in AXES}
        journal.end(positions)
        journal.close()
    return positions


def cuts(whole: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield the journal cut at every byte."""
    for size in range(len(whole)):
        yield f"cut at byte {size} of {len(whole)}", whole[:size]


def mutations(whole: bytes, rng: random.Random, count: int) -> Iterator[tuple[str, bytes]]:
    """Yield damaged journals; half of the damages are in the last line."""
    last = whole[:-1].rindex(b"\n") + 1
    for number in range(count):
        found = bytearray(whole)
        for _ in range(rng.choice((1, 1, 1, 2, 5))):
            at = rng.randrange(last if rng.random() < 0.5 else 0, len(whole))
            kind = rng.randrange(8)
            if kind < 2:
                found[at : at + 1] = bytes((rng.choice((rng.randrange(256), 0x30 + rng.randrange(10))),))
            elif kind == 2:
                del found[at : at + rng.randrange(1, 9)]
            elif kind == 3:
                found[at:at] = found[at : at + rng.randrange(1, 9)]
            elif kind == 4:
                found[at:at] = rng.randbytes(rng.randrange(1, 4))
            elif kind == 5:
                found[at : at + 2] = found[at : at + 2][::-1]
            else:
                lines = bytes(found).splitlines(keepends=True)
                which = rng.randrange(len(lines))
                lines[which : which + 1] = [lines[which]] * (0 if kind == 6 else 2)
                found = bytearray(b"".join(lines))
        yield f"mutation {number}", bytes(found)


class Disk:
    """A file on a disk that is full between two bytes, counted over all attempts to write."""

    def __init__(self, file: object, full_from: int, full_to: int) -> None:
        self._file, self._from, self._to, self._seen = file, full_from, full_to, 0

    def __getattr__(self, name: str) -> object:
        return getattr(self._file, name)

    def write(self, data: bytes) -> int:
        """Write the bytes that the disk takes, like a system call; raise OSError if it takes none."""
        room = self._from - self._seen if self._seen < self._to else len(data)
        self._seen += max(len(data[:room]) if room > 0 else 0, 1)
        if room <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return self._file.write(data[:room])  # type: ignore[attr-defined, no-any-return]


def full_disk(path: Path, rng: random.Random) -> list[str]:
    """Run on a disk that becomes full; return the errors."""
    told: list[str] = []
    journal = Journal(path, ", ".join(AXES), told.append)
    full_from = rng.randrange(600)
    journal._file = Disk(journal._file, full_from, full_from + rng.choice((1, 3, 10_000)))  # type: ignore[assignment]
    for number in range(10):
        journal.note(f"pulses table.X +1 {rng.randrange(2**32)} {number} 2 0")
    positions = {axis: rng.randrange(10_000, 99_999) for axis in AXES}
    written = journal.end(positions)
    journal.close()
    known = last_positions(path, AXES)
    wrong = [] if known == (positions if written else None) else [f"disk {full_from}: {known} after {written}"]
    return wrong + [f"told {told}" for _ in told[1:]]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mutations", type=int, default=20_000)
    parser.add_argument("--disks", type=int, default=300)
    given = parser.parse_args(arguments)
    rng = random.Random(given.seed)
    wrong, count = [], 0
    with TemporaryDirectory() as folder:
        path = Path(folder) / "table.journal"
        truth = write(path, rng)
        whole = path.read_bytes()
        if last_positions(path, AXES) != truth:
            wrong.append("the whole journal is not believed")
        damaged = [*cuts(whole), *mutations(whole, rng, given.mutations)]
        for what, contents in damaged:
            path.write_bytes(contents)
            found = last_positions(path, AXES)
            count += found is None
            if found not in (None, truth):
                wrong.append(f"{what}: {found} instead of {truth}")
        for number in range(given.disks):
            wrong += full_disk(Path(folder) / f"{number}.journal", rng)
    print("\n".join(wrong[:50]), end="\n" if wrong else "")
    print(
        f"{'FAILED' if wrong else 'passed'}: seed {given.seed}: {len(wrong)} wrong; {len(whole)} cuts, "
        f"{given.mutations} mutations ({count} of both unknown, the others true), {given.disks} full disks"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
