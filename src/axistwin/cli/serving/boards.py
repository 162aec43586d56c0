"""`axistwin boards`: list the connected motion boards."""

import json

import click
from serial.tools import list_ports

from axistwin.core.errors import LinkError
from axistwin.real.standin.sender import identify

KLIPPER_USB = 0x1D50  # USB vendor of boards with Klipper's firmware.
NOT_ASKED = "not asked, as it may be another device: name it to ask"


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("ports", metavar="[PORT]...", nargs=-1)
@click.option("--baud", default=250_000, show_default=True, metavar="N", help="Baud rate of the firmware.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def boards(ports: tuple[str, ...], baud: int, as_json: bool) -> int:
    """List serial ports, with the firmware data of the motion boards.

    Without PORT, only boards with Klipper's USB vendor number are asked: a request could move another device.
    The exit code is 1 if a named port has no board.

    \b
    axistwin boards
    axistwin boards /dev/ttyACM0
    axistwin boards /dev/ttyUSB0 --baud 115200 --json
    """
    found = [_ask(port, baud) for port in ports]
    if not ports:
        for port in list_ports.comports():
            asked = port.vid == KLIPPER_USB
            found.append(_ask(port.device, baud) if asked else {"port": port.device, "error": NOT_ASKED})
    if as_json:
        click.echo(json.dumps(found, indent=2))
    elif not found:
        click.echo("no serial ports: connect a board", err=True)
    for each in () if as_json else found:
        click.echo(f"{each['port']}: {each.get('error') or _line(each)}")
    return 1 if ports and any("error" in each for each in found) else 0


def _ask(port: str, baud: int) -> dict[str, object]:
    try:
        dictionary = identify(port, baud)
    except LinkError as error:
        return {"port": port, "error": str(error)}
    return {
        "port": port, "mcu": dictionary.constants.get("MCU"), "firmware": dictionary.version,
        "clock_hz": dictionary.constants.get("CLOCK_FREQ"), "pins": list(dictionary.pins),
    }  # fmt: skip


def _line(each: dict[str, object]) -> str:
    pins = each["pins"]
    assert isinstance(pins, list), "pins are a list"
    return f"{each['mcu']}, firmware {each['firmware']}, clock {each['clock_hz']} Hz, {len(pins)} pins"
