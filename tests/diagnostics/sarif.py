"""Check of SARIF 2.1.0: allowed and required properties of the objects that axistwin writes, and their values."""

import re
from collections.abc import Callable, Iterator
from typing import Any

Problem = str
Look = Callable[[Any, str], Iterator[Problem]]

_URI_REFERENCE = re.compile(r"(?:[A-Za-z0-9._~!$&'()*+,;=:@/?#\[\]-]|%[0-9A-Fa-f]{2})+")


def problems(log: object) -> list[Problem]:
    return list(_object("sarifLog")(log, "$"))


def _object(name: str) -> Look:
    def look(value: Any, at: str) -> Iterator[Problem]:
        required, known = OBJECTS[name]
        if not isinstance(value, dict):
            yield f"{at}: no {name}"
            return
        yield from (f"{at}: {name} has no {key}" for key in required if key not in value)
        for key, inner in value.items():
            if key in known:
                yield from known[key](inner, f"{at}.{key}")
            else:
                yield f"{at}: {name} knows no {key}"

    return look


def _list(of: Look, least: int = 0, unique: bool = False) -> Look:
    def look(value: Any, at: str) -> Iterator[Problem]:
        if not isinstance(value, list) or len(value) < least:
            yield f"{at}: no list of {least} or more"
            return
        if unique and any(value.count(each) > 1 for each in value):
            yield f"{at}: something is in it twice"
        for number, each in enumerate(value):
            yield from of(each, f"{at}[{number}]")

    return look


def _such(is_so: Callable[[Any], object], wanted: str) -> Look:
    def look(value: Any, at: str) -> Iterator[Problem]:
        if not is_so(value):
            yield f"{at}: {value!r} is not {wanted}"

    return look


def _one_of(*values: str) -> Look:
    return _such(lambda value: value in values, f"one of {values}")


def _number(least: int) -> Look:
    return _such(lambda value: type(value) is int and value >= least, f"a whole number from {least}")


TEXT = _such(lambda value: isinstance(value, str), "a text")
URI = _such(lambda value: isinstance(value, str) and _URI_REFERENCE.fullmatch(value), "a URI reference")
LEVEL = _one_of("none", "note", "warning", "error")

OBJECTS: dict[str, tuple[tuple[str, ...], dict[str, Look]]] = {
    "sarifLog": (("version", "runs"), {
        "$schema": URI, "version": _one_of("2.1.0"), "runs": _list(_object("run"))}),
    "run": (("tool", "results"), {  # results: "must be present (but may be empty)" after a scan
        "tool": _object("tool"), "results": _list(_object("result")),
        "columnKind": _one_of("utf16CodeUnits", "unicodeCodePoints")}),
    "tool": (("driver",), {"driver": _object("toolComponent")}),
    "toolComponent": (("name",), {
        "name": TEXT, "semanticVersion": TEXT, "rules": _list(_object("reportingDescriptor"), unique=True)}),
    "reportingDescriptor": (("id",), {
        "id": TEXT, "shortDescription": _object("multiformatMessageString"),
        "fullDescription": _object("multiformatMessageString"), "help": _object("multiformatMessageString"),
        "defaultConfiguration": _object("reportingConfiguration")}),
    "multiformatMessageString": (("text",), {"text": TEXT, "markdown": TEXT}),
    "reportingConfiguration": ((), {"level": LEVEL}),
    "result": (("message",), {
        "ruleId": TEXT, "ruleIndex": _number(-1), "level": LEVEL, "message": _object("message"),
        "locations": _list(_object("location")), "fixes": _list(_object("fix"), unique=True)}),
    "message": (("text",), {"text": TEXT}),  # an `id` is allowed too, but not used
    "location": ((), {"physicalLocation": _object("physicalLocation")}),
    "physicalLocation": (("artifactLocation",), {
        "artifactLocation": _object("artifactLocation"), "region": _object("region")}),
    "artifactLocation": ((), {"uri": URI}),
    "region": (("startLine",), {
        "startLine": _number(1), "startColumn": _number(1), "endLine": _number(1), "endColumn": _number(1)}),
    "fix": (("artifactChanges",), {
        "description": _object("message"), "artifactChanges": _list(_object("artifactChange"), 1, unique=True)}),
    "artifactChange": (("artifactLocation", "replacements"), {
        "artifactLocation": _object("artifactLocation"), "replacements": _list(_object("replacement"), 1)}),
    "replacement": (("deletedRegion",), {
        "deletedRegion": _object("region"), "insertedContent": _object("artifactContent")}),
    "artifactContent": ((), {"text": TEXT}),
}  # fmt: skip
"""For each object: required properties, and the allowed values of all properties that are used."""
