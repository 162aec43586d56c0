"""Lines of code that connect usual hosts to a port: pyserial, PyVISA, EPICS asyn, and C for a board on a bus."""

import socket
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from shlex import quote

from axistwin.links.bus_hosts import C_FILES
from axistwin.links.urls import PortUrl
from axistwin.sim.frames import UartFormat

ANY_ADDRESS = ("0.0.0.0", "::")  # noqa: S104  nothing is bound here


def lines(name: str, url: PortUrl, line: UartFormat, ends: tuple[bytes, bytes] = (b"\r", b"\r")) -> Iterator[str]:
    """Yield code that connects a host, e.g. by pyserial, to the port `url` with the format `line`.

    `ends`: terminators of requests and of answers; b"" for datagrams.
    """
    url, (out, back) = _reachable(url), (repr(end)[2:-1] for end in ends)
    match url.scheme:
        case "tcp":
            yield from _tcp(name, url, out, back)
        case "rfc2217":
            yield from _rfc2217(name, url, line, out, back)
        case "pty":
            yield from _pty(name, url, line, out, back)
        case _:
            baudrate = url.baud or line.baudrate
            yield f"set the host at the other end of the cable to {baudrate} baud, {line.bytesize} data bits,"
            yield f"parity {line.parity}, {line.stopbits:g} stop bits"


def bus(url: PortUrl) -> Iterator[str]:
    """Yield lines that show how to access the bus of a board by hand in a shell, and from a C program."""
    url = _reachable(url)
    yield f"by hand   nc {url.host} {url.port}     then: r 1"
    yield f"C         cc -I{quote(str(C_FILES))} HOST.c {quote(str(C_FILES / 'axistwin_bus.c'))} -o host"
    yield f"          AXISTWIN_BUS={url.host}:{url.port} ./host"


def _reachable(url: PortUrl) -> PortUrl:
    """Return the URL with a name of this computer instead of "all addresses", and an absolute path."""
    if url.scheme == "pty":
        return replace(url, path=str(Path(url.path).absolute()))
    if url.host not in ANY_ADDRESS:
        return url
    name = socket.gethostname()
    try:
        socket.getaddrinfo(name, url.port, socket.AF_INET)
    except OSError:
        name = "127.0.0.1"
    return replace(url, host=name)


def _tcp(name: str, url: PortUrl, out: str, back: str) -> Iterator[str]:
    yield f'pyserial  serial.serial_for_url("socket://{url.address}", timeout=2)'
    if ":" in url.host:
        yield f"PyVISA    not supported at {url.host}: use an IPv4 address, e.g. --tcp 127.0.0.1:{url.port}"
        yield f"asyn      not supported at {url.host}: use an IPv4 address"
        return
    where, ends = f"TCPIP0::{url.host}::{url.port}::SOCKET", _visa_ends(out, back)
    yield f'PyVISA    pyvisa.ResourceManager().open_resource("{where}", {ends})'
    yield f'asyn      drvAsynIPPortConfigure("{name}", "{url.address}", 0, 0, 0)'
    yield from _asyn_ends(name, out, back)


def _rfc2217(name: str, url: PortUrl, line: UartFormat, out: str, back: str) -> Iterator[str]:
    yield f'pyserial  serial.serial_for_url("rfc2217://{url.address}", {_pyserial(line)}, timeout=2)'
    yield "PyVISA    not supported: use a TCP port or a pty"
    if ":" in url.host:
        yield f"asyn      not supported at {url.host}: use an IPv4 address, e.g. --rfc2217 127.0.0.1:{url.port}"
        return
    yield f'asyn      drvAsynIPPortConfigure("{name}", "{url.address} COM", 0, 0, 0)'
    yield from _asyn_format(name, line)
    yield from _asyn_ends(name, out, back)


def _pty(name: str, url: PortUrl, line: UartFormat, out: str, back: str) -> Iterator[str]:
    path = url.path.replace("\\", r"\\").replace('"', r"\"")
    yield f'pyserial  serial.Serial("{path}", {_pyserial(line)}, timeout=2)'
    stop_bits = {1: "one", 1.5: "one_and_a_half", 2: "two"}[line.stopbits]
    yield (
        f'PyVISA    pyvisa.ResourceManager().open_resource("ASRL{path}::INSTR", baud_rate={line.baudrate}, '
        f"stop_bits=pyvisa.constants.StopBits.{stop_bits}, {_visa_ends(out, back)})"
    )
    yield f'asyn      drvAsynSerialPortConfigure("{name}", "{path}", 0, 0, 0)'
    yield from _asyn_format(name, line)
    yield from _asyn_ends(name, out, back)


def _visa_ends(out: str, back: str) -> str:
    return f"read_termination={_quoted(back)}, write_termination={_quoted(out)}"


def _quoted(end: str) -> str:
    return f'"{end}"' if end else "None"


def _pyserial(line: UartFormat) -> str:
    return f'baudrate={line.baudrate}, bytesize={line.bytesize}, parity="{line.parity}", stopbits={line.stopbits:g}'


def _asyn_format(name: str, line: UartFormat) -> Iterator[str]:
    parity = {"N": "none", "E": "even", "O": "odd", "M": "mark", "S": "space"}[line.parity]
    options = {"baud": line.baudrate, "bits": line.bytesize, "parity": parity, "stop": f"{line.stopbits:g}"}
    for key, value in options.items():
        yield f'          asynSetOption("{name}", 0, "{key}", "{value}")'


def _asyn_ends(name: str, out: str, back: str) -> Iterator[str]:
    yield f'          asynOctetSetInputEos("{name}", 0, "{back}")'
    yield f'          asynOctetSetOutputEos("{name}", 0, "{out}")'
