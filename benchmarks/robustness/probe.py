"""A probe against changed controllers, in virtual time.

    python benchmarks/robustness/probe.py [--seed 1] [--mutants 200] [--unchanged 50] [--states 1000]

Mutants: controllers with one changed handler of the command table, which some case calls.  Those that no byte shows are
listed with the reason, and so are commands that no case sends.  Unchanged: none may differ.  States: after random
commands, a probe without motion may make no pulse.  The exit code is 1 if an unchanged controller differs, if a pulse
is made, or if fewer than 95 % of the other mutants are found.
"""

import argparse
import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench
from axistwin.bench import product
from axistwin.controllers.digiplan import interface
from axistwin.controllers.product import Product
from axistwin.errors import AxistwinError
from axistwin.probing import Motion, Probe, Settings, Twin, Verdict, VirtualEnd, probe
from axistwin.probing.cases import dialect

MODELS = ("if1", "1811")
NEW = Settings(Motion.SMALL, as_new=True, find_options=False)
STILL = Settings(find_options=False)
FOUND, MOST_INVISIBLE = 0.95, 0.10
TIME = "only the time of a move changes, and no case measures times of moves"
INVISIBLE = {
    (0x14, "ignored"): "only the direction pin changes", (0x14, "another parameter"): "a switch: 2 is as 1",
    (0xD6, "ignored"): TIME, (0xD6, "another parameter"): TIME, (0x29, "another parameter"): TIME,
    ("=", "another parameter"): TIME, ("B", "another parameter"): TIME, ("B", "ignored"): TIME,
}  # fmt: skip
"""Mutants that no byte of an answer shows, by code and change, with the reason."""


def new(model: str, **options: Any) -> tuple[Bench, VirtualEnd]:
    """Return a controller that has just been switched on."""
    bench = Bench()
    controller = bench.add(model, **options)
    bench.run(2)
    return bench, VirtualEnd(bench, controller)


@cache
def twin(model: str) -> Twin:
    """Return an unchanged twin with its answers to all cases."""
    made = product(model)
    family = dialect(made)
    cases = family.cases(made, "\r" if made.line else "")
    return Twin(made, family, cases, None, {})


def probed(model: str, **options: Any) -> Probe | None:
    """Probe a new controller; None if it does not answer."""
    try:
        return probe(model, new(model, **options)[1], NEW, twin(model))
    except (AxistwinError, ArithmeticError, LookupError, TypeError, ValueError, AssertionError, AttributeError):
        return None


def differs(found: Probe | None) -> bool:
    """Return True if a probe shows a difference."""
    return found is None or bool(found.of(Verdict.DIFFERS))


# Mutants


def nothing(*_: Any, **__: Any) -> None:
    """Do nothing: a command that is not implemented."""


def other_answer(handler: Callable[..., Any]) -> Callable[..., Any]:
    """Return a handler whose answer has another last byte."""

    def changed(*arguments: Any, **keywords: Any) -> Any:
        answer = handler(*arguments, **keywords)
        if not isinstance(answer, bytes) or not answer:
            return answer
        body = answer.rstrip(b"\r\n") or answer
        return body[:-1] + bytes((body[-1] ^ 1,)) + answer[len(body) :]

    return changed


def other_parameter(handler: Callable[..., Any]) -> Callable[..., Any]:
    """Return a handler that uses its last number plus 1."""

    def changed(*arguments: Any, **keywords: Any) -> Any:
        places = [place for place, value in enumerate(arguments) if type(value) is int]
        values = (value + 1 if place in places[-1:] else value for place, value in enumerate(arguments))
        return handler(*values, **keywords)

    return changed


CHANGES: dict[str, Callable[..., Callable[..., Any]]] = {
    "ignored": lambda handler: nothing, "another answer": other_answer, "another parameter": other_parameter,
}  # fmt: skip


@contextmanager
def changed(made: Product, code: object, change: str) -> Iterator[Counter[str]]:
    """Change one handler of a command table; yield the number of calls in which there was something to change."""
    command, calls = made.commands._by_code[code], Counter[str]()
    handler = CHANGES[change](command.handler)

    def counted(*arguments: Any, **keywords: Any) -> Any:
        numbers = any(type(value) is int for value in arguments)
        answer = handler(*arguments, **keywords)
        calls["sent"] += 1
        calls["effective"] += {
            "ignored": True,
            "another answer": isinstance(answer, bytes),
            "another parameter": numbers,
        }[change]
        return answer

    interface.read.cache_clear()
    with patch.dict(made.commands._by_code, {code: replace(command, handler=counted)}):
        yield calls
    interface.read.cache_clear()


def mutants(rng: random.Random, number: int) -> tuple[int, list[str], list[str]]:
    """Probe mutants; return the number of found ones, the names of missed ones, and commands that no case sends."""
    found, missed, unsent = 0, [], set()
    every = [(m, c.code, change) for m in MODELS for c in product(m).commands if c.implemented for change in CHANGES]
    rng.shuffle(every)
    for model, code, change in every if number else []:
        twin(model)
        made = product(model)
        with changed(made, code, change) as calls:
            result = differs(probed(model))
        name = f"{model} {code if isinstance(code, str) else f'{code:02X}h'} {made.commands.get(code).name}"
        if not calls["sent"]:
            unsent.add(name)
        if not calls["effective"]:
            continue
        if result:
            found += 1
        else:
            missed.append(f"{name}: {change}: {INVISIBLE.get((code, change), 'missed')}")
        if found + len(missed) == number:
            break
    return found, missed, sorted(unsent)


# Random states


def move(model: str, rng: random.Random) -> bytes:
    """Return a random command that may move, wait or set something."""
    if model == "1811":
        code = rng.choice([command.code for command in product(model).commands])
        return bytes((code, *(rng.choice((0, 0, 1, 2, 50)) for _ in range(rng.randint(0, 14)))))
    parts = (
        "X",
        "Y",
        "+",
        "-",
        "100",
        "5",
        "$",
        "@400",
        "<4",
        "G",
        ":",
        "H1",
        "%",
        "[",
        "#",
        "B+5",
        "R1",
        "S2",
        "F",
        "\r",
    )
    return "".join(rng.choices(parts, k=rng.randint(1, 9))).encode() + rng.choice((b"\r", b"\r", b""))


def state(model: str, rng: random.Random) -> str:
    """Probe a controller in a random state without motion; return an error, or an empty text."""
    bench, end = new(model)
    if model == "if1":
        end.ask(b"(", 2)
        end.ask(b"U61\r", wait_s=1.5)
    said = [move(model, rng) for _ in range(rng.randint(1, 6))]
    for message in said:
        end.ask(message)
    bench.run(rng.choice((0.5, 5)))
    controller = bench.controllers[model]
    if any(axis.moving for axis in controller.axes.values()) or (model == "1811" and controller.busy):
        return ""  # moves by itself
    began = bench.now
    with suppress(AxistwinError):
        probe(model, end, STILL)
    pulses = sum(axis.pulse_times(began).size for axis in controller.axes.values())
    return f"{model}: {pulses} pulses after {said}" if pulses else ""


def main() -> int:
    """Run all campaigns."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for name, default in (("seed", 1), ("mutants", 200), ("unchanged", 50), ("states", 1000)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parser.parse_args()
    rng = random.Random(given.seed)
    wrong = [model for n in range(given.unchanged) if differs(probed(model := MODELS[n % len(MODELS)]))]
    moved = [line for n in range(given.states) if (line := state(MODELS[n % len(MODELS)], rng))]
    found, missed, unsent = mutants(rng, given.mutants)
    for title, names in (("moved", moved), ("not found", missed), ("sent by no case", unsent)):
        print("\n".join(f"{title}: {name}" for name in names), end="\n" if names else "")
    visible = [name for name in missed if name.endswith(": missed")]
    share = found / max(1, found + len(visible))
    invisible = len(missed) - len(visible)
    reached = not given.mutants or (share >= FOUND and invisible <= MOST_INVISIBLE * (found + len(missed)))
    good = not wrong and not moved and reached
    print(
        f"{'held' if good else 'FAILED'}: {found} of {found + len(visible)} mutants found ({share:.1%}), {invisible} "
        f"invisible; {len(wrong)} of {given.unchanged} unchanged controllers differ; "
        f"{len(moved)} of {given.states} states with pulses; seed {given.seed}"
    )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
