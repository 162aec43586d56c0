"""Scenes: build a bench from a TOML file."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.scenes.hosting import loader, rank_of
    from axistwin.scenes.scene import Scene
    from axistwin.scenes.toml_places import places
else:
    __getattr__ = lazy(
        __name__,
        hosting="loader rank_of",
        scene="Scene",
        toml_places="places",
    )

__all__ = ["Scene", "loader", "places", "rank_of"]
