"""Results of a test run: outcomes, commands used by each test, obtained numbers."""

import json
import os
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
FAMILIES = ("compumotor", "digiplan", "smartmotor")
EVERYTHING = 0.5
"""Share of all commands; a test that uses more commands does not count as a test of each."""


class Collector:
    """A pytest plug-in that writes the results into a file."""

    def __init__(self, file: Path) -> None:
        self._file, self._test = file, ""
        self.outcomes: dict[str, str] = {}
        self.examples: dict[str, list[Any]] = defaultdict(list)
        self.sizes: Counter[str] = Counter()
        self.asked: dict[tuple[str, str], set[str]] = defaultdict(set)

    def pytest_sessionstart(self) -> None:
        """Record each look-up in a command table, and each character from a host to a Digiplan."""
        from axistwin.bench import product
        from axistwin.controllers.commandset import CommandSet
        from axistwin.controllers.smartmotor.language import language
        from axistwin.sim.serial_port import SerialPort
        from fidelity.rows import FAMILIES as MODELS
        from fidelity.rows import code

        known = {id(c): (f, code(c)) for f, models in MODELS.items() for m in models for c in product(m).commands}
        self.sizes = Counter(family for family, _ in set(known.values()))
        characters = {c.code: known[id(c)] for c in product("if2").commands}
        looked_up, sent = CommandSet.get, SerialPort.write

        def get(table: CommandSet, wanted: str | int) -> Any:
            command = looked_up(table, wanted)
            if command is not None and id(command) in known:
                self.asked[known[id(command)]].add(self._test)
            return command

        def write(port: SerialPort, data: bytes) -> None:
            if self._test.startswith("digiplan/"):
                for character in set(data.decode("latin-1")) & set(characters):
                    self.asked[characters[character]].add(self._test)
            sent(port, data)

        CommandSet.get, SerialPort.write = get, write  # type: ignore[method-assign]
        self._forget = (language.command.cache_clear, language.read.cache_clear)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Record the running test, with all its parameters as one test, and clear the commands."""
        self._test = _function(item.nodeid)
        for forget in self._forget:
            forget()
        try:
            return (yield)
        finally:
            self._test = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep the worst outcome of a test function, and its examples."""
        for name in {report.nodeid.removeprefix("tests/"), _function(report.nodeid)}:
            worse = report.outcome != "passed" and self.outcomes.get(name) != "failed"
            if worse or (report.when == "call" and name not in self.outcomes):
                self.outcomes[name] = report.outcome
        if report.when == "call":
            found = [value for name, value in report.user_properties if name == "printed"]
            self.examples[_function(report.nodeid)].extend(found)

    def pytest_sessionfinish(self) -> None:
        """Write all results."""
        asked = {f"{family}/{code}": sorted(tests - {""}) for (family, code), tests in self.asked.items()}
        result = {"outcomes": self.outcomes, "examples": self.examples, "asked": asked, "sizes": self.sizes}
        self._file.write_text(json.dumps(result, default=str), encoding="utf-8")


def _function(nodeid: str) -> str:
    return nodeid.removeprefix("tests/").split("[")[0]


def run(tests: list[str], scratch: Path) -> dict[str, Any]:
    """Run the tests in a separate process, and return outcomes, examples, and tests by command."""
    file = scratch / "collected.json"
    path = os.pathsep.join([str(ROOT / "tools"), str(ROOT / "src")])
    here = [sys.executable, "-c", "from fidelity import runs; runs.main()", str(file), *tests]
    subprocess.run(here, cwd=ROOT, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.DEVNULL, check=False)
    result: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    result["asked"] = _specific(result["asked"], result.pop("sizes"))
    return result


def _specific(asked: dict[str, list[str]], sizes: dict[str, int]) -> dict[str, list[str]]:
    """Omit the tests that use nearly every command of a family."""
    given: dict[tuple[str, str], int] = defaultdict(int)
    for name, tests in asked.items():
        family = name.split("/")[0]
        for test in tests:
            given[family, test] += 1
    return {
        name: [test for test in tests if given[name.split("/")[0], test] <= EVERYTHING * sizes[name.split("/")[0]]]
        for name, tests in asked.items()
    }


def main() -> None:
    """Run pytest with the collector: FILE TEST ..."""
    words = ["-q", "--no-header", "--no-summary", "--tb=no", "-p", "no:cacheprovider", "-n0"]
    sys.exit(pytest.main([*words, *sys.argv[2:]], plugins=[Collector(Path(sys.argv[1]))]))
