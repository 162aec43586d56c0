"""Prove how many changes `axistwin probe` finds, and that no unchanged controller differs.

    python benchmarks/robustness/probe.py [--seed 1] [--mutants 200] [--unchanged 50] [--model MODEL] [--part K N]

Mutants: controllers of three families with one changed command, or with another value of an option.  A command is
ignored, has another answer, or uses another parameter.  For a command that the compiler or the parser replaces (IF, a
GOSUB in a program, `$`), the compiler or the parser is changed.  The probe runs with all its levels: motion, memory,
without a machine.  Mutants that a probe cannot show are listed with the reason; a command that no case sends counts as
a mutant that is not found.  Unchanged: none may differ.  The exit code is 1 if an unchanged controller differs, if
fewer than 95 % of the other mutants are found, or if more than 10 % cannot be shown.  `--mutants 0`: all mutants.
"""

import argparse
import random
import signal
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench
from axistwin.bench import product
from axistwin.controllers.digiplan import interface
from axistwin.controllers.digiplan.language import Accept
from axistwin.controllers.product import Product
from axistwin.controllers.smartmotor.language import language, program
from axistwin.controllers.smartmotor.language.language import Statement
from axistwin.core.errors import AxistwinError
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.cases import dialect
from axistwin.real.probing.comparing import Motion, Probe, Settings, Twin, Verdict, other_values, probe

MODELS = ("if1", "1811", "smartmotor")
FULL = Settings(Motion.SMALL, as_new=True, memory=True, plug=True, find_options=False)
PLUGGED = {"plug": "True"}
FOUND, MOST_INVISIBLE = 0.95, 0.10
MOST_S = 20.0
"""Most processor time of one probe; a usual one takes less than 4 s."""
ELSEWHERE, OUTSIDE = "only a terminal shows the effect, which the probe cannot read", "needs a signal at an input"
NONE = "has no effect in any state"
POWER_UP = "acts only at power-up, before a probe"
UNSAFE = "not sent: the machine could move without limit, or lose the power of its drives"
NOT_SHOWN: dict[str, dict[str, tuple[object, ...]]] = {
    "if1": {
        OUTSIDE: ("limits",), POWER_UP: ("V", "*", "self_test_s"),
        "ends a message only in the data format V": ("\n",),
        "the host's end of the cable is the same": ("wiring",),
        "acts only within 5 ms of the data format message, or after a lock in another format": (
            "strict_format", "unlock",
        ),
    },
    "1811": {
        ELSEWHERE: ("interrupts", "high_impedance", "test_switch"), NONE: (0x00, 0xFE),
        OUTSIDE: (
            0x19, *range(0xA6, 0xAA), 0x37, "trigger1_hold_us", "trigger6_hold_us", "invert_z",
            "invert_encoder",
        ),
        UNSAFE: (0x3A, 0xFF), "sent only to a board without a machine": (0x10, 0x11), POWER_UP: ("initialisation_s",),
        "acts only on an 1810": ("encoder_commands",),
        "the probe waits for each answer, so nothing is queued": ("command_queue", "message_queue"),
    },
    "smartmotor": {
        "acts only on channel 1, which the probe does not use": (
            "ECHO1", "ECHO_OFF1", "SLEEP1", "WAKE1", "SILENT1", "TALK1", "PRINT1()",
        ),
        "no AniLink device and no other encoder is emulated": (
            "AOUTp", "DOUTp", "ENC0", *(f"PRINT{device}()" for device in "ABCDEFGH"),
        ),
        NONE: ("LIMD",),
        "needs a stalled or overloaded shaft": ("Ze", "Za", "F"),
        "a value that changes without a command": ("RTEMP", "RCLK"),
        ELSEWHERE: ("brake",), OUTSIDE: ("reset_below_v",),
        "needs a program of 32 kB, which takes more than a minute": ("program_bytes",),
    },
}  # fmt: skip
"""Mutants that no answer shows, by model, reason, and code or option."""


def new(model: str, **options: Any) -> tuple[Bench, VirtualEnd]:
    """Return a controller that has just been switched on."""
    bench = Bench()
    controller = bench.add(model, **options)
    dialect(product(model)).equip(controller, PLUGGED)
    bench.run(2)
    return bench, VirtualEnd(bench, controller)


@cache
def twin(model: str) -> Twin:
    """Return an unchanged twin with its answers to all cases."""
    made = product(model)
    family = dialect(made)
    facts = {"line": str(made.line or ""), **PLUGGED}
    return Twin(made, family, family.cases(made, facts), None, {}, facts)


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise AxistwinError after this processor time: a changed sequence can repeat for ever within a nanosecond."""

    def stop(*_: object) -> None:
        raise AxistwinError("the controller does not come to rest")

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def probed(model: str, *, to_the_end: bool = False, **options: Any) -> Probe | None:
    """Probe a new controller up to the first difference; None if the controller does not answer."""
    twin(model)
    try:
        with limited(MOST_S):
            return probe(model, new(model, **options)[1], replace(FULL, first_difference=not to_the_end), twin(model))
    except (AxistwinError, ArithmeticError, LookupError, TypeError, ValueError, AssertionError, AttributeError):
        return None


def differs(found: Probe | None) -> bool:
    """Return True if a probe shows a difference."""
    return found is None or bool(found.not_restored) or bool(found.of(Verdict.DIFFERS))


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


IGNORED, ANSWER, PARAMETER = "ignored", "another answer", "another parameter"
CHANGES: dict[str, Callable[..., Callable[..., Any]]] = {
    IGNORED: lambda handler: nothing, ANSWER: other_answer, PARAMETER: other_parameter,
}  # fmt: skip
COMPILED = {*program._OPERATIONS, *program._WRITERS, *program.SILENT}
"""Commands of the SmartMotor that the compiler of programs replaces."""


def other_statement(code: object, change: str) -> Callable[[str], Statement]:
    """Return a reader for the compiler of programs, which ignores one command or adds 1 to its number."""
    read = program.read

    def changed(text: str) -> Statement:
        statement = read(text)
        if statement.command is None or statement.command.code != code:
            return statement
        if change == IGNORED:
            return read("LIMD")  # a command without effect
        numbers = tuple(value + 1 if type(value) is int else value for value in statement.operands)
        return replace(statement, operands=numbers)

    return changed


def other_character(code: bytes) -> Callable[[VirtualEnd, bytes], None]:
    """Return a line to an IF1 that does not know one character."""
    send = VirtualEnd.send
    return lambda end, data: send(end, data.replace(code, b"~"))


@contextmanager
def changed(made: Product, code: Any, change: str) -> Iterator[None]:
    """Change one handler of a command table, and what the compiler or the parser makes of the command."""
    command = made.commands._by_code[code]
    clear_caches()
    with ExitStack() as stack:
        if command.handler is not None:
            handler = CHANGES[change](command.handler)
            stack.enter_context(patch.dict(made.commands._by_code, {code: replace(command, handler=handler)}))
        if made.model == "smartmotor" and code in COMPILED:
            stack.enter_context(patch.object(program, "read", other_statement(code, change)))
        if made.model == "if1" and (code == "#" or command.accepted & (Accept.WRITTEN | Accept.SETUP)):  # type: ignore[attr-defined]
            stack.enter_context(patch.object(VirtualEnd, "send", other_character(str(code).encode())))
        yield
    clear_caches()


def clear_caches() -> None:
    """Clear the cached commands, which were read with another table."""
    for read in (interface.read, language.command, language.read):
        getattr(read, "cache_clear", nothing)()


@cache
def effective(model: str) -> dict[Any, set[str]]:
    """Return, by code, the changes that affect an answer or a number in an unchanged probe."""
    made, found = product(model), defaultdict[Any, set[str]](set)
    clear_caches()

    def watched(code: Any, handler: Callable[..., Any]) -> Callable[..., Any]:
        def called(*arguments: Any, **keywords: Any) -> Any:
            answer = handler(*arguments, **keywords)
            if any(type(value) is int for value in (*arguments, *keywords.values())):
                found[code].add(PARAMETER)
            # A text from a board's command is the reason why it is ignored, not an answer.
            if isinstance(answer, bytes if made.line is None else bytes | str):
                found[code].add(ANSWER)
            return answer

        return called

    every = {
        command.code: replace(command, handler=watched(command.code, command.handler))
        for command in made.commands
        if command.handler is not None
    }
    with patch.dict(made.commands._by_code, every):
        probed(model, to_the_end=True)
    clear_caches()
    for code in ("Cn", "GOTOn", "GOSUBn", "CASE") if model == "smartmotor" else ():
        found[code].add(PARAMETER)
    return found


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


Mutant = tuple[str, Any, str, object]
"""Model, code or name of an option, change, and value of the option."""
OPTION = "option"


def population(models: tuple[str, ...]) -> list[Mutant]:
    """Return all mutants of these models."""
    found: list[Mutant] = []
    for model in models:
        for command in product(model).commands:
            if command.implemented:
                changes = [IGNORED, *sorted(effective(model)[command.code])]
                found += [(model, command.code, change, None) for change in changes]
        found += [(model, name, OPTION, value) for name, value in option_values(model)]
    return found


def found_by_probe(mutant: Mutant) -> bool:
    """Return True if a probe shows a mutant."""
    model, code, change, value = mutant
    twin(model)
    if change == OPTION:
        return differs(probed(model, **{code: value}))
    with changed(product(model), code, change):
        return differs(probed(model))


def name(mutant: Mutant) -> str:
    """Return the name of a mutant."""
    model, code, change, value = mutant
    if change == OPTION:
        return f"{model} option {code}={value}"
    written = code if isinstance(code, str) else f"{code:02X}h"
    return f"{model} {written} {product(model).commands._by_code[code].name}: {change}"


def mutants(
    rng: random.Random, number: int, models: tuple[str, ...], part: int = 0, parts: int = 1
) -> tuple[int, list[str], list[str]]:
    """Probe one part of the mutants; return the number found, those missed, and those that no probe can show."""
    every = population(models)
    rng.shuffle(every)
    found, missed, invisible = 0, [], []
    for mutant in every[: number or None][part::parts]:
        if found_by_probe(mutant):
            found += 1
        elif why := reason(*mutant[:2]):
            invisible.append(f"{name(mutant)}: {why}")
        else:
            missed.append(name(mutant))
    return found, missed, invisible


def main() -> int:
    """Run all campaigns."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for option, default in (("seed", 1), ("mutants", 200), ("unchanged", 50)):
        parser.add_argument(f"--{option}", type=int, default=default)
    parser.add_argument("--part", type=int, nargs=2, default=(0, 1), metavar=("K", "N"), help="every Nth mutant from K")
    parser.add_argument("--model", choices=MODELS, action="append")
    given = parser.parse_args()
    models = tuple(given.model or MODELS)
    wrong = [
        model for n in range(given.unchanged) if differs(probed(model := models[n % len(models)], to_the_end=True))
    ]
    found, missed, invisible = mutants(random.Random(given.seed), given.mutants, models, *given.part)
    for title, names in (("not found", missed), ("cannot be shown", invisible)):
        print("\n".join(f"{title}: {name}" for name in sorted(names)), end="\n" if names else "")
    share = found / max(1, found + len(missed))
    few = len(invisible) <= MOST_INVISIBLE * (found + len(missed) + len(invisible))
    good = not wrong and share >= FOUND and few
    print(
        f"{'held' if good else 'FAILED'}: {found} of {found + len(missed)} mutants found ({share:.1%}), "
        f"{len(invisible)} cannot be shown; {len(wrong)} of {given.unchanged} unchanged controllers differ; "
        f"seed {given.seed}; {time.process_time():.0f} s of processor time"
    )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
