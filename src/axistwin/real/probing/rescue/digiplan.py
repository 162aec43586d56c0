"""Reading of an IF1 or IF2: the answers to its status requests.  No request lists the sequence or a setting."""

from axistwin.bench import Bench
from axistwin.bench.programs.command_lines import READY_S, SELF_TEST_S, greeting
from axistwin.core.errors import LinkError
from axistwin.real.hosts.exchange import Exchange
from axistwin.real.probing.rescue.contents import Contents, Reader, Restoring

SPOIL = b"~"  # An unknown character: a message with this character has no effect but the data fault bit.
TERMINATORS = {b"\r": "U", b"\n": "V"}  # First letter of the data format message by the terminator of messages.
FRAMES = {(7, 1): 1, (7, 2): 2, (8, 1): 5, (8, 2): 6}  # First digit of the data format message by data and stop bits.
SHORT_S = 0.2  # Silence after which no answer is expected any more.
IN_MOTION, LOCKED = 1, "["
BUSY_LETTERS = ("C", "E", "F", LOCKED)
INPUTS = {
    1: "estop", 2: "x_fault", 4: "y_fault", 8: "input1", 16: "limit_plus", 32: "limit_minus", 64: "input2",
    128: "input3",
}  # fmt: skip
"""Terminals by their bit in the answer to I."""
HIGH_WITHOUT_CURRENT = ("x_fault", "y_fault")
MISSING = (
    "sequence: no request lists it; it is in the program of the host, or in a recording by `axistwin record`",
    "speed, distance, start/stop speed, acceleration, range, backlash, delay: no request reports them",
    "outputs: no request reports them",
)
LINE_OR_RESTART = "--line; if --line is correct, switch the interface off and on, and send a data format, e.g. U61"


def read(exchange: Exchange) -> Contents:
    """Read all status requests.  Raises LinkError if the interface is silent or a motor moves."""
    end = terminator(exchange, SHORT_S)
    if end is None and exchange.heard:
        raise LinkError(
            f"the interface answers request E with {exchange.heard!r}: expected C, E, F or [ and CR; "
            f"check {LINE_OR_RESTART}"
        )
    if end is None:
        raise LinkError(f"the interface does not answer request E: check {LINE_OR_RESTART}")
    found = Contents(depends=set("FKQNOE"), missing=list(MISSING))
    found.values["format"] = _format(exchange, end)
    for request in "FIONEK":  # Request F comes first, because F clears the data fault bit of the interface.
        found.values[request] = exchange.needed(request.encode() + end, LINE_OR_RESTART)
    found.values["Q"] = exchange.ask(b"Q" + end, complete=bool).hex().upper()
    answer = found.values["K"]
    if not answer.isdigit():
        raise LinkError(
            f"the answer to request K (motion status) is {answer!r}: "
            "expected a number; a wrong line format garbles answers, so check --line"
        )
    if int(answer) & IN_MOTION:
        raise LinkError("the motor is moving: stop the motor, then run axistwin rescue again")
    if found.values["E"] == LOCKED:
        found.missing.append("lock: the interface is locked; an IF2 keeps its sequence without power")
    return found


def terminator(exchange: Exchange, patience_s: float) -> bytes | None:
    """Return the terminator, CR or LF, and set `exchange.echo`; None without an answer."""
    for end in TERMINATORS:
        said = SPOIL + end
        exchange.echo, exchange.terminator = False, end
        exchange.echo = exchange.ask(said, complete=said.__eq__, patience_s=patience_s).endswith(said)
        letter = exchange.line(b"E" + end, patience_s)
        # With a wrong parity, the interface rejects at least one of the two requests E and N.
        if letter in BUSY_LETTERS and exchange.line(b"N" + end, patience_s).isdigit():
            return end
    return None


def _format(exchange: Exchange, end: bytes) -> str:
    line = exchange.line_format
    x2 = {"N": 2, "O": 5, "E": 6} if exchange.echo else {"N": 1, "O": 3, "E": 4}
    return f"{TERMINATORS[end]}{FRAMES[line.bytesize, int(line.stopbits)]}{x2[line.parity]}"


def restore(contents: Contents, new: Contents) -> Restoring:
    changed = int(contents.values["I"]) ^ int(new.values["I"])
    now = int(contents.values["I"])
    return Restoring(
        actions=[
            f"{name} {'high' if bool(now & bit) is (name in HIGH_WITHOUT_CURRENT) else 'low'}"
            for bit, name in INPUTS.items()
            if changed & bit
        ]
    )


def start(bench: Bench, contents: Contents) -> None:
    (controller,) = bench.controllers.values()
    port = controller.serial
    wanted = port.host.format
    port.host.format, _ = greeting(wanted)
    bench.run(SELF_TEST_S)
    port.write(b"(")
    bench.run(READY_S)
    text = contents.values["format"]
    port.write(text.encode() + (b"\r" if text[0] == "U" else b"\n"))
    bench.run(READY_S)
    port.host.format = wanted


READER = Reader(read, restore, start)
