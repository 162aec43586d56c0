"""The bench for a command line: a MODEL with options, or a SCENE.toml."""

from collections.abc import Iterable
from pathlib import Path

from axistwin.bench import Bench
from axistwin.bench.options import read_options
from axistwin.core.errors import UsageError


def bench_for(target: str, options: Iterable[str] = (), state: Path | None = None) -> Bench:
    options = tuple(options)
    if not target.endswith(".toml"):
        bench = Bench()
        bench.add(target, state=state, **read_options(options))
        return bench
    if options or state:
        raise UsageError("--option and --state cannot be used with a scene: make these settings in the scene file")
    from axistwin.scenes.scene import Scene  # Lazy import, because axistwin.scenes.scene loads slowly.

    made: Bench = Scene.load(Path(target)).build()
    return made
