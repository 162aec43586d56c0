"""The bench that a command line asks for: a MODEL with options, or a SCENE.toml."""

from collections.abc import Iterable
from pathlib import Path

from axistwin.bench import Bench
from axistwin.bench.options import read_options
from axistwin.errors import UsageError


def bench_for(target: str, options: Iterable[str] = (), state: Path | None = None) -> Bench:
    """A bench with one controller, or the one that a scene describes."""
    options = tuple(options)
    if not target.endswith(".toml"):
        bench = Bench()
        bench.add(target, state=state, **read_options(options))
        return bench
    if options or state:
        raise UsageError("--option and --state are for a MODEL: write them into the scene")
    from axistwin.scenes.scene import Scene  # brings pydantic along

    made: Bench = Scene.load(Path(target)).build()
    return made
