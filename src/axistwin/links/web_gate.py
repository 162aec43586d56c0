"""Which requests our web servers refuse: those that a page of another web site has made a browser send."""

from collections.abc import Callable
from ipaddress import ip_address


def is_loopback(host: str) -> bool:
    """True if a host name or an IP address belongs to the loopback interface."""
    if host == "localhost" or host.endswith(".localhost"):
        return True
    return is_address(host) and ip_address(host).is_loopback


def is_address(host: str) -> bool:
    """True for an IP address, which no web site can have as its name."""
    try:
        return bool(ip_address(host))
    except ValueError:
        return False


def refusal(header: Callable[[str], str | None], known: Callable[[str], bool], expected: str) -> str:
    """Return the reason for refusing a request by its headers; "" if the request is accepted.

    `known`: tests the requested host name, without its port.  A web site can give its own name the address of this
    computer; its pages then reach our servers under that name.  `expected`: the known names, in words.
    """
    host, origin = header("host") or "", header("origin")
    if not known(_name(host).lower()):
        return f"invalid host name {host!r}: expected {expected}"
    if origin is not None and origin.partition("://")[2] != host:
        return f"invalid origin {origin}: expected a request from this server's own page"
    elsewhere = header("sec-fetch-site") in ("cross-site", "same-site")
    if elsewhere and header("sec-fetch-mode") != "navigate":
        return "invalid Sec-Fetch-Site: expected a request from this server's own page"
    return ""


def _name(host: str) -> str:
    return host[1:].partition("]")[0] if host.startswith("[") else host.partition(":")[0]
