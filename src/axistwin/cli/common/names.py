"""The error for a mistyped name."""

from collections.abc import Iterable

from axistwin.errors import UsageError


def unknown(kind: str, name: str, names: Iterable[str]) -> UsageError:
    """Return an error for an unknown name; its message suggests valid names."""
    from difflib import get_close_matches

    listed = list(names)
    near = get_close_matches(name.lower(), listed, 1)
    return UsageError(f"no {kind} {name!r}: {f'did you mean {near[0]}?' if near else 'expected ' + ', '.join(listed)}")
