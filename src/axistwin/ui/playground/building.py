"""Write the playground's folder: the page, Pyodide's engine, axistwin's wheel and the libraries it imports."""

import io
import json
import subprocess
import sys
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from hashlib import sha256
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from shutil import copyfile

from axistwin.core.errors import UsageError
from axistwin.core.version import VERSION
from axistwin.ui import conversation
from axistwin.ui.drawings.of_axes import asset

PAGE = Path(__file__).parent / "page"
ENGINE = ("pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json")
"""Files of the npm package `pyodide` that the page loads."""
ENGINE_LICENCE = "README.md"
CORE = "pydantic_core-*wasm32.whl"  # Wheel of pydantic-core for Pyodide, from the Python Package Index.
LIBRARIES = ("simpy", "pydantic", "typing_extensions", "annotated_types", "typing_inspection", "filelock")
"""Pure Python distributions that axistwin imports in the browser; NumPy is not among them."""
LIBRARIES_ZIP, COMPILED, COMPILED_CORE = "libraries.zip", "compiled.zip", "core.zip"
SNAPSHOT, PREPARED = "snapshot.gz", "prepared"
"""Files that `prepare` writes; the last has a digest of what it has compiled."""
ASSETS = dict.fromkeys(("drawings.css", "parts.js"), asset) | dict.fromkeys(("log.css", "log.js"), conversation.asset)
_DATED = (2020, 1, 1, 0, 0, 0)  # Date of all files in the archives, so that equal contents give equal archives.


def build(target: Path, engine: Path) -> Path:
    """Write the playground (a web page that runs axistwin) into the folder `target`.

    Return the path of the web page.  `engine`: a folder with the files of the npm package `pyodide` and the wheel of
    pydantic-core for Pyodide.  If the folder has a wheel of axistwin, this wheel is used.  Raises UsageError if a file
    is missing.
    """
    cores = sorted(engine.glob(CORE))
    if not cores:
        raise UsageError(
            f"no file {CORE} in the folder {engine}: "
            "run `make engine`, which downloads the file into the folder build/engine"
        )
    if missing_file := next((name for name in ENGINE if not (engine / name).is_file()), ""):
        raise UsageError(
            f"no file {missing_file} in the folder {engine}: expected the files that `npm install pyodide` installs"
        )
    wheel = _wheel(engine)
    target.mkdir(parents=True, exist_ok=True)
    for path in (*(engine / name for name in ENGINE), cores[-1], *engine.glob(ENGINE_LICENCE)):
        (target / "engine").mkdir(exist_ok=True)
        copyfile(path, target / "engine" / path.name)
    archives = {wheel[0]: wheel[1], LIBRARIES_ZIP: _archive(_libraries())}
    if (engine / PREPARED).is_file() and (engine / PREPARED).read_text(encoding="utf-8") == _digest(archives):
        archives = {COMPILED: (engine / COMPILED).read_bytes()}
        copyfile(engine / COMPILED_CORE, target / "engine" / cores[-1].name)
    for name, data in archives.items():
        (target / "engine" / name).write_bytes(data)
    snapshot = SNAPSHOT if (engine / SNAPSHOT).is_file() else ""
    if snapshot:
        copyfile(engine / snapshot, target / "engine" / snapshot)
    for path in PAGE.iterdir():
        if path.is_file():
            copyfile(path, target / path.name)
    for name, read in ASSETS.items():
        (target / name).write_text(read(name), encoding="utf-8")
    contents = {"version": VERSION, "archives": list(archives), "core": cores[-1].name, "snapshot": snapshot}
    (target / "contents.json").write_text(json.dumps(contents), encoding="utf-8")
    return target / "index.html"


def prepare(engine: Path) -> None:
    """Compile axistwin's wheel and its libraries, and take a snapshot of Python, so that the page begins sooner.

    Needs node.  `build` uses what this writes into the folder `engine` while it belongs to the wheel.
    """
    name, wheel = _wheel(engine)
    libraries = _archive(_libraries())
    (engine / LIBRARIES_ZIP).write_bytes(libraries)
    script, core = Path(__file__).parent / "prepare.mjs", max(engine.glob(CORE)).name
    subprocess.run(["node", str(script), str(engine), name, core], check=True)
    (engine / PREPARED).write_text(_digest({name: wheel, LIBRARIES_ZIP: libraries}), encoding="utf-8")


def _digest(archives: Mapping[str, bytes]) -> str:
    return sha256(b"".join(sha256(archives[name]).digest() for name in sorted(archives))).hexdigest()


def _wheel(engine: Path) -> tuple[str, bytes]:
    wheel = f"axistwin-{VERSION}-py3-none-any.whl"
    if (engine / wheel).is_file():
        return wheel, (engine / wheel).read_bytes()
    try:
        installed = list(_installed(distribution("axistwin")))
    except PackageNotFoundError:
        installed = []
    if not any(path == "axistwin/__init__.py" for path, _ in installed):
        raise UsageError(f"no axistwin package {engine / wheel}: build the package with `make engine`")
    return wheel, _archive(installed)


def _libraries() -> Iterator[tuple[str, bytes]]:
    for package in LIBRARIES:
        try:
            yield from _installed(distribution(package))
        except PackageNotFoundError:
            raise UsageError(f"a Python package is missing: install {package} with `pip install {package}`") from None


def _installed(found: Distribution) -> Iterator[tuple[str, bytes]]:
    for path in found.files or ():
        place = Path(str(path.locate()))
        if ".." not in path.parts and place.suffix not in (".pyc", ".so") and place.is_file():
            yield path.as_posix(), place.read_bytes()


def _archive(files: Iterable[tuple[str, bytes]]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, data in sorted(files):
            archive.writestr(zipfile.ZipInfo(name, _DATED), data, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


if __name__ == "__main__":
    prepare(Path(sys.argv[1]))
