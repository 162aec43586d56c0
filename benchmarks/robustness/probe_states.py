"""Prove that a probe without motion moves nothing and finds nothing, whatever state the controller is in.

    python benchmarks/robustness/probe_states.py [--seed 3] [--states 1000]

A controller of one of three families receives random commands, among them moves, held messages, modes and stored
programs.  When it is at rest, it is probed with `--motion none`,
and every second time with `--memory` as well.  No step
pulse may be made, no shaft may move, no output may change, and no case may differ.  Everything runs in virtual time.
The exit code is 1 if anything moves or differs.
"""

import argparse
import random
import sys
import time
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin.bench import product
from axistwin.core.errors import AxistwinError
from axistwin.real.probing.cases import dialect
from axistwin.real.probing.comparing import Settings, Twin, Verdict, probe
from states import random_state

MODELS = ("if1", "1811", "smartmotor")
STILL = Settings(find_options=False)
OUTPUTS = {
    "if1": ("output1", "output2", "output3", "output4", "output5"),
    "1811": ("output1", "output2", "shutdown"),
    "smartmotor": (*"ABCDEFG", "brake"),
}
"""Terminals that a probe without motion must not change."""


@cache
def twin(model: str) -> Twin:
    """Return a twin with its answers to all cases that move nothing."""
    made = product(model)
    family = dialect(made)
    facts = {"line": str(made.line or ""), "limits": "closed"}
    cases = [case for case in family.cases(made, facts) if not case.moves and not case.bare]
    return Twin(made, family, cases, None, {}, facts)


def state(model: str, rng: random.Random, kinds: Counter[str], *, memory: bool) -> str:
    """Probe a controller in a random state without motion; return an error, or an empty text."""
    bench, end, said = random_state(model, rng, programs=True)
    if bench is None:
        kinds["moving by itself, not probed"] += 1
        return ""
    began, controller = bench.now, end.controller
    axes = controller.axes
    before = [axis.position for axis in axes.values()]
    levels = [controller.pins[name].level for name in OUTPUTS[model]]
    try:
        # A motor that echoes needs a twin that echoes.
        found = probe(model, end, replace(STILL, memory=memory), None if b"ECHO" in b"".join(said) else twin(model))
        kinds["only read" if found.condition.no_writes else "probed"] += 1
        if memory and not found.condition.no_memory and found.not_restored:
            return f"{model}: {found.not_restored} after {said}"
        if wrong := found.of(Verdict.DIFFERS):
            return f"{model}: {len(wrong)} differ, e.g. {wrong[0].case.name}, after {said}"
    except AxistwinError:
        kinds["refused"] += 1
    pulses = model != "smartmotor" and sum(axis.pulse_times(began).size for axis in axes.values())
    if pulses or [axis.position for axis in axes.values()] != before:
        return f"{model}: {pulses} pulses after {said}"
    if [controller.pins[name].level for name in OUTPUTS[model]] != levels:
        return f"{model}: an output has changed after {said}"
    return ""


def campaign(seed: int, states: int) -> tuple[list[str], Counter[str]]:
    """Return the errors, and how many states there were of each kind."""
    rng, kinds = random.Random(seed), Counter[str]()
    lines = [state(MODELS[n % len(MODELS)], rng, kinds, memory=n // len(MODELS) % 2 == 1) for n in range(states)]
    return [line for line in lines if line], kinds


def main() -> int:
    """Probe controllers in random states."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--states", type=int, default=1000)
    given = parser.parse_args()
    wrong, kinds = campaign(given.seed, given.states)
    print("\n".join(f"wrong: {line}" for line in wrong), end="\n" if wrong else "")
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    print(
        f"{'held' if not wrong else 'FAILED'}: {len(wrong)} errors in {given.states} states"
        f" ({counts}); seed {given.seed}; {time.process_time():.0f} s of processor time"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
