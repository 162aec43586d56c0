"""Benches for tests."""

from collections.abc import Callable
from typing import Any

from axistwin import Bench


def bench_of(*models: str, **options: Any) -> Callable[[], Bench]:
    """Return a function that builds a bench of controllers, each "MODEL" or "MODEL NAME", all with these options."""

    def build() -> Bench:
        bench = Bench()
        for model, _, name in (each.partition(" ") for each in models):
            bench.add(model, name or model, **options)
        return bench

    return build
