"""Write a scene as an FMU for co-simulation by FMI 3.0, with pythonfmu3."""

import json
import os
import re
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from uuid import NAMESPACE_URL, uuid5

from axistwin.core.errors import UsageError, require
from axistwin.core.storage import write_error, write_whole
from axistwin.core.version import VERSION
from axistwin.real.integrations.fmu.variables import inputs
from axistwin.scenes.scene import Scene
from axistwin.scenes.toml_text import tables

SUFFIX = ".fmu"
FOLDER, SCENE, SETTINGS = "scene", "scene.toml", "axistwin.json"  # Of the scene, and the settings.
NOT_IN_AN_FMU = ("ports", "rs485_ports", "state")  # Hosts outside, and memory beyond the simulation.
NAMES_IN_USE = ("Machine", "Fmi3Slave", "error", "message")
SCRIPT = '''"""FMU of a scene, made by axistwin {version}."""

from pythonfmu3 import Fmi3Slave

try:
    from axistwin.real.integrations.fmu.slave import Machine
except ImportError as error:
    message = f"this FMU needs axistwin {version} in the Python of the simulation tool ({{error}})"

    class Machine:  # pythonfmu3 reports errors of the constructor only; an error here would end the process
        def __init__(self, **_):
            raise ImportError(message)


class {name}(Machine, Fmi3Slave):
    pass
'''


def export(scene: Scene | str | Path, out: str | Path, commands: Mapping[str, str] | None = None) -> Path:
    """Write a scene as an FMU to the file `out`, and return the path of the file.

    `commands`: lines of a conversation by name, which become inputs: `{"start": r"> X3000@5000S1$\\r"}`.
    Raises AxistwinError; nothing is written then.
    """
    require("pythonfmu3", "fmu")
    out, commands = Path(out), dict(commands or {})
    name = _model_name(out)
    scene = _alone(scene if isinstance(scene, Scene) else Scene.load(scene))
    texts = _files(scene)
    # Check the commands before the file is written; an invalid command raises UsageError.
    inputs(scene.build(), commands)
    settings = _settings(scene, texts, commands)
    try:
        with TemporaryDirectory() as folder:
            _build(Path(folder), name, texts, settings, out)
    except OSError as error:
        raise write_error(f"{out} cannot be written", error) from None
    return out


def _build(root: Path, name: str, texts: Mapping[str, str], settings: Mapping[str, Any], out: Path) -> None:
    from pythonfmu3 import FmuBuilder

    for file, text in texts.items():
        path = root / FOLDER / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="")
    (root / SETTINGS).write_text(json.dumps(settings, indent=2, ensure_ascii=False), encoding="utf-8")
    # Each FMU needs a unique module name, because Python imports only one module of each name.
    script = root / f"fmu_{name}_{settings['token'].replace('-', '')}.py"
    script.write_text(SCRIPT.format(version=VERSION, name=name), encoding="utf-8")
    made = FmuBuilder.build_FMU(
        script, root / "made", [root / FOLDER, root / SETTINGS], canHandleVariableCommunicationStepSize=True
    )
    write_whole(out, Path(made).read_bytes())


def _model_name(out: Path) -> str:
    if out.suffix != SUFFIX:
        raise UsageError(f"invalid file name {out.name!r}: expected a name that ends in {SUFFIX}")
    if not re.fullmatch(r"[A-Za-z_]\w*", out.stem, re.ASCII) or out.stem in NAMES_IN_USE:
        raise UsageError(f"invalid file name {out.name!r}: expected letters, digits and _, e.g. machine{SUFFIX}")
    return out.stem


def _alone(scene: Scene) -> Scene:
    def without(value: Any) -> Any:
        if not isinstance(value, list):
            return value
        return [{key: each for key, each in table.items() if key not in NOT_IN_AN_FMU} for table in value]

    return scene.varied({key: without(value) for key, value in scene.data.items()})


def _files(scene: Scene) -> dict[str, str]:
    scene.build()  # reads the programs
    texts = scene.programs
    beside = scene.file.parent
    for _, file in scene.named_programs():
        relative = os.path.relpath(file, beside)
        if relative not in texts:
            raise UsageError(f"{file} cannot be part of the FMU: expected a file in the folder of the scene")
    return {**texts, SCENE: tables(scene.data)}


def _settings(scene: Scene, texts: Mapping[str, str], commands: Mapping[str, str]) -> dict[str, Any]:
    devices = [(Path(path).name, text) for path, text in scene.device_files.items()]
    contents = json.dumps([VERSION, sorted(texts.items()), list(commands.items()), *devices])
    token = uuid5(NAMESPACE_URL, sha256(contents.encode()).hexdigest())
    description = " ".join(scene.title.split()) or f"Scene {scene.file.name}"
    return {
        "version": VERSION,
        "commands": dict(commands),
        "description": description,
        "token": str(token),
        "devices": devices,
    }
