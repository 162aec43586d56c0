"""A sample of mutants of one family, each in its own child process, and the results."""

import ast
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from mutants import operators
from mutants.children import Changed, survive
from mutants.operators import Mutant
from mutants.tracing import Traced, trace

LONGEST_S = 600.0
"""Time limit of a child by the wall clock, for a test that blocks."""
KILLED, TIMEOUT, SURVIVED, EQUIVALENT = "killed", "timeout", "survived", "equivalent"


@dataclass(frozen=True)
class Target:
    """Changed modules, and the tests that must detect the changes.

    `package`: name of the package whose modules are changed, in `directory`; `tests`: files and folders below `root`;
    `left_out`: modules without handlers; `skipped`: prefixes of the node ids of unsuitable tests.
    """

    name: str
    package: str
    directory: Path
    root: Path
    tests: tuple[str, ...]
    left_out: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()

    @property
    def sources(self) -> list[Path]:
        """Changed files, in order."""
        return [path for path in sorted(self.directory.rglob("*.py")) if not self._is_left_out(path)]

    def _is_left_out(self, path: Path) -> bool:
        folders = path.relative_to(self.directory).parent.parts
        return bool({path.stem, *folders} & {*self.left_out, "__init__"})

    def name_of(self, path: Path) -> str:
        """Return the name of a file in the results: its path in the package."""
        return path.relative_to(self.directory).as_posix()


@dataclass(frozen=True)
class Outcome:
    """Result of a mutant: `by` is the test that failed first."""

    mutant: Mutant
    state: str
    by: str = ""
    seconds: float = 0.0


Tell = Callable[[str], None]


def run(
    target: Target, size: int, seed: int, workers: int, equivalent: set[str], scratch: Path, tell: Tell
) -> dict[str, Any]:
    """Run a seeded sample, and return the contents of the result file."""
    texts = {path: path.read_text(encoding="utf-8") for path in target.sources}
    found = [mutant for path, text in texts.items() for mutant in operators.mutants(target.name_of(path), text)]
    chosen = operators.sample(found, size, Random(f"{seed} {target.name}"))
    tell(f"{target.name}: {len(chosen)} of {len(found)} mutants")
    started = time.monotonic()
    traced = trace(target.root, target.sources, target.tests, target.skipped, scratch)
    tell(f"{target.name}: {len(traced.seconds)} tests traced in {time.monotonic() - started:.0f} s")
    uses = _uses({target.name_of(path): text for path, text in texts.items()})
    outcomes: dict[Mutant, Outcome] = {}
    waiting: list[tuple[Mutant, list[str]]] = []
    for mutant in chosen:
        tests = _tests(mutant, target, texts, traced, uses)
        if mutant.key in equivalent:
            outcomes[mutant] = Outcome(mutant, EQUIVALENT)
        elif not tests:
            outcomes[mutant] = Outcome(mutant, SURVIVED, "no test runs it")
        else:
            waiting.append((mutant, tests))
    for number, outcome in enumerate(_run_all(target, waiting, traced, workers, scratch), start=1):
        outcomes[outcome.mutant] = outcome
        tell(f"{number}/{len(waiting)} {outcome.seconds:.1f} s {outcome.state} {outcome.mutant.name} [{outcome.by}]")
    return _result([outcomes[mutant] for mutant in chosen], len(found), traced, time.monotonic() - started)


def _result(outcomes: list[Outcome], found: int, traced: Traced, seconds: float) -> dict[str, Any]:
    count = {state: sum(o.state == state for o in outcomes) for state in (KILLED, TIMEOUT, SURVIVED, EQUIVALENT)}
    counted = len(outcomes) - count[EQUIVALENT]
    return {
        "mutants": len(outcomes), "of": found, **count,
        "score": round(100 * (count[KILLED] + count[TIMEOUT]) / max(1, counted), 1),
        "tests": len(traced.seconds), "left out, too slow": traced.slow, "left out, failing": traced.failed,
        "minutes": round(seconds / 60, 1),
        "survivors": [o.mutant.name + (f" ({o.by})" if o.by else "") for o in outcomes if o.state == SURVIVED],
    }  # fmt: skip


def _tests(
    mutant: Mutant, target: Target, texts: dict[Path, str], traced: Traced, uses: dict[str, set[tuple[str, int]]]
) -> list[str]:
    """Return the tests that run the changed statement.

    For a statement that runs at import: first the tests that use its names, then all others.
    """
    path = target.directory / mutant.file
    file, span = str(path.resolve()), _statement(texts[path], mutant.line)
    inside = mutant.function != "module" and _is_in_function(texts[path], mutant)
    if inside and not any(traced.runs_at_import(file, line) for line in span):
        covering = {test for line in span for test in traced.covering(file, line)}
        return sorted(covering, key=traced.seconds.__getitem__)
    named = _names(texts[path].splitlines()[mutant.line - 1])
    lines = {place for name in named for place in uses.get(name, ())}
    first = {t for file, line in lines for t in traced.covering(str((target.directory / file).resolve()), line)}
    return sorted(first, key=traced.seconds.__getitem__) + [name for name in traced.all if name not in first]


def _statement(text: str, line: int) -> range:
    """Return the lines of the statement that contains a line; for a block, the lines of its head."""
    spans = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            last = max(node.lineno, body[0].lineno - 1) if body else node.end_lineno or node.lineno
            if node.lineno <= line <= last:
                spans.append(range(node.lineno, last + 1))
    return min(spans, key=len, default=range(line, line + 1))


def _is_in_function(text: str, mutant: Mutant) -> bool:
    return any(
        isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and mutant.function.endswith(node.name)
        and node.body[0].lineno <= mutant.line <= (node.end_lineno or 0)
        for node in ast.walk(ast.parse(text))
    )


def _names(line: str) -> set[str]:
    words = "".join(c if c.isalnum() or c == "_" else " " for c in line)
    return set(words.split())


def _uses(texts: dict[str, str]) -> dict[str, set[tuple[str, int]]]:
    """Return lines in functions, by the name of the function, and by the constants of a module that they use."""
    found: dict[str, set[tuple[str, int]]] = {}
    for name_of_file, text in texts.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                found.setdefault(node.name, set()).add((name_of_file, node.body[-1].lineno))
                for part in ast.walk(node):
                    name = (
                        part.id if isinstance(part, ast.Name) else part.attr if isinstance(part, ast.Attribute) else ""
                    )
                    if name.isupper():
                        found.setdefault(name, set()).add((name_of_file, part.lineno))
    return found


def _run_all(
    target: Target, waiting: list[tuple[Mutant, list[str]]], traced: Traced, workers: int, scratch: Path
) -> Iterator[Outcome]:
    running: dict[int, tuple[Mutant, Path, float]] = {}
    queue = list(enumerate(waiting))
    while queue or running:
        while queue and len(running) < workers:
            number, (mutant, tests) = queue.pop(0)
            result = scratch / f"result{number}"
            running[_start(target, mutant, {name: traced.seconds[name] for name in tests}, result)] = (
                mutant, result, time.monotonic(),
            )  # fmt: skip
        for child in list(running):
            mutant, result, started = running[child]
            if time.monotonic() - started > LONGEST_S:
                os.kill(child, signal.SIGKILL)
            done, _ = os.waitpid(child, os.WNOHANG)
            if done:
                del running[child]
                yield _outcome(mutant, result, time.monotonic() - started)
        time.sleep(0.01)


def _start(target: Target, mutant: Mutant, seconds: dict[str, float], result: Path) -> int:
    path = target.directory / mutant.file
    child = os.fork()
    if child == 0:
        tree = operators.apply(path.read_text(encoding="utf-8"), mutant)
        module = ".".join((target.package, *path.relative_to(target.directory).with_suffix("").parts))
        survive(Changed(module, path, tree), target.root, seconds, result)
    return child


def _outcome(mutant: Mutant, result: Path, seconds: float) -> Outcome:
    if not result.exists():  # a signal has ended it: its test did not end
        return Outcome(mutant, TIMEOUT, "", seconds)
    by = result.read_text(encoding="utf-8").splitlines()[0]
    return Outcome(mutant, KILLED if by else SURVIVED, by, seconds)


def preload() -> None:
    """Import the unchanged modules once, in the parent process."""
    import numpy  # noqa: F401, ICN001  # lazy import: only to have it before a fork
    import pydantic  # noqa: F401
    import simpy  # noqa: F401

    assert not any(name == "axistwin" or name.startswith("axistwin.") for name in sys.modules), "imported too early"
