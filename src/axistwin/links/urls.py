"""Ports as URLs, in the style of pyserial.

tcp://127.0.0.1:5001        raw TCP; port 0: any free port
rfc2217://127.0.0.1:2217    TCP with line format, control lines and break (RFC 2217); ?cts=dtr: the client's CTS is the
                            device's DTR, as on the 5-wire cable for hosts that do not use DSR
pty:/tmp/if1                a pseudo terminal with a symbolic link at this path; `pty:` alone creates no link
bus://127.0.0.1:1811        the registers of a board on a bus, one text line per access (`links/bus.py`)
serial:///dev/ttyUSB0?baud=9600    a real serial device, on which axistwin is the controller
"""

from dataclasses import dataclass

from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, whole

LOOPBACK = "127.0.0.1"
EXAMPLES = {
    "tcp": "tcp://127.0.0.1:5001", "rfc2217": "rfc2217://127.0.0.1:2217", "bus": "bus://127.0.0.1:1811",
    "pty": "pty:/tmp/if1", "serial": "serial:///dev/ttyUSB0?baud=9600",
}  # fmt: skip


@dataclass(frozen=True)
class PortUrl:
    """The URL of a port: an address for `tcp`, `rfc2217` and `bus`, a path for `pty` and `serial`."""

    scheme: str
    host: str = ""
    port: int = 0
    path: str = ""
    baud: int | None = None
    cts: str = "rts"  # The device's output that an `rfc2217` client sees as CTS: "rts" or "dtr".

    def __str__(self) -> str:
        if self.scheme in ("tcp", "rfc2217", "bus"):
            return f"{self.scheme}://{self.address}" + ("?cts=dtr" if self.cts == "dtr" else "")
        if self.scheme == "pty":
            return f"pty:{self.path}"
        return f"serial://{self.path}" + ("" if self.baud is None else f"?baud={self.baud}")

    @property
    def address(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


def parse(text: str) -> PortUrl:
    """Parse the URL of a port, e.g. `tcp://127.0.0.1:5001`.  Raises UsageError for an invalid URL."""
    scheme, colon, rest = text.partition(":")
    if "\0" in text:
        raise UsageError(f"invalid port URL {text!r}: expected a URL without NUL characters, e.g. tcp://127.0.0.1:5001")
    if scheme not in EXAMPLES or not colon:
        raise UsageError(f"invalid port URL {text!r}: expected SCHEME:ADDRESS, e.g. {', '.join(EXAMPLES.values())}")
    rest = rest.removeprefix("//")
    if scheme == "pty":
        return PortUrl("pty", path=rest)
    return _serial(rest, text) if scheme == "serial" else _network(scheme, rest, text)


def parse_as(scheme: str, text: str) -> PortUrl:
    """Parse the value of an option such as `--tcp 127.0.0.1:5001`.

    The name of the option is the scheme of the URL; the value may be a whole URL, as messages and `listening on` have.
    """
    before = f"{scheme}:" if scheme == "pty" else f"{scheme}://"
    return parse(f"{before}{text.removeprefix(before)}")


def _network(scheme: str, rest: str, text: str) -> PortUrl:
    address, _, query = rest.partition("?")
    host, _, number = address.rpartition(":")
    port = _number(number)
    if port is None or port > 0xFFFF:
        raise UsageError(f"invalid address {text!r}: expected ADDRESS:PORT, e.g. {EXAMPLES[scheme]}")
    if query not in (("", "cts=rts", "cts=dtr") if scheme == "rfc2217" else ("",)):
        raise UsageError(f"invalid option {query!r} in {text!r}: expected ?cts=dtr for rfc2217, or no option")
    return PortUrl(scheme, host.strip("[]") or LOOPBACK, port, cts="dtr" if query == "cts=dtr" else "rts")


def _serial(rest: str, text: str) -> PortUrl:
    path, _, query = rest.partition("?")
    key, _, baud = query.partition("=")
    rate = _number(baud)
    if not path or (query and not (key == "baud" and rate)):
        raise UsageError(f"invalid serial device {text!r}: expected PATH?baud=RATE, e.g. {EXAMPLES['serial']}")
    return PortUrl("serial", path=path, baud=rate if query else None)


def _number(text: str) -> int | None:
    try:
        return whole(text, 0) if text.isdecimal() else None
    except NumberError:
        return None
