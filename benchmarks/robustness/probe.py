"""A probe against changed controllers, in virtual time.

    python benchmarks/robustness/probe.py [--seed 1] [--mutants 200] [--unchanged 50] [--states 1000]

Mutants: controllers of three families with one changed handler of the command table, or with another value of an
option.  Mutants that a probe cannot show are listed with the reason; a command that no case sends counts as a mutant
that is not found.  Unchanged: none may differ.  States: after random commands, a probe without motion may make no pulse
and no step of a shaft.  The exit code is 1 if an unchanged controller differs, if something moves, if fewer than 95 %
of the other mutants are found, or if more than 10 % cannot be shown.
"""

import argparse
import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import fields, replace
from functools import cache, partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench
from axistwin.bench import product
from axistwin.controllers.digiplan import interface
from axistwin.controllers.product import Product
from axistwin.controllers.smartmotor.language import language
from axistwin.errors import AxistwinError
from axistwin.probing import Motion, Probe, Settings, Twin, Verdict, VirtualEnd, probe
from axistwin.probing.cases import dialect
from axistwin.probing.comparing import other_values
from states import random_state

MODELS = ("if1", "1811", "smartmotor")
NEW = Settings(Motion.SMALL, as_new=True, find_options=False)
STILL = Settings(find_options=False)
FOUND, MOST_INVISIBLE = 0.95, 0.10
PIN, EDGE, NONE = "only a pin changes", "needs a signal at an input", "has no effect in any state"
POWER_UP = "acts only at power-up, before a probe"
UNSAFE = "not sent: the machine could move without limit, or lose the power of its drives"
NOT_SHOWN: dict[str, dict[str, tuple[object, ...]]] = {
    "if1": {
        PIN: ("S", "R", "fault_output"), EDGE: ("L", "limits"), POWER_UP: ("U", "V", "(", "*", "self_test_s"),
        "the handler is not called: the command is part of the grammar": (
            "\n", "\r", " ", "$", "+", ",", "-", ":", "#",
        ),
        "the host's end of the cable is the same": ("wiring",),
        "acts only within 5 ms of the data format message, or after a lock in another format": (
            "strict_format", "unlock",
        ),
    },
    "1811": {
        PIN: (0x14, "interrupts", "high_impedance", "test_switch"), NONE: (0x00, 0xFE),
        EDGE: (
            *range(0x74, 0x78), *range(0x7C, 0x80), 0xAC, 0x19, *range(0xA6, 0xAC), 0x35, 0x36, 0x37, "limit_us",
            "trigger1_us", "trigger6_us", "trigger1_hold_us", "trigger6_hold_us", "home_ms", "invert_z",
            "invert_encoder",
        ),
        UNSAFE: (0x10, 0x11, 0x12, 0x13, 0x39, 0x3A, 0xFF), POWER_UP: ("initialisation_s",),
        "acts only on an 1810": ("encoder_commands",),
    },
    "smartmotor": {
        PIN: ("brake",), EDGE: ("debounce_samples", "index_at", "reset_below_v"), POWER_UP: ("boot_window_s",),
        "needs a stored program": ("statements_per_sample", "load_block", "program_bytes"),
    },
}  # fmt: skip
"""Mutants that no answer shows, by model, reason, and code or option."""


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
        if isinstance(answer, str) and answer:
            return answer[:-1] + chr(ord(answer[-1]) ^ 1)
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
        named = {name: value + 1 if type(value) is int else value for name, value in keywords.items()}
        return handler(*values, **named)

    return changed


CHANGES: dict[str, Callable[..., Callable[..., Any]]] = {
    "ignored": lambda handler: nothing, "another answer": other_answer, "another parameter": other_parameter,
}  # fmt: skip


@contextmanager
def changed(made: Product, code: object, change: str) -> Iterator[Counter[str]]:
    """Change one handler of a command table; yield the number of its calls that the change affects."""
    command, calls = made.commands._by_code[code], Counter[str]()
    handler = CHANGES[change](command.handler)

    def counted(*arguments: Any, **keywords: Any) -> Any:
        numbers = any(type(value) is int for value in (*arguments, *keywords.values()))
        answer = handler(*arguments, **keywords)
        calls["sent"] += 1
        calls["effective"] += {
            "ignored": True,
            "another answer": isinstance(answer, bytes | str),
            "another parameter": numbers,
        }[change]
        return answer

    clear_caches()
    with patch.dict(made.commands._by_code, {code: replace(command, handler=counted)}):
        yield calls
    clear_caches()


def clear_caches() -> None:
    """Clear the cached commands, which were read with another table."""
    interface.read.cache_clear()
    language.command.cache_clear()
    language.read.cache_clear()


def option_values(model: str) -> Iterator[tuple[str, object]]:
    """Yield another value of each option of a model."""
    made = product(model)
    yield from other_values(made, {})
    default = made.options()
    for option in fields(made.options):
        value = getattr(default, option.name)
        if type(value) is int:
            yield option.name, value * 2 if value != 8 else 32
        if option.name == "part_number":
            yield option.name, "94-012345-02B"
        if option.name == "interrupts":
            yield option.name, ("input_ready",)


def reason(model: str, code: object) -> str:
    """Return the reason why a probe does not show a mutant, or an empty text."""
    return next((words for words, codes in NOT_SHOWN[model].items() if code in codes), "")


def handler_mutant(model: str, code: Any, change: str) -> tuple[str, bool | None]:
    """Return the name of a mutant, and True if it is found; None if there is nothing to change."""
    made = product(model)
    name = f"{model} {code if isinstance(code, str) else f'{code:02X}h'} {made.commands.get(code).name}: {change}"
    with changed(made, code, change) as calls:
        found = differs(probed(model))
    if calls["effective"]:
        return name, found
    return name, None if calls["sent"] or change != "ignored" else False


def option_mutant(model: str, option: str, value: object) -> tuple[str, bool | None]:
    """Return the name of a mutant, and True if it is found."""
    return f"{model} option {option}={value}", differs(probed(model, **{option: value}))


def mutants(rng: random.Random, number: int) -> tuple[int, list[str], list[str]]:
    """Probe mutants; return the number of found ones, the names of missed ones, and names that cannot be shown."""
    every: list[tuple[str, Any, Callable[[], tuple[str, bool | None]]]] = [
        (m, c.code, partial(handler_mutant, m, c.code, change))
        for m in MODELS
        for c in product(m).commands
        if c.implemented
        for change in CHANGES
    ]
    every += [(m, name, partial(option_mutant, m, name, value)) for m in MODELS for name, value in option_values(m)]
    rng.shuffle(every)
    found, missed, invisible = 0, [], []
    for model, code, probe_it in every if number else []:
        twin(model)
        name, result = probe_it()
        if result:
            found += 1
        elif result is not None:
            why = reason(model, code)
            (invisible if why else missed).append(f"{name}: {why}" if why else name)
        if found + len(missed) + len(invisible) == number:
            break
    return found, missed, invisible


# Random states


def state(model: str, rng: random.Random) -> str:
    """Probe a controller in a random state without motion; return an error, or an empty text."""
    bench, end, said = random_state(model, rng)
    if bench is None:
        return ""
    began = bench.now
    axes = end.controller.axes
    before = [axis.position for axis in axes.values()]
    with suppress(AxistwinError):
        probe(model, end, STILL)
    pulses = model != "smartmotor" and sum(axis.pulse_times(began).size for axis in axes.values())
    if pulses or [axis.position for axis in axes.values()] != before:
        return f"{model}: {pulses} pulses after {said}"
    return ""


def main() -> int:
    """Run all campaigns."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for name, default in (("seed", 1), ("mutants", 200), ("unchanged", 50), ("states", 1000)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parser.parse_args()
    rng = random.Random(given.seed)
    wrong = [model for n in range(given.unchanged) if differs(probed(model := MODELS[n % len(MODELS)]))]
    moved = [line for n in range(given.states) if (line := state(MODELS[n % len(MODELS)], rng))]
    found, missed, invisible = mutants(rng, given.mutants)
    for title, names in (("moved", moved), ("not found", missed), ("cannot be shown", invisible)):
        print("\n".join(f"{title}: {name}" for name in names), end="\n" if names else "")
    share = found / max(1, found + len(missed))
    few = len(invisible) <= MOST_INVISIBLE * (found + len(missed) + len(invisible))
    reached = not given.mutants or (share >= FOUND and few)
    good = not wrong and not moved and reached
    print(
        f"{'held' if good else 'FAILED'}: {found} of {found + len(missed)} mutants found ({share:.1%}), "
        f"{len(invisible)} cannot be shown; {len(wrong)} of {given.unchanged} unchanged controllers differ; "
        f"{len(moved)} of {given.states} states with pulses; seed {given.seed}"
    )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
