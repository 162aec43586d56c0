"""A scene to be kept elsewhere, with what hosts and people have done since: its text, and the files that it needs.

The text stays as it is, with its comments; of its controllers the keys `host`, `program` and `state` may have to be
others, and the script becomes longer.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from axistwin.bench import Bench
from axistwin.bench.action_runner import LOAD
from axistwin.scenes import toml_places
from axistwin.scenes.hosting import TALK, program_text
from axistwin.scenes.source import Source
from axistwin.scenes.tables import SceneFile, shared_lines
from axistwin.scenes.toml_text import table_text, tables, toml_value
from axistwin.storage import FileStore

_LOAD = re.compile(rf"(\s*{LOAD}\s+)(.*\S)\s*")
_LOAD_LINE = re.compile(rf"^([ \t]*(?:[\w.-]+:[ \t]+)?![ \t]*{LOAD}[ \t]+)([^;\n]*[^;\s])", re.MULTILINE)
"""What loads a program, up to its name, and the name: in a script, in a conversation."""

Where = tuple[str, int]
"""A table of a scene: ("controller", 0)."""


class Files:
    """Texts by name, in one directory."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}

    def add(self, name: str, text: str) -> str:
        """Put a text there; returns the name it has got, another one if there is another text of that name."""
        path = Path(name)
        stem = path.with_suffix("")
        names = (name if n == 1 else f"{stem}-{n}{path.suffix}" for n in range(1, len(self.texts) + 2))
        free = next(each for each in names if self.texts.get(each, text) == text)
        self.texts[free] = text
        return free


class Copy:
    """A scene in the making, of a bench as it was found, in `files`."""

    def __init__(self, bench: Bench, files: Files) -> None:
        self.bench, self.files = bench, files
        self.script: list[dict[str, Any]] = []
        self.read: dict[str, str] = {}
        """Programs as they were when the bench was built, by where they were found."""
        self._hosts: dict[str, list[str]] = {}

    def add_host(self, name: str, file: str, text: str) -> None:
        """Whoever has this name is talked to like this, too."""
        self._hosts.setdefault(name, []).append(self.files.add(file, text))

    # Of a scene

    def of_scene(self, contents: SceneFile, source: Source, served: bool, note: str) -> str:
        """Its text.  `note`: a line about what has been added."""
        changes = dict(self._changes(contents, source, served))
        text = _edited(source.text, changes)
        added = "".join(f"\n{table_text('script', entry)}" for entry in self.script)
        if text is not None and ("script" not in source.data or ("script", 0) in toml_places.spans(source.text)):
            return f"{text.rstrip()}\n\n# {note}\n{added}"
        return f"# {note}\n\n{tables(self._rewritten(source.data, changes))}"

    def _rewritten(self, data: dict[str, Any], changes: Mapping[Where, Mapping[str, Any]]) -> dict[str, Any]:
        """It is written in another manner: what it says is written anew."""
        data = {key: list(value) if isinstance(value, list) else value for key, value in data.items()}
        for (kind, number), values in changes.items():
            data[kind][number] = {**data[kind][number], **values}
        script = [*data.get("script", ()), *self.script]
        return {**data, "script": script} if script else data

    def _changes(self, contents: SceneFile, source: Source, served: bool) -> Iterator[tuple[Where, dict[str, Any]]]:
        """What is to be in each table."""
        for number, table in enumerate(contents.controller):
            own = [] if served and table.ports else table.host
            wanted = {"host": [self._copied(source, file) for file in own] + self._hosts.get(table.called, [])}
            found: dict[str, Any] = {"host": [str(file) for file in table.host]}
            if table.program is not None:
                wanted["program"] = [self._copied(source, table.program)]
                found["program"] = [str(table.program)]
            if table.state is not None:
                wanted["state"] = [self._kept(table.called, table.state)]
                found["state"] = [str(table.state)]
            changed = {key: value for key, value in wanted.items() if value != found[key]}
            yield ("controller", number), {key: _one_or_more(value, key) for key, value in changed.items()}
        for number, entry_ in enumerate(contents.script):
            acts = [self._local_act(source, act) for act in entry_.do]
            if acts != list(entry_.do):
                yield ("script", number), {"do": acts if len(acts) > 1 else acts[0]}
        for _, name, line, path in shared_lines(contents):
            own = [] if served and line.ports else line.host
            hosts = [self._copied(source, file) for file in own] + self._hosts.get(name, [])
            if hosts != [str(file) for file in line.host]:
                yield (str(path[0]), int(path[1])), {"host": hosts}

    def _copied(self, source: Source, file: Path) -> str:
        """A program beside the copy, under its own name if it can be."""
        path = source.file.parent / file
        text = self.read.get(str(path))
        text = program_text(path) if text is None else text
        name = _local(file)
        if path.suffix.lower() == TALK:
            moved = _LOAD_LINE.sub(lambda line: line[1] + self._loaded(source, line[2]), text)
            if moved != text and self.files.texts.get(name) == text:
                del self.files.texts[name]  # as it was
            text = moved
        return self.files.add(name, text)

    def _local_act(self, source: Source, act: str) -> str:
        """An act of the script: what it loads from elsewhere, it loads from beside the copy."""
        found = _LOAD.fullmatch(act)
        return act if found is None else found[1] + self._loaded(source, found[2])

    def _loaded(self, source: Source, file: str) -> str:
        """The name of a program in the copy."""
        return file if _local(Path(file)) == str(Path(file)) else self._copied(source, Path(file))

    def _kept(self, name: str, directory: Path) -> str:
        """What a controller had kept before, so that it is found again."""
        store = self.bench[name].store
        local = _local(directory)
        if isinstance(store, FileStore) and store.found is not None:
            self.files.texts[str(Path(local) / f"{name}.json")] = store.found.decode()
        return local

    # Of a bench that has been made otherwise

    def of_bench(self, note: str) -> str:
        """A scene with the same on it."""
        data: dict[str, Any] = {"controller": [self._controller(name) for name in self.bench.controllers]}
        script = {"script": self.script} if self.script else {}
        return f"# {note}\n\n{tables({**data, **script})}"

    def _controller(self, name: str) -> dict[str, Any]:
        controller = self.bench[name]
        made = controller.product
        given = dict(controller.given)
        line, axes = given.pop("line", None), {axis: given.pop(axis) for axis in made.axes if axis in given}
        state = self._kept(name, Path("state")) if isinstance(controller.store, FileStore) else None
        hosts = self._hosts.get(name) or None
        found = {"model": made.model, "name": name, "line": None if line is None else str(line), "state": state}
        return {**found, "host": hosts, "options": given or None, "axes": axes or None}


def _one_or_more(value: list[str], key: str) -> Any:
    return value if key == "host" else value[0]


def _local(path: Path) -> str:
    """A path that does not lead out of the directory."""
    return path.name if path.is_absolute() or ".." in path.parts else str(path)


def _edited(text: str, changes: Mapping[Where, Mapping[str, Any]]) -> str | None:
    """The text with other values; None: there is no place for them, as it is written in another manner."""
    spans, edits = toml_places.spans(text), []
    for where, values in changes.items():
        for key, value in values.items():
            if (*where, key) in spans:
                edits.append((*spans[*where, key], toml_value(value)))
            elif where in spans:
                end = text.find("\n", spans[where][1])
                at = len(text) if end < 0 else end
                edits.append((at, at, f"\n{key} = {toml_value(value)}"))
            else:
                return None
    for begin, end, written in sorted(edits, reverse=True):
        text = text[:begin] + written + text[end:]
    return text


def entry(at_s: float, on: str, do: Sequence[str]) -> dict[str, Any]:
    """One of the script."""
    return {"at": at_s, **({"on": on} if on else {}), "do": list(do) if len(do) > 1 else do[0]}
