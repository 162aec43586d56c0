"""The error for a mistyped name."""

from collections.abc import Collection

from axistwin.core.errors import UsageError, most_similar


def unknown(kind: str, name: str, names: Collection[str]) -> UsageError:
    near = most_similar(name.lower(), names)
    return UsageError(f"no {kind} {name!r}: {f'did you mean {near}?' if near else 'expected ' + ', '.join(names)}")
