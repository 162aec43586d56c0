"""The address of a panel, which a program can check without loading the web framework."""

import secrets
import socket
from dataclasses import dataclass

from axistwin.core.errors import LinkError, UsageError, reason
from axistwin.core.numbers import NumberError, shortened, whole
from axistwin.links.urls import LOOPBACK
from axistwin.links.web_gate import is_loopback


@dataclass(frozen=True)
class Address:
    """Host and port of the panel.  `token`: required from browsers; None: not required."""

    host: str
    port: int
    token: str | None

    @staticmethod
    def read(text: str, token: str | None) -> "Address":
        """Parse the address of a panel, e.g. `8080`, `0.0.0.0:8080` or `[::1]:8080`.

        If the host is not a loopback host and no token is given, the address has a random token.  Raises UsageError.
        """
        host, _, number = text.rpartition(":")
        try:
            port = whole(number, 0, 0xFFFF)
        except NumberError:
            raise UsageError(
                f"invalid panel address {shortened(text)}: expected PORT or HOST:PORT, e.g. 8080"
            ) from None
        host = host.strip("[]") or LOOPBACK
        if token is not None and not (token.isascii() and token.isprintable() and token.isalnum()):
            raise UsageError(
                "invalid --panel-token: expected letters and digits only, because the token is part of the panel's URL"
            )
        return Address(host, port, token or (None if is_loopback(host) else secrets.token_urlsafe(16)))


def listening_socket(address: Address) -> socket.socket:
    """Return a socket that listens at the address.  Raises LinkError if another program uses the address."""
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    try:
        sock = socket.create_server((address.host, address.port), family=family)
    except OSError as error:
        raise LinkError(
            f"cannot show a panel on {address.host}:{address.port}: {reason(error)}; "
            "choose another port, or port 0 for any free port"
        ) from None
    # Without the option TCP_NODELAY, messages to the browser would arrive 40 ms late.
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return sock
