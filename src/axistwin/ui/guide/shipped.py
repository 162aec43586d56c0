"""The files that come with axistwin (examples and pages), from the installed package or from a clone."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from axistwin.core.errors import UsageError
from axistwin.core.storage import write_error

PACKAGE = Path(__file__).parents[2]
CLONE = PACKAGE.parents[1]
LOOSE = ".toml"  # Suffix of a scene in the folder of examples; the files beside this scene belong to it.


def folder(name: str) -> Path:
    """Return the path of the folder `examples` or `docs`.  Raises UsageError if the folder is not installed."""
    for place in (PACKAGE / name, CLONE / name):
        if place.is_dir():
            return place
    raise UsageError(
        f"the folder {name!r} of axistwin is missing: install the wheel of axistwin, or clone the repository"
    )


@dataclass(frozen=True)
class Example:
    """An example that comes with axistwin: its name, its title and its files."""

    name: str
    title: str
    root: Path
    files: tuple[Path, ...]

    @property
    def scene(self) -> str:
        """Name of the scene file of the example, or "" if the example has no scene."""
        return next((str(file.relative_to(self.root)) for file in self.files if file.suffix == LOOSE), "")

    @property
    def command(self) -> str:
        """Command that runs the scene of the example, e.g. `axistwin run`, or "" if the example has no scene."""
        if not self.scene:
            return ""
        text = (self.root / self.scene).read_text(encoding="utf-8")
        return "axistwin stand-in --dry-run" if "[stand-in" in text else "axistwin run"

    def copy(self, target: Path) -> list[Path]:
        """Copy the example, and return the new paths.  Raises UsageError instead of overwriting a file."""
        wanted = {file: target / file.relative_to(self.root) for file in self.files}
        if existing_file := next((path for path in wanted.values() if path.exists()), None):
            raise UsageError(f"{existing_file} exists already: choose another directory")
        try:
            for file, path in wanted.items():
                path.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(file, path)
        except OSError as error:
            raise write_error(f"the example cannot be copied to {target}", error, "choose another directory") from None
        return list(wanted.values())


def examples() -> dict[str, Example]:
    return {example.name: example for example in _examples(folder("examples"))}


def _examples(root: Path) -> Iterator[Example]:
    for place in sorted(path for path in root.iterdir() if path.is_dir() and path.name != "__pycache__"):
        files = tuple(sorted(path for path in place.rglob("*") if path.is_file()))
        page = place / "README.md"
        yield Example(place.name, _title(page) if page.exists() else place.name, place, files)
    loose = tuple(sorted(path for path in root.iterdir() if path.is_file()))
    for scene in loose:
        if scene.suffix == LOOSE:
            yield Example(scene.stem, _title(scene), root, loose)


def _title(path: Path) -> str:
    return path.read_text(encoding="utf-8").partition("\n")[0].strip("# .")
