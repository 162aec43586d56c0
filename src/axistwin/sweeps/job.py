"""The job of a sweep (scene, varied paths, measures, claims), and the runner that runs its points."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any

from axistwin.bench import Bench
from axistwin.bench.programs import running
from axistwin.bench.programs.command_lines import run_until_quiet
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.units import S, to_ns
from axistwin.core.version import VERSION
from axistwin.scenes.scene import Scene
from axistwin.scenes.toml_text import tables
from axistwin.sweeps import recording
from axistwin.sweeps.paths import Variation
from axistwin.sweeps.sentences import Finding, Sentence, claim, measure
from axistwin.sweeps.values import Value

Row = dict[str, Any]
BOUND_NS = 3600 * S  # Longest virtual time of a run in a sweep without `for`, in seconds.
OWN_COLUMNS = ("run", "ended", "seconds", "difference", "notes", "wall_s", "worker", "version", "scene")
"""Columns of the results other than those of paths, measures and claims."""
APART = ("wall_s", "worker", "version")  # Columns of the results that may differ if the same sweep is run again.


@dataclass(frozen=True)
class Job:
    """Data that each worker process needs to perform the runs of a sweep."""

    scene: Scene
    paths: tuple[str, ...]
    measures: Mapping[str, str] = field(default_factory=dict)
    claims: Mapping[str, str] = field(default_factory=dict)
    for_s: float | None = None
    program: Path | None = None
    host: str | None = None  # A Python host, `module:function`, that is called with the bench of each run.
    devices: Mapping[str, str] = field(default_factory=dict)  # Texts of the Python files with the scene's devices.

    def hash(self) -> str:
        texts = {Path(name).name: text for name, text in self.scene.programs.items()}
        if self.program is not None:
            texts[self.program.name] = self.program.read_text(encoding="latin-1")
        texts |= {Path(name).name: text for name, text in self.devices.items()}
        digest = sha256(self.scene.text.encode())
        for name, text in sorted(texts.items()):
            digest.update(f"\0{name}\0{text}".encode())
        return digest.hexdigest()[:16]


class Runner:
    """Performs the runs of a sweep one by one.  Raises UsageError if the sweep cannot run.

    The module of the user's host is imported at its first use: a check imports no code of the user.
    """

    def __init__(self, job: Job) -> None:
        self.job = job
        if job.devices:
            # Imported here, because only devices of others need it.
            from axistwin.devices.loading import load_texts

            load_texts(job.devices)
        self.variation = Variation(job.scene, job.paths)
        self.measures = {name: _named(name, text, measure) for name, text in job.measures.items()}
        self.claims = {name: _named(name, text, claim) for name, text in job.claims.items()}
        sentences = (*self.measures.values(), *self.claims.values())
        self.signals = tuple(dict.fromkeys(name for sentence in sentences for name in sentence.signals))
        self.events = tuple(dict.fromkeys(event for sentence in sentences for event in sentence.events))
        self._check()
        self._hash = job.hash()

    @cached_property
    def host(self) -> Callable[[Bench], object] | None:
        """The user's host, which is imported now.  Raises UsageError if the function cannot be imported."""
        return _function(self.job.host) if self.job.host else None

    def _check(self) -> None:
        self._program()
        for measure_or_claim, sentence in {**self.measures, **self.claims}.items():
            try:
                recording.check(self.variation.base.build(), sentence.signals, sentence.events, sentence.axes)
            except UsageError as error:
                what_was_expected = str(error).partition("when=")[2] or str(error)
                raise UsageError(f"cannot evaluate {measure_or_claim!r} in this scene: {what_was_expected}") from None

    def _program(self) -> running.Program:
        return running.scene_program() if self.job.program is None else running.load(self.job.program)

    def row(self, number: int, values: Sequence[Value], worker: str = "") -> Row:
        """Perform one run, and return its row of results; of a failed run, with the reason."""
        begin_s = perf_counter()
        row = self.empty_row(number, values, worker)
        try:
            row |= self._run(values)
        except AxistwinError as error:
            row |= {"ended": "error", "notes": str(error)}
        except Exception as error:  # noqa: BLE001  # from the user's host: other runs are not affected
            row |= {"ended": "error", "notes": f"{type(error).__name__}: {error}"}
        row["wall_s"] = perf_counter() - begin_s
        return row

    def empty_row(self, number: int, values: Sequence[Value], worker: str = "") -> Row:
        row: Row = {"run": number, **dict(zip(self.job.paths, values, strict=True))}
        row |= dict.fromkeys(self.measures)
        for name in self.claims:
            row |= {name: None, f"{name}.robustness": None, f"{name}.at_s": None}
        about = {"wall_s": 0.0, "worker": worker, "version": VERSION, "scene": self._hash}
        return {**row, "ended": "", "seconds": None, "difference": None, "notes": None, **about}

    def _run(self, values: Sequence[Value]) -> Row:
        bench = self.variation.scene(values).build()
        program = self._program()
        program.prepare(bench)
        with recording.Recording(bench, self.signals, self.events) as record:
            if self.host is not None:
                self.host(bench)
            difference = program.perform(bench, self._until_ns(bench)).difference if self.job.program else None
            ended = self._finish(bench)
        found: Row = {"ended": ended, "seconds": bench.seconds, "difference": difference and str(difference)}
        notes = []
        for name, sentence in self.measures.items():
            finding = sentence.answer(record)
            found[name] = finding.value
            notes += _note(name, finding)
        for name, sentence in self.claims.items():
            finding = sentence.answer(record)
            at_s = None if finding.at_ns is None else finding.at_ns / S
            found |= {name: finding.holds, f"{name}.robustness": finding.robustness, f"{name}.at_s": at_s}
            notes += _note(name, finding)
        return {**found, "notes": "; ".join(notes) or None}

    def _until_ns(self, bench: Bench) -> int | None:
        return None if self.job.for_s is None else max(to_ns(self.job.for_s), bench.now)

    def _finish(self, bench: Bench) -> str:
        if self.job.for_s is not None:
            bench.clock.run_to(max(to_ns(self.job.for_s), bench.now))
            return "for"
        bench.clock.run_to(max(bench.now, min(bench.agenda_ns, BOUND_NS)))
        rests = run_until_quiet(bench, BOUND_NS)
        if rests and not any(axis.moving for each in bench.controllers.values() for axis in each.axes.values()):
            return "rest"
        bench.clock.run_to(max(bench.now, BOUND_NS))
        return "bound"

    def files(self, row: Row) -> dict[str, str]:
        """Return the texts of the files that repeat a run (a scene and its programs), by file name."""
        scene = self.variation.scene([row[path] for path in self.job.paths])
        scene.build()
        data = {key: _without_ports(value) for key, value in scene.data.items()}
        failed = [name for name in self.claims if row[name] is False]
        end_s = self.job.for_s if self.job.for_s is not None else row["seconds"]
        told = [f"# {name}: {self.claims[name].text}: fails at {row[f'{name}.at_s']:.9f} s\n" for name in failed]
        program = f" {self.job.program}" if self.job.program else ""
        note = f"# Run {row['run']}: axistwin run scene.toml{program} --for {end_s:.9f}\n"
        at_s = min((row[f"{name}.at_s"] for name in failed), default=end_s)
        note += f"# In the panel: axistwin serve scene.toml --panel 8080 --to {at_s:.9f}\n" if not program else ""
        return {**scene.programs, "scene.toml": f"{note}{''.join(told)}\n{tables(data)}"}


def _without_ports(value: Any) -> Any:
    if not isinstance(value, list):
        return value
    return [{key: each for key, each in table.items() if key not in ("ports", "rs485_ports")} for table in value]


def _note(name: str, finding: Finding) -> list[str]:
    return [f"{name}: {finding.reason}"] if finding.reason else []


def _named(measure_or_claim: str, text: str, read: Callable[[str], Sentence]) -> Sentence:
    try:
        return read(text)
    except UsageError as syntax_error:
        raise UsageError(f"cannot evaluate {measure_or_claim!r}: {syntax_error}") from None


def _function(name: str) -> Callable[[Bench], object]:
    module, _, function = name.partition(":")
    try:
        found: Any = getattr(import_module(module), function)
        reason = "not a function"
    except Exception as error:  # noqa: BLE001  # the module is the user's code
        found, reason = None, f"{type(error).__name__}: {error}"
    if not callable(found):
        raise UsageError(
            f"cannot import the Python function {name!r} ({reason}): "
            "expected MODULE:FUNCTION of a module that Python finds by PYTHONPATH, e.g. myhosts:press_button"
        )
    call: Callable[[Bench], object] = found
    return call


def check_names(names: Iterable[str], paths: Iterable[str]) -> None:
    """Raise UsageError if the name of a result column is invalid or is already in use."""
    taken = {*paths, *OWN_COLUMNS}
    for name in names:
        if name in taken:
            raise UsageError(f"a column with the name {name!r} exists already: choose another name")
        if not name.replace("_", "").replace("-", "").isalnum():
            raise UsageError(f"invalid name {name!r}: expected letters, digits, _ and -, e.g. cycle")
        taken |= {name, f"{name}.robustness", f"{name}.at_s"}
