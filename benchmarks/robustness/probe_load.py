"""Prove that `axistwin probe` finds no difference where a busy computer or a slow port delays the answers.

    python benchmarks/robustness/probe_load.py [--seed 1] [--probes 60] [--model MODEL]

Controllers of three families without a fault are probed with all levels, over ports whose bytes arrive with drawn
delays, and by a program that is stopped now and then for a drawn time.  No case may differ.  With an idle port every
case must be the same.  Then one fault is planted in each, and must still be found.  Everything runs in virtual time.
The exit code is 1 if a case differs, or if a fault is not found.
"""

import argparse
import random
import sys
import time
from collections import Counter, deque
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin.bench import Bench, Controller, product
from axistwin.core.units import MS, S
from axistwin.real.hosts.virtual_time import VirtualEnd
from axistwin.real.probing.cases import dialect
from axistwin.real.probing.comparing import Probe, Verdict, probe
from probe import FULL, MODELS, PLUGGED, changed, twin

Delay = Callable[[random.Random], float]
PORTS: dict[str, tuple[Delay, float]] = {
    "idle": (lambda rng: rng.uniform(0, 0.004), 0.0),
    "some answers late": (lambda rng: rng.uniform(0, 0.08 if rng.random() < 0.2 else 0.004), 0.01),
    "half of the answers late": (lambda rng: rng.expovariate(10) if rng.random() < 0.5 else 0.002, 0.03),
    "few answers very late": (lambda rng: rng.uniform(0, 1.9 if rng.random() < 0.02 else 0.004), 0.0),
    "all answers late": (lambda rng: rng.expovariate(6), 0.0),
}
"""Delays of received bytes in seconds, and the share of requests before which the program is stopped."""
MOST_STOPPED_S = 1.5
FAULTS = {"if1": ("N", "another answer"), "1811": (0x97, "another answer"), "smartmotor": ("RKP", "another answer")}
"""A fault in each family: command and change."""


class LatePort(VirtualEnd):
    """A port whose received bytes arrive late, in their order; the virtual time is that of the clock on the wall."""

    exact = False
    grain_s = 0.02
    _LOOK_NS = 10 * MS

    def __init__(
        self, bench: Bench, controller: Controller, rng: random.Random, delay: Delay, stopped: float = 0.0
    ) -> None:
        super().__init__(bench, controller)
        self._rng, self._delay, self._stopped = rng, delay, stopped
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._due_ns = 0

    def send(self, data: bytes) -> None:
        """Send characters or a command, sometimes too late."""
        if self._rng.random() < self._stopped:
            self.bench.run(self._rng.uniform(0.1, MOST_STOPPED_S))
        super().send(data)

    def receive(self, silence_s: float = 0.0) -> bytes:  # noqa: ARG002  # time passes as at a real port
        """Return what has arrived within 10 ms."""
        clock, end_ns = self.bench.clock, self.bench.now + self._LOOK_NS
        while not (arrived := self.drain()) and self.bench.now < end_ns:
            due_ns = clock.next_event_ns()
            next_ns = min(end_ns, end_ns if due_ns is None else due_ns, *(at for at, _ in self._waiting))
            if next_ns > self.bench.now:
                clock.run_to(next_ns)
            else:
                clock.step()
        return arrived

    def drain(self) -> bytes:
        """Return what has arrived."""
        if self._messages:
            self._due_ns = max(self._due_ns, self.bench.now + round(self._delay(self._rng) * S))
            self._waiting.append((self._due_ns, bytes(self._messages)))
            self._messages.clear()
        arrived = b""
        while self._waiting and self._waiting[0][0] <= self.bench.now:
            arrived += self._waiting.popleft()[1]
        return arrived


def probed(model: str, port: str, rng: random.Random) -> Probe:
    """Probe a new controller over a port."""
    bench = Bench()
    controller = bench.add(model)
    dialect(product(model)).equip(controller, PLUGGED)
    bench.run(2)
    return probe(model, LatePort(bench, controller, rng, *PORTS[port]), FULL, twin(model))


def without_fault(model: str, port: str, rng: random.Random, counts: Counter[str]) -> str:
    """Probe a controller without a fault; return what is wrong, or an empty text."""
    found = probed(model, port, rng)
    counts.update(str(result.verdict) for result in found.results)
    wrong = [result.case.name for result in found.of(Verdict.DIFFERS)]
    if port == "idle":
        wrong += [result.case.name for result in found.of(Verdict.INCONCLUSIVE)]
    return f"{model}, {port}: {wrong[0]} and {len(wrong) - 1} other cases" if wrong else found.not_restored


def with_fault(model: str, port: str, rng: random.Random) -> str:
    """Probe a controller with a fault; return an error if it is not found."""
    twin(model)
    code, change = FAULTS[model]
    with changed(product(model), code, change):
        found = probed(model, port, rng)
    return "" if found.of(Verdict.DIFFERS) else f"{model}, {port}: {code} with {change} is not found"


def campaign(seed: int, probes: int, models: tuple[str, ...]) -> tuple[list[str], Counter[str]]:
    """Return the errors, and how many cases had each verdict."""
    rng, counts, lines = random.Random(seed), Counter[str](), []
    for number in range(probes):
        model, port = models[number % len(models)], list(PORTS)[number // len(models) % len(PORTS)]
        lines.append(without_fault(model, port, random.Random(rng.random()), counts))
    lines += [with_fault(model, "some answers late", random.Random(rng.random())) for model in models]
    return [line for line in lines if line], counts


def main() -> int:
    """Probe controllers over all ports."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--probes", type=int, default=60)
    parser.add_argument("--model", choices=MODELS, action="append")
    given = parser.parse_args()
    wrong, counts = campaign(given.seed, given.probes, tuple(given.model or MODELS))
    print("\n".join(f"wrong: {line}" for line in wrong), end="\n" if wrong else "")
    verdicts = ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict)
    print(
        f"{'held' if not wrong else 'FAILED'}: {len(wrong)} errors in {given.probes} probes ({verdicts}); "
        f"seed {given.seed}; {time.process_time():.0f} s of processor time"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
