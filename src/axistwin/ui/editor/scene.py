"""Language support for scenes: tables, keys, models and terminals, from the schema."""

import ast
import inspect
import re
from collections.abc import Iterator
from dataclasses import fields
from functools import cache
from itertools import pairwise
from textwrap import dedent
from typing import Any

from axistwin.bench import product
from axistwin.bench.faults.kinds import KINDS
from axistwin.bench.faults.table import On
from axistwin.bench.models import models
from axistwin.scenes.tables import SERVO_SCHEMA, has_servo, scene_schema
from axistwin.ui.editor.answers import Hover, Item, Symbol
from axistwin.ui.editor.talk import known, terminals

_HEADER = re.compile(r"\s*(?P<brackets>\[\[?)\s*(?P<path>[\w.\"'-]*)")
_REST = re.compile(r"[\w-]*")
_KEY = re.compile(r"""[\w"'.-]+""")
_PAIR = re.compile(r"""\s*(?P<keys>[\w"'.-]*)\s*(?:(?P<equals>=)\s*(?P<value>.*))?""", re.DOTALL)
_MODEL = re.compile(r"""\s*model\s*=\s*["'](?P<model>[\w-]+)["']""")
_NAME = re.compile(r"""\s*name\s*=\s*["'](?P<name>[\w-]+)["']""")
_KIND = re.compile(r"""\s*kind\s*=\s*["']([\w-]+)["']""")
_FILE = re.compile(r"""["']([^"'\n]+\.\w+)["']""")
TERMINAL_KEYS = ("from", "to")


class Scenes:
    """Language support for scenes (`.toml` files)."""

    def hover(self, lines: list[str], line: int, at: int) -> Hover | None:
        word = next((m for m in _KEY.finditer(lines[line - 1]) if m.start() <= at <= m.end()), None)
        header = _HEADER.match(lines[line - 1])
        if word is None:
            return None
        until = next(m.end() for m in _REST.finditer(lines[line - 1], at))
        typed = lines[line - 1][word.start() : until].split(".")
        path = typed if header else [*_table(lines, line), *typed]
        node = _node(path[:-1], _model(lines, line))
        found = node.get(path[-1]) if node else None
        return None if found is None else Hover(f"**{path[-1]}** {_description(found)}", word.start(), until)

    def complete(self, lines: list[str], line: int, at: int) -> list[Item]:
        text = lines[line - 1][:at]
        if "#" in text:
            return []
        if header := _HEADER.match(text):
            return [
                Item(name, "key", _description(node))
                for name, node in _node([], "").items()
                if header["brackets"] == "[["
            ]
        pair = _PAIR.match(text)
        assert pair is not None
        *before, _ = pair["keys"].split(".")
        path = [*_table(lines, line), *before]
        model = _model(lines, line)
        if pair["equals"]:
            key = pair["keys"].split(".")[-1]
            return [
                Item(value, "value")
                for value in _values(lines, line, key, _node(path, model).get(key, {}), pair["value"])
            ]
        return [Item(name, "key", _description(node)) for name, node in _node(path, model).items()]

    def file(self, lines: list[str], line: int, at: int) -> str | None:
        found = next((m for m in _FILE.finditer(lines[line - 1]) if m.start() <= at <= m.end()), None)
        return None if found is None else found[1]

    def symbols(self, lines: list[str]) -> list[Symbol]:
        """Return the tables of the file; a controller's table is listed under its name."""
        headers = [(number, found["path"]) for number, line in enumerate(lines, 1) if (found := _HEADER.match(line))]
        last = len(lines) + 1, ""
        return [_symbol(lines, begin, end, path) for (begin, path), (end, _) in pairwise([*headers, last])]


def _symbol(lines: list[str], begin: int, end: int, path: str) -> Symbol:
    last = (end - 1, len(lines[end - 2]) + 1)
    return Symbol(_title(lines, begin, end, path), "table", (begin, 1), last, path)


def _title(lines: list[str], begin: int, end: int, path: str) -> str:
    body = lines[begin : end - 1]
    named = next((m["name"] for each in body if (m := _NAME.match(each))), None)
    model = next((m["model"] for each in body if (m := _MODEL.match(each))), None)
    return named or model or path


def _table(lines: list[str], line: int) -> list[str]:
    for number in range(line - 1, 0, -1):
        if found := _HEADER.match(lines[number - 1]):
            return [part.strip("\"'") for part in found["path"].split(".")]
    return []


def _model(lines: list[str], line: int) -> str:
    begin = next((n for n in range(line, 0, -1) if re.match(r"\s*\[\[\s*controller\s*\]\]", lines[n - 1])), None)
    if begin is None:
        return ""
    for each in lines[begin:]:
        if each.lstrip().startswith("[["):
            break
        if (found := _MODEL.match(each)) and known(found["model"]):
            return found["model"].lower()
    return ""


def _node(path: list[str], model: str) -> dict[str, dict[str, Any]]:
    schema = scene_schema()
    if path[:2] == ["controller", "options"] and len(path) == 2 and model:
        return _options(model)
    if path == ["controller", "axes"] and model:
        return {axis: {"description": "axis"} for axis in product(model).axes}
    node: dict[str, Any] = schema
    if path[:2] == ["controller", "axes"] and model and has_servo(model):
        node, path = SERVO_SCHEMA, path[3:]
    for part in path:
        node = _child(schema, node, part)
    properties: dict[str, dict[str, Any]] = _resolved(schema, node).get("properties", {})
    return properties


@cache
def _options(model: str) -> dict[str, dict[str, Any]]:
    made = product(model).options
    try:
        source = inspect.getsource(made)
    except (OSError, TypeError):  # The options of a device are a class without a source.
        source = "class Options: ..."
    (body,) = (node.body for node in ast.parse(dedent(source)).body if isinstance(node, ast.ClassDef))
    docs = {
        field.target.id: str(doc.value.value)
        for field, doc in pairwise(body)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        and isinstance(doc, ast.Expr) and isinstance(doc.value, ast.Constant)
    }  # fmt: skip
    return {field.name: {"description": docs.get(field.name, "")} for field in fields(made)}


def _child(schema: dict[str, Any], node: dict[str, Any], part: str) -> dict[str, Any]:
    node = _resolved(schema, node)
    found = node.get("properties", {}).get(part) or node.get("additionalProperties")
    found = _resolved(schema, found) if isinstance(found, dict) else {}
    items = found.get("items")
    return items if isinstance(items, dict) else found


def _resolved(schema: dict[str, Any], node: dict[str, Any]) -> dict[str, Any]:
    """Return the definition that a node refers to; of several alternatives, the first table."""
    if "$ref" in node:
        return dict(schema["$defs"][node["$ref"].rpartition("/")[2]])
    choices = node.get("anyOf") or node.get("oneOf") or []
    tables = [each for each in (_resolved(schema, choice) for choice in choices) if "properties" in each]
    return tables[0] if tables else node


def _description(node: dict[str, Any]) -> str:
    return " ".join(str(node.get("description", "")).split())


def _values(lines: list[str], line: int, key: str, node: dict[str, Any], typed: str) -> Iterator[str]:
    if node.get("type") == "boolean":
        yield from ("true", "false")
        return
    quote = "" if typed.startswith(('"', "'")) else '"'
    yield from (f"{quote}{value}{quote}" for value in _words(lines, line, key, node))


def _words(lines: list[str], line: int, key: str, node: dict[str, Any]) -> Iterator[str]:
    if key == "model" and "enum" not in node:
        yield from models()
    elif key in TERMINAL_KEYS:
        yield from (f"{name}.{pin}" for name, model in _controllers(lines) for pin in terminals(model)["pins"])
    elif key == "master":
        yield from (f"{name}.{axis}" for name, model in _controllers(lines) for axis in product(model).axes)
    elif key == "on" and _table(lines, line) == ["fault"]:
        yield from _spots(lines, line)
    elif key == "on":
        yield from (name for name, _ in _controllers(lines))
    else:
        choices = [node, *node.get("anyOf", ())]
        yield from (value for choice in choices for value in choice.get("enum", ()) if isinstance(value, str))


def _spots(lines: list[str], line: int) -> Iterator[str]:
    kind = KINDS.get(_value_in_table(lines, line, _KIND))
    for name, model in _controllers(lines):
        named = {
            On.CONTROLLER: [name],
            On.LINE: [f"{name}.serial"] if product(model).line is not None else [],
            On.AXIS: [f"{name}.{axis}" for axis in product(model).axes],
            On.PIN: [f"{name}.{pin}" for pin in terminals(model)["pins"]],
        }
        for on, spots in named.items():
            if kind is None or kind.on is on:
                yield from spots


def _value_in_table(lines: list[str], line: int, pattern: re.Pattern[str]) -> str:
    begin = next((n for n in range(line, 0, -1) if lines[n - 1].lstrip().startswith("[")), 0)
    for each in lines[begin:]:
        if each.lstrip().startswith("["):
            break
        if found := pattern.match(each):
            return str(found[1])
    return ""


def _controllers(lines: list[str]) -> Iterator[tuple[str, str]]:
    for number, line in enumerate(lines, start=1):
        if re.match(r"\s*\[\[\s*controller\s*\]\]", line) and (model := _model(lines, number)):
            end = next(
                (n for n in range(number + 1, len(lines) + 1) if lines[n - 1].lstrip().startswith("[[")), len(lines) + 1
            )
            yield _title(lines, number, end, model), model
