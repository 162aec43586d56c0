"""Lines of code that connect usual hosts to a port: pyserial, PyVISA, EPICS asyn, and C for a board on a bus."""

import socket
from collections.abc import Iterator
from dataclasses import replace

from axistwin.bus_hosts import C_FILES
from axistwin.links.urls import PortUrl
from axistwin.sim.frames import UartFormat

ANY_ADDRESS = ("0.0.0.0", "::")  # noqa: S104  nothing is bound here


def lines(name: str, url: PortUrl, line: UartFormat) -> Iterator[str]:
    """Yield examples of code that connects a host program to a controller, e.g. a line for pyserial.

    `url`: port of the controller.  `line`: format of the host's serial line.
    """
    if url.host in ANY_ADDRESS:
        url = replace(url, host=socket.gethostname())
    match url.scheme:
        case "tcp":
            yield from _tcp(name, url)
        case "rfc2217":
            yield from _rfc2217(name, url, line)
        case "pty":
            yield from _pty(name, url, line)
        case _:
            baudrate = url.baud or line.baudrate
            yield f"set the host at the other end of the cable to {baudrate} baud, {line.bytesize} data bits,"
            yield f"parity {line.parity}, {line.stopbits:g} stop bits"


def bus(url: PortUrl) -> Iterator[str]:
    """Yield lines that show how to access the bus of a board: by hand in a shell, or from a C program.

    `url`: the address of the bus.
    """
    if url.host in ANY_ADDRESS:
        url = replace(url, host=socket.gethostname())
    yield f"by hand   nc {url.host} {url.port}     then: r 1"
    yield f"C         cc -I{C_FILES} HOST.c {C_FILES / 'axistwin_bus.c'} -o host"
    yield f"          AXISTWIN_BUS={url.address} ./host"


def _tcp(name: str, url: PortUrl) -> Iterator[str]:
    yield f'pyserial  serial.serial_for_url("socket://{url.address}", timeout=2)'
    yield f'PyVISA    pyvisa.ResourceManager().open_resource("TCPIP0::{url.host}::{url.port}::SOCKET", {_ENDS})'
    yield f'asyn      drvAsynIPPortConfigure("{name}", "{url.address}", 0, 0, 0)'
    yield from _asyn_ends(name)


def _rfc2217(name: str, url: PortUrl, line: UartFormat) -> Iterator[str]:
    yield f'pyserial  serial.serial_for_url("rfc2217://{url.address}", {_pyserial(line)}, timeout=2)'
    yield "PyVISA    not supported: use a TCP port or a pty"
    yield f'asyn      drvAsynIPPortConfigure("{name}", "{url.address} COM", 0, 0, 0)'
    yield from _asyn_format(name, line)
    yield from _asyn_ends(name)


def _pty(name: str, url: PortUrl, line: UartFormat) -> Iterator[str]:
    yield f'pyserial  serial.Serial("{url.path}", {_pyserial(line)}, timeout=2)'
    stop_bits = {1: "one", 1.5: "one_and_a_half", 2: "two"}[line.stopbits]
    yield (
        f'PyVISA    pyvisa.ResourceManager().open_resource("ASRL{url.path}::INSTR", baud_rate={line.baudrate}, '
        f"stop_bits=pyvisa.constants.StopBits.{stop_bits}, {_ENDS})"
    )
    yield f'asyn      drvAsynSerialPortConfigure("{name}", "{url.path}", 0, 0, 0)'
    yield from _asyn_format(name, line)
    yield from _asyn_ends(name)


_ENDS = r'read_termination="\r", write_termination="\r"'


def _pyserial(line: UartFormat) -> str:
    return f'baudrate={line.baudrate}, bytesize={line.bytesize}, parity="{line.parity}", stopbits={line.stopbits:g}'


def _asyn_format(name: str, line: UartFormat) -> Iterator[str]:
    parity = {"N": "none", "E": "even", "O": "odd", "M": "mark", "S": "space"}[line.parity]
    options = {"baud": line.baudrate, "bits": line.bytesize, "parity": parity, "stop": f"{line.stopbits:g}"}
    for key, value in options.items():
        yield f'          asynSetOption("{name}", 0, "{key}", "{value}")'


def _asyn_ends(name: str) -> Iterator[str]:
    yield rf'          asynOctetSetInputEos("{name}", 0, "\r")'
    yield rf'          asynOctetSetOutputEos("{name}", 0, "\r")'
