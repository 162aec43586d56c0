"""Rows of the report that need no test run: from tables, documents and the texts of tests."""

import ast
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from axistwin.bench import product
from axistwin.bench.talk.conversation import load
from axistwin.controllers.commandset import Command
from fidelity.documents import table_lines
from fidelity.evidence import Evidence, classify

ROOT = Path(__file__).resolve().parents[2]
DOCS, TESTS = ROOT / "docs", ROOT / "tests"
FAMILIES = {"compumotor": ("1811", "1810"), "digiplan": ("if2", "if1"), "smartmotor": ("smartmotor",)}
"""Models of each family, first the model with more commands."""
MANUALS = {
    "compumotor": "Compumotor Model 1810/1811 operator's manual, release 4.0, 1984",
    "digiplan": "Digiplan user information, IF1 & IF2, 1987",
    "smartmotor": "Animatics SmartMotor firmware 4.76, 2003, and what is known of the base language",
    "machine": "All families, and the machine around the controllers",
}
OF_DOCUMENT = {
    "Digiplan": "digiplan",
    "Compumotor": "compumotor",
    "Animatics": "smartmotor",
    "The machine": "machine",
    "All families": "machine",
}
TEST = re.compile(r"`?([\w/]+\.py::\w+)`?")


@dataclass(frozen=True)
class Row:
    """One row.  `key` is unique and permanent; `tests`: node ids below `tests/`; `more`: further cells of the row."""

    key: str
    kind: str
    family: str
    chapter: str
    what: str
    evidence: Evidence
    tests: tuple[str, ...] = ()
    more: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return the row as a dict for JSON."""
        return asdict(self)


def rows() -> list[Row]:
    """Return all rows; each key is unique."""
    found = [*commands(), *decisions(), *timing(), *not_modelled(), *conversations(), *printed(), *sentences()]
    keys = [row.key for row in found]
    twice = sorted({key for key in keys if keys.count(key) > 1}) if len(set(keys)) < len(keys) else []
    assert not twice, f"rows with the same key: {twice}"
    return found


def commands() -> Iterator[Row]:
    """Yield each command of each family, with the models that have it."""
    for family, models in FAMILIES.items():
        tables = {model: product(model).commands for model in models}
        for command in tables[models[0]]:
            having = [model for model in sorted(models) if tables[model].get(command.code) is not None]
            yield Row(
                f"command/{family}/{code(command)}", "command", family, command.chapter, command.name,
                _command_evidence(family, command),
                more={"code": code(command), "models": having, "implemented": command.implemented},
            )  # fmt: skip


def code(command: Command) -> str:
    """Return the code of a command as the manual prints it: in hex, or as characters, control codes in words."""
    given = command.code
    if isinstance(given, int):
        return f"{given:02X}h"
    return {"\n": "<LF>", "\r": "<CR>", " ": "<SP>"}.get(given, given)


def _command_evidence(family: str, command: Command) -> Evidence:
    """Return the evidence for a command: chapters without a number are known from host programs only."""
    return Evidence.HOST if family == "smartmotor" and not command.chapter[0].isdigit() else Evidence.TEXT


def decisions() -> Iterator[Row]:
    """Yield each entry of the fidelity log."""
    for line in table_lines(DOCS / "fidelity.md", 4):
        question, evidence, decision, test = line.cells
        family = next(name for words, name in OF_DOCUMENT.items() if line.headings[0].startswith(words))
        options = re.findall(r"[Oo]ptions? ((?:`\w+`(?:, | and )?)+)", decision)
        yield Row(
            f"decision/{family}/{plain(question)}", "decision", family, line.headings[-1], question, classify(evidence),
            tuple(TEST.findall(test)),
            {"evidence": evidence, "decision": decision, "option": ", ".join(re.findall(r"`(\w+)", " ".join(options)))},
        )  # fmt: skip


def timing() -> Iterator[Row]:
    """Yield each timing figure, with the claimed tolerance."""
    for line in table_lines(DOCS / "timing.md", 6):
        figure, says, claimed, evidence, option, test = line.cells
        family = next(name for words, name in OF_DOCUMENT.items() if line.headings[0].startswith(words))
        more = {"manual": says, "claimed": claimed, "option": option}
        yield Row(
            f"timing/{family}/{plain(figure)}", "timing", family, line.headings[0], figure, Evidence(evidence),
            tuple(TEST.findall(test)), more,
        )  # fmt: skip


def not_modelled() -> Iterator[Row]:
    """Yield each property of the devices that axistwin does not model."""
    for line in table_lines(DOCS / "not_modelled.md", 4):
        what, manual, instead, evidence = line.cells
        family = next(name for words, name in OF_DOCUMENT.items() if line.headings[0].startswith(words))
        yield Row(
            f"not modelled/{family}/{plain(what)}", "not modelled", family, line.headings[0], what, Evidence(evidence),
            more={"manual": manual, "instead": instead},
        )  # fmt: skip


def conversations() -> Iterator[Row]:
    """Yield each golden conversation: the replies and positions of the manual's examples."""
    for path in sorted((TESTS / "conversations").glob("*.talk")):
        text = path.read_text(encoding="utf-8")
        quoted = re.findall(r'^; .*?"([^"]+)"', text, re.MULTILINE)
        model = load(path).headers["model"]
        family = next((name for name, models in FAMILIES.items() if model in models), "smartmotor")
        expected = [line for line in text.splitlines() if line.startswith(("< ", "= "))]
        yield Row(
            f"example/{family}/{path.name}", "example", family, "; ".join(dict.fromkeys(quoted)) or path.stem,
            path.stem, Evidence.EXAMPLE, (f"conversations/test_golden.py::test_conversation[{path.stem}]",),
            {"expected": "; ".join(expected), "acts": len(expected)},
        )  # fmt: skip


def printed() -> Iterator[Row]:
    """Yield each test that compares a number of the manual with the obtained number (fixture `printed`)."""
    for family, name, node in _tests():
        if any(argument.arg == "printed" for argument in node.args.args):
            words = " ".join((ast.get_docstring(node) or node.name).split())
            yield Row(
                f"example/{family}/{name}", "example", family, words.split(":")[0], words, Evidence.EXAMPLE, (name,)
            )


def sentences() -> Iterator[Row]:
    """Yield each sentence of a manual that a test quotes with its section in a docstring or a table of scripts."""
    for family, name, node in _tests():
        if any(argument.arg == "printed" for argument in node.args.args):
            continue
        for key, text in [(name, ast.get_docstring(node) or ""), *((f"{name}[{text}]", text) for text in _keys(node))]:
            words = " ".join(text.split())
            if '"' in words and ":" in words:
                evidence = Evidence.EXAMPLE if re.search(r"\bexample", words) else Evidence.TEXT
                yield Row(f"sentence/{family}/{key}", "sentence", family, words.split(":")[0], words, evidence, (name,))


def _keys(node: ast.FunctionDef) -> Iterator[str]:
    """Yield the keys of the table that `@scripts({...})` gives to a test."""
    for decorator in node.decorator_list:
        if isinstance(decorator, ast.Call) and ast.unparse(decorator.func) == "scripts":
            table = decorator.args[0]
            assert isinstance(table, ast.Dict)
            yield from (ast.literal_eval(key) for key in table.keys if key)


def _tests() -> Iterator[tuple[str, str, ast.FunctionDef]]:
    for family in FAMILIES:
        for path in sorted((TESTS / family).glob("test_*.py")):
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                    yield family, f"{family}/{path.name}::{node.name}", node


def plain(words: str) -> str:
    """Return a key from a text: in one line, without emphasis marks."""
    return " ".join(words.replace("`", "").replace("*", "").split())
