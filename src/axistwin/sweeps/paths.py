"""Paths: names for the values of a scene that a sweep can vary.

table.X.load.torque      an option of an axis; table.X.limits.1 is the second element of a list
table.wiring             an option of a controller
knife.program.KP         the number first assigned to KP in the stored program
knife.KP                 a variable or gain at power-up, before the program begins
fault.cable.at           a time, seed or parameter of a fault, by its name
script.0.at              the time of an entry of the script, by its index
wire.1.delay_ms          a property of a wire, by its index
seed                     the seed of the scene
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from axistwin.bench import Bench, Controller
from axistwin.bench.faults.injector import free_name
from axistwin.bench.faults.kinds import kind_of
from axistwin.core.errors import SceneError, UsageError, instead
from axistwin.plant.axes import SERVO, STEPPER
from axistwin.plant.servo_axis import ServoAxis
from axistwin.scenes.scene import Scene
from axistwin.sweeps.values import Value

Keys = tuple[str | int, ...]
TERMS = ("at", "nth", "duration", "seed")  # Properties of every fault that a sweep can vary.
WIRE = ("delay_ms", "invert")
OWN = ("line", "history", "master_ratio")
"""Keys of a controller that a sweep can vary, in addition to the options of its model."""
LISTS = {"fault": "fault.NAME.parameter", "script": "script.0.at", "wire": "wire.0.delay_ms"}
_CODE = r"""(?:"[^"]*"|[^'"])*?"""


@dataclass(frozen=True)
class Place:
    """Location of a setting that a sweep varies: a key in the scene file, or a variable in a program file."""

    path: str
    keys: Keys
    file: str = ""
    variable: str = ""


class Variation:
    """A scene, i.e. a simulated machine, and the settings that change from run to run."""

    def __init__(self, base: Scene, paths: Iterable[str]) -> None:
        self.base = base.varied(_without_state(base.data))
        bench = self.base.build()
        self.places = [_place(self.base, bench, path) for path in paths]
        self._texts = {place.file: self.base.text_of(place.file) for place in self.places if place.file}

    def scene(self, values: Sequence[Value]) -> Scene:
        """Return the scene with new values of the settings.  Raises UsageError for an invalid value."""
        data: Any = self.base.data
        texts = dict(self._texts)
        for place, value in zip(self.places, values, strict=True):
            if place.file:
                texts[place.file] = _assigned(texts[place.file], place, value)
            else:
                data = _put(data, place.keys, value)
        return self.base.varied(data, texts)

    def check(self, number: int, value: Value) -> None:
        """Raise UsageError if `value` is invalid for the setting with the index `number`.

        The scene is built with this value; the other settings keep their values.
        """
        place = self.places[number]
        alone = Variation.__new__(Variation)
        alone.base, alone.places, alone._texts = self.base, [place], self._texts
        try:
            alone.scene([value]).build()
        except (SceneError, UsageError) as error:
            scene_error = error.message if isinstance(error, SceneError) else str(error)
            raise UsageError(f"cannot set {place.path} to {value}: {scene_error}") from None


def states(scene: Scene) -> list[str]:
    """Return the names of the controllers with a state directory; a sweep does not use these directories."""
    return [_called(table) for table in scene.data["controller"] if table.get("state") is not None]


def _without_state(data: Mapping[str, Any]) -> Mapping[str, Any]:
    tables = [{key: value for key, value in table.items() if key != "state"} for table in data["controller"]]
    return {**data, "controller": tables}


def _called(table: Mapping[str, Any]) -> str:
    return str(table.get("name") or table["model"].lower())


def _place(scene: Scene, bench: Bench, path: str) -> Place:
    first, *rest = path.split(".")
    if path == "seed":
        return Place(path, ("seed",))
    if first in LISTS and first not in bench.controllers:
        return Place(path, _in_list(scene, path, first, rest))
    if first not in bench.controllers and len(bench.controllers) == 1:
        first, rest = next(iter(bench.controllers)), [first, *rest]
    if first not in bench.controllers or not rest:
        known_names = (*bench.controllers, "fault", "script", "wire", "seed")
        raise UsageError(
            f"the setting {path} is not in the scene: {instead(first, known_names)} "
            "(a setting is e.g. table.X.load.torque)"
        )
    return _in_controller(scene, bench[first], path, rest)


def _in_list(scene: Scene, path: str, kind: str, rest: Sequence[str]) -> Keys:
    tables = scene.data.get(kind, [])
    if len(rest) < 2:
        raise UsageError(f"the setting {path} is incomplete: expected e.g. {LISTS[kind]}")
    if kind == "fault":
        names: list[str] = []
        for table in tables:
            names.append(table.get("name") or free_name(table["kind"], names))
        if rest[0] not in names:
            raise UsageError(f"unknown fault {rest[0]!r} in the path {path}: {_suggestion(rest[0], names)}")
        number = names.index(rest[0])
        known = [*TERMS, *(each.name for each in kind_of(tables[number]["kind"]).parameters)]
    else:
        if not rest[0].isdecimal() or int(rest[0]) >= len(tables):
            raise UsageError(
                f"invalid index in {path}: expected an index below {len(tables)}, the number of [[{kind}]] tables"
            )
        number, known = int(rest[0]), ["at"] if kind == "script" else list(WIRE)
    if rest[1] not in known or len(rest) > 2:
        raise UsageError(f"a sweep cannot vary the setting {path}: {_suggestion(rest[1], known)}")
    return (kind, number, rest[1])


def _suggestion(word: str, known: Sequence[str]) -> str:
    return instead(word, known) if known else "the scene has no faults"


def _in_controller(scene: Scene, controller: Controller, path: str, rest: list[str]) -> Place:
    number = next(n for n, table in enumerate(scene.data["controller"]) if _called(table) == controller.name)
    at: Keys = ("controller", number)
    options = [each.name for each in fields(controller.product.options)]
    if rest[0] == "program" and len(rest) == 2:
        return _in_program(scene, path, at, rest[1])
    if rest[0] in controller.axes and len(rest) > 1:
        known = SERVO if isinstance(controller.axes[rest[0]], ServoAxis) else STEPPER
        if rest[1] in known:
            return Place(path, _checked(scene, path, (*at, "axes", rest[0], *map(_key, rest[1:]))))
        if not (controller.has_variables and len(rest) == 2):
            raise UsageError(f"the axis has no option {rest[1]!r} (in {path}): {instead(rest[1], known)}")
        rest = rest[1:]
    elif rest[0] in controller.axes:
        example = "load.inertia_kg_m2" if isinstance(controller.axes[rest[0]], ServoAxis) else "load.torque"
        raise UsageError(f"the setting {path} is incomplete: expected an option of the axis, e.g. {path}.{example}")
    if rest[0] in OWN:
        return Place(path, _checked(scene, path, (*at, *map(_key, rest))))
    if rest[0] in options:
        return Place(path, _checked(scene, path, (*at, "options", *map(_key, rest))))
    if controller.has_variables and len(rest) == 1 and _assignable(controller, rest[0]):
        return Place(path, (*at, "variables", rest[0]))
    known_names = (controller.name, *controller.axes, *options, *OWN)
    known_names += ("program",) if controller.has_variables else ()
    raise UsageError(f"the setting {path} is not in the scene: {instead(rest[0], known_names)}")


def _assignable(controller: Controller, name: str) -> bool:
    try:
        controller.assign(name, 1)
    except UsageError:
        return False
    return True


def _key(part: str) -> str | int:
    return int(part) if part.isdecimal() else part


def _checked(scene: Scene, path: str, keys: Keys) -> Keys:
    at: Any = scene.data
    for key in keys:
        if isinstance(key, int) and not (isinstance(at, list) and key < len(at)):
            if not isinstance(at, list):
                raise UsageError(
                    f"invalid index {key} in {path}: the setting is not a list in this scene; leave out the index"
                )
            raise UsageError(f"invalid index in {path}: expected an index below {len(at)}, the length of the list")
        if isinstance(at, list):
            at = at[key] if isinstance(key, int) else None
        else:
            at = at.get(key) if isinstance(at, Mapping) else None
    return keys


def _put(node: Any, keys: Keys, value: Value) -> Any:
    """Return a copy of the table `node` in which `keys` lead to the new value; missing tables are added."""
    if not keys:
        return value
    key, rest = keys[0], keys[1:]
    if isinstance(node, list):
        assert isinstance(key, int), "lists have numbers as keys"
        return [*node[:key], _put(node[key], rest, value), *node[key + 1 :]]
    # In a scene, the model name "frame23" is short for the TOML table { model = "frame23" }.
    table = {"model": node} if isinstance(node, str) else node or {}
    return {**table, key: _put(table.get(key), rest, value)}


# Functions that find and set a variable in the text of a SmartMotor program


def _in_program(scene: Scene, path: str, at: Keys, variable: str) -> Place:
    table = scene.data["controller"][at[1]]
    if "program" not in table:
        raise UsageError(
            f'{path}: the controller {_called(table)} has no program: add e.g. program = "move.sms" to the scene'
        )
    users = [_called(other) for other in scene.data["controller"] if other.get("program") == table["program"]]
    if len(users) > 1:
        controllers, program = " and ".join(users), table["program"]
        raise UsageError(
            f"a sweep cannot vary {path}: the controllers {controllers} share the program file {program}; "
            "give each controller its own program file"
        )
    file = str(scene.file.parent / Path(table["program"]))
    place = Place(path, (*at, "program"), file, variable)
    _assigned(scene.text_of(file), place, 0)
    return place


def _assigned(text: str, place: Place, value: Value) -> str:
    """Set a variable in a program's text: only the number of its first assignment is replaced."""
    if type(value) is not int:
        raise UsageError(f"cannot set {place.path} to {value}: expected a whole number, e.g. {place.variable}=100")
    number = re.compile(rf"(?<![\w@.]){re.escape(place.variable)}=[ ]*(-?\d+)(?![\w.])", re.ASCII)
    lines = text.split("\n")
    for n, line in enumerate(lines):
        code = re.match(_CODE + r"(?='|$)", line)
        found = number.search(line, 0, code.end() if code else len(line))
        if found:
            lines[n] = f"{line[: found.start(1)]}{value}{line[found.end(1) :]}"
            return "\n".join(lines)
    raise UsageError(
        f"cannot vary {place.path}, because no command of the program {Path(place.file).name} sets {place.variable} "
        f"to a whole number: expected a command, e.g. {place.variable}=100"
    )
