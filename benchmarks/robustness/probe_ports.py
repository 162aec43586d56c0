"""Prove that `axistwin probe` works over each kind of port: pseudo-terminal, TCP port and bus socket.

    python benchmarks/robustness/probe_ports.py [--model MODEL]

An IF1 and a SmartMotor are served on a pty and on a TCP port, an 1811 on a bus socket, in real time.  Each is probed
without motion, the SmartMotor also with `--memory`.  No case may differ in its bytes, and everything must be restored.
The comparison of times depends on the load of the computer, so late answers are only counted.  The exit code is 1 if a
probe finds other bytes, or nothing to compare.
"""

import argparse
import sys
import time
from pathlib import Path
from typing import Literal

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin.bench import product
from axistwin.core.errors import LinkError
from axistwin.real.hosts.end import End
from axistwin.real.hosts.real_time import open_end
from axistwin.real.probing.comparing import Settings, Verdict, probe
from axistwin.testing import serve

PORTS: tuple[tuple[str, Literal["tcp", "pty"] | None], ...] = (
    ("if1", "pty"),
    ("if1", "tcp"),
    ("smartmotor", "pty"),
    ("smartmotor", "tcp"),
    ("1811", None),
)
ATTEMPTS = 50


def wait_for_power_up(end: End, request: bytes) -> None:
    """Wait until a controller that has just been switched on answers."""
    for _ in range(ATTEMPTS):
        try:
            if end.ask(request, 2).data:
                return
        except LinkError:
            time.sleep(0.1)


REQUESTS = {"if1": b"(", "smartmotor": b"RSP\r", "1811": b"\x01\x07"}


def probed(model: str, scheme: Literal["tcp", "pty"] | None) -> bool:
    """Probe one controller over one port; print the result, and return True if no bytes differ."""
    made, began = product(model), time.monotonic()
    with serve(model, scheme=scheme) as twin:
        end = open_end(str(twin.ports[model]), made.line)
        try:
            wait_for_power_up(end, REQUESTS[model])
            found = probe(model, end, Settings(memory=model == "smartmotor", find_options=False))
        finally:
            end.close()
    other = [result.case.name for result in found.of(Verdict.DIFFERS) if result.reason == "another answer"]
    late = len(found.of(Verdict.DIFFERS)) - len(other)
    same = len(found.of(Verdict.SAME))
    good = not other and not found.not_restored and same > len(found.results) // 2
    print(
        f"{'same' if good else 'DIFFERS'}: {model} over {scheme or 'bus'}: {same} same, {len(other)} with other bytes, "
        f"{late} late, {len(found.of(Verdict.INCONCLUSIVE))} inconclusive; {time.monotonic() - began:.0f} s "
        f"{other[:3]}",
        flush=True,
    )
    return good


def main() -> int:
    """Probe all ports."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--model", choices=[model for model, _ in PORTS])
    given = parser.parse_args()
    ports = [(model, scheme) for model, scheme in PORTS if given.model in (None, model)]
    good = sum(probed(model, scheme) for model, scheme in ports)
    print(f"{'held' if good == len(ports) else 'FAILED'}: {good} of {len(ports)} ports; "
          f"{time.process_time():.0f} s of processor time")  # fmt: skip
    return 0 if good == len(ports) else 1


if __name__ == "__main__":
    sys.exit(main())
