"""Check that each port of a scene is of a valid kind, and that no port is used twice."""

from collections.abc import Iterator

from axistwin.bench import product
from axistwin.links.urls import EXAMPLES, PortUrl, parse
from axistwin.scenes.source import Source
from axistwin.scenes.tables import SceneFile, shared_lines
from axistwin.scenes.toml_places import Path


def check_ports(contents: SceneFile, source: Source) -> None:
    """Raise SceneError for the first invalid port of a scene, with its place in the file."""
    _check_shared(contents, source)
    taken: dict[tuple[str, ...], str] = {}
    for path, port, at_a_bus in _ports(contents, source):
        with source.placing_errors(*path):
            url = parse(port)
        if at_a_bus and url.scheme != "bus":
            raise source.error(
                f"{port} is not a port for an 1810 or 1811: expected a bus, e.g. {EXAMPLES['bus']}", path
            )
        if url.scheme == "bus" and not at_a_bus:
            raise source.error(
                f"{port} is a bus, not a port for a serial line: expected another kind of port, e.g. {EXAMPLES['tcp']}",
                path,
            )
        place = _place(url)
        if place in taken:
            raise source.error(f"{port} is the same port as {taken[place]}: expected a different port", path)
        if place:
            taken[place] = port


def _ports(contents: SceneFile, source: Source) -> Iterator[tuple[Path, str, bool]]:
    for number, table in enumerate(contents.controller):
        with source.placing_errors("controller", number, "model"):
            at_a_bus = product(table.model).attend is not None
        for key, urls in (("ports", table.ports), ("rs485_ports", table.rs485_ports)):
            for which, url in enumerate(urls):
                yield ("controller", number, key, which), url, at_a_bus
    for _, _, line, path in shared_lines(contents):
        for which, url in enumerate(line.ports):
            yield (*path, "ports", which), url, False


def _place(url: PortUrl) -> tuple[str, ...]:
    if url.scheme in ("pty", "serial"):
        return ("file", url.path) if url.path else ()
    return ("address", url.host.replace("localhost", "127.0.0.1"), str(url.port)) if url.port else ()


def _check_shared(contents: SceneFile, source: Source) -> None:
    for line_kind, name, line, _ in shared_lines(contents):
        for number, table in enumerate(contents.controller):
            key = "ports" if line_kind == "chain" else "rs485_ports"
            motor = table.called
            if motor in line.motors and getattr(table, key):
                raise source.error(
                    f"the key `{key}` is not permitted for motor {motor} on the shared line {name!r}: "
                    f"set the key `ports` in the table [[{line_kind}]] instead",
                    ("controller", number, key),
                )
