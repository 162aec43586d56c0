"""Copy a scene with its files, and add the recorded actions of hosts and operators.

The copy keeps the comments.  The keys `host`, `program` and `state` of controllers may change, and the script gets more
entries.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from axistwin.bench import Bench
from axistwin.bench.action_runner import LOAD
from axistwin.core.storage import FileStore
from axistwin.scenes import toml_places
from axistwin.scenes.hosting import TALK, program_text
from axistwin.scenes.source import Source
from axistwin.scenes.tables import SceneFile, shared_lines
from axistwin.scenes.toml_text import table_text, tables, toml_value

_LOAD = re.compile(rf"(\s*{LOAD}\s+)(.*\S)\s*")
_LOAD_LINE = re.compile(rf"^([ \t]*(?:[\w.-]+:[ \t]+)?![ \t]*{LOAD}[ \t]+)([^;\n]*[^;\s])", re.MULTILINE)
"""Patterns for an action that loads a program, in a script and in a conversation; the last group is the file."""

Where = tuple[str, int]  # A table of a scene, e.g. ("controller", 0).


class Files:
    """The texts of files in one directory, stored by file name."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}

    def add(self, name: str, text: str) -> str:
        """Add a text and return its file name, which is changed if another text already has this name."""
        path = Path(name)
        stem = path.with_suffix("")
        names = (name if n == 1 else f"{stem}-{n}{path.suffix}" for n in range(1, len(self.texts) + 2))
        free = next(each for each in names if self.texts.get(each, text) == text)
        self.texts[free] = text
        return free


class Copy:
    """Builds a copy of a scene and its files in `files`."""

    def __init__(self, bench: Bench, files: Files) -> None:
        self.bench, self.files = bench, files
        self.script: list[dict[str, Any]] = []
        self.read: dict[str, str] = {}  # Texts of the programs at the time when the bench was built, by path.
        self._hosts: dict[str, list[str]] = {}

    def add_host(self, name: str, file: str, text: str) -> None:
        self._hosts.setdefault(name, []).append(self.files.add(file, text))

    # Functions that copy a scene file and add recorded actions to the copy

    def of_scene(self, contents: SceneFile, source: Source, served: bool, note: str) -> str:
        """Return the text of the copied scene.  `note`: comment line before the added part."""
        changes = dict(self._changes(contents, source, served))
        text = _edited(source.text, changes)
        added = "".join(f"\n{table_text('script', entry)}" for entry in self.script)
        if text is not None and ("script" not in source.data or ("script", 0) in toml_places.spans(source.text)):
            return f"{text.rstrip()}\n\n# {note}\n{added}"
        return f"# {note}\n\n{tables(self._rewritten(source.data, changes))}"

    def _rewritten(self, data: dict[str, Any], changes: Mapping[Where, Mapping[str, Any]]) -> dict[str, Any]:
        data = {key: list(value) if isinstance(value, list) else value for key, value in data.items()}
        for (kind, number), values in changes.items():
            data[kind][number] = {**data[kind][number], **values}
        script = [*data.get("script", ()), *self.script]
        return {**data, "script": script} if script else data

    def _changes(self, contents: SceneFile, source: Source, served: bool) -> Iterator[tuple[Where, dict[str, Any]]]:
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
            yield ("controller", number), {key: value if key == "host" else value[0] for key, value in changed.items()}
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
        path = source.file.parent / file
        text = self.read.get(str(path))
        text = program_text(path) if text is None else text
        name = _local(file)
        if path.suffix.lower() == TALK:
            moved = _LOAD_LINE.sub(lambda line: line[1] + self._loaded(source, line[2]), text)
            if moved != text and self.files.texts.get(name) == text:
                # Delete the original program, so that `add` stores the changed program under the same file name.
                del self.files.texts[name]
            text = moved
        return self.files.add(name, text)

    def _local_act(self, source: Source, act: str) -> str:
        """Return an action of the script for the copied scene; copy the program that the action loads."""
        found = _LOAD.fullmatch(act)
        return act if found is None else found[1] + self._loaded(source, found[2])

    def _loaded(self, source: Source, file: str) -> str:
        return file if _local(Path(file)) == str(Path(file)) else self._copied(source, Path(file))

    def _kept(self, name: str, directory: Path) -> str:
        store = self.bench[name].store
        local = _local(directory)
        if isinstance(store, FileStore) and store.found is not None:
            self.files.texts[str(Path(local) / f"{name}.json")] = store.found.decode()
        return local

    # Functions that convert a bench (simulated controllers) to a scene file

    def of_bench(self, note: str) -> str:
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


def _local(path: Path) -> str:
    return path.name if path.is_absolute() or ".." in path.parts else str(path)


def _edited(text: str, changes: Mapping[Where, Mapping[str, Any]]) -> str | None:
    """Return the text of a scene file with new values; None if its layout prevents this."""
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
    return {"at": at_s, **({"on": on} if on else {}), "do": list(do) if len(do) > 1 else do[0]}
