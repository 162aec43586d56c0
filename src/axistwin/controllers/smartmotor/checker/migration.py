"""The checker's rules for programs that were written for firmware 4.15 or 4.40: changes in 4.76.

The parser finds removed commands and assignments without an equal sign.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet

from axistwin.controllers.diagnostics import fixing, put_before
from axistwin.controllers.smartmotor import rules
from axistwin.controllers.smartmotor.chapters.functions import CALL_C1, REVERSE
from axistwin.controllers.smartmotor.checker.findings import Findings, constant_value
from axistwin.controllers.smartmotor.checker.flow import Flow

MOTION = ("G", "MT", "MF1", "MF2", "MF4", "MS")
PLUS, MINUS = {"UCI", "UCO"}, {"UDI", "UDO"}  # End a limit input; UCP and UDM say that a switch is there.
CLEARING = {"UCI": {"ZS", "Zr"}, "UDI": {"ZS", "Zl"}}
BRAKE_PINS = {"BRKC": "C", "BRKG": "G"}


def check(findings: Findings) -> None:
    _limits(findings, Flow(findings))
    _direction(findings)
    _faults_end_programs(findings)
    _soft_limits(findings)
    for command, pin in BRAKE_PINS.items():
        _brake(findings, command, pin)


def _limits(findings: Findings, flow: Flow) -> None:
    """Warn if limit faults may prevent a motion that the program commands.

    Unconnected limit inputs cause a fault at power-up.  The program must clear this fault, e.g. with ZS, after it has
    given the pins another role (manual, sections 2.0 and 3.1).  The warning is at the first motion command.  The limit
    faults at power-up do not call C1, and no host has sent a command before the first motion of the program itself.  A
    motion that only a host can call comes after everything else.
    """
    order = flow.order()
    moves = next((number for number in order if findings.words[number] in MOTION), None)
    if moves is not None:
        given = [findings.words[number] for number in order[: order.index(moves)]]
    elif called := next(findings.all(*MOTION), None):
        moves, given = called[0], findings.words
    else:
        return
    silent = [role for role, words in (("UCI", {"UCP", *PLUS}), ("UDI", {"UDM", *MINUS})) if words.isdisjoint(given)]
    if silent:
        _unwired(findings, moves, silent)
    elif any(_uncleared(given, words, CLEARING[role]) for role, words in (("UCI", PLUS), ("UDI", MINUS))):
        message = "the limit faults of power-up are not cleared: ZS (or Zr and Zl) is missing behind UCI and UDI"
        clearing = fixing("clear them with ZS", put_before(findings.text(moves)[0], "ZS "), sure=False)
        findings.report(rules.LIMIT_FAULTS, moves, message, clearing)


def _unwired(findings: Findings, number: int, silent: Sequence[str]) -> None:
    pins, better = " and ".join(role[1] for role in silent), " ".join((*silent, "ZS"))
    several = len(silent) > 1
    message = (
        f"limits are active high since 4.76: unless {'' if several else 'a '}normally closed "
        f"{'switches pull' if several else 'switch pulls'} {pins} to ground nothing moves; "
        f"{better} at the top makes {'them ordinary inputs' if several else 'it an ordinary input'}"
    )
    fix = fixing(f"write {better} at the top", put_before(findings.text(0)[0], f"{better} "), sure=False)
    findings.report(rules.LIMITS, number, message, fix)


def _uncleared(given: Sequence[str], roles: AbstractSet[str], clearing: AbstractSet[str]) -> bool:
    begun = next((number for number, word in enumerate(given) if word in roles), None)
    return begun is not None and clearing.isdisjoint(given[begun:])


def _direction(findings: Findings) -> None:
    """Report F=2, which concerned scan errors before 4.76 (1.4)."""
    for number, statement in findings.all("F="):
        if (constant_value(statement) or 0) & REVERSE:
            message = "F=2 reverses the shaft's direction since 4.76; before, it let scan errors be sent to the host"
            findings.report(rules.DIRECTION, number, message)


def _faults_end_programs(findings: Findings) -> None:
    """Report tests of Be and Bh: such a fault ends the program, unless F=32 calls C1 (4.1)."""
    if findings.sets_function(CALL_C1):
        return
    for number in range(len(findings.statements)):
        tested = [name for part in findings.statements[number].computed for name in part.names if name in ("Be", "Bh")]
        if tested and findings.words[number] in ("IF", "ELSEIF", "WHILE"):
            message = (
                f"when {tested[0]} becomes 1 the program ends since 4.76; F=32 and label C1 let the program continue"
            )
            findings.report(rules.ENDS_PROGRAM, number, message)


def _soft_limits(findings: Findings) -> None:
    """Report changes of enabled software limits: SLD must come first (3.2)."""
    enabled = -1
    for number, keyword in enumerate(findings.words):
        if keyword == "SLE":
            enabled = number
        elif keyword == "SLD":
            enabled = -1
        elif keyword in ("SLN=", "SLP=") and enabled >= 0:
            message = (
                f"software limits are enabled in line {findings.line(enabled)}: SLD before their values are changed"
            )
            findings.report(rules.SOFT_LIMITS, number, message)


def _brake(findings: Findings, command: str, pin: str) -> None:
    """Report a brake pin that is not an output, or that the program later uses otherwise (5.1).

    BRKI, BRKC and BRKG are mutually exclusive: another one of them ends the use of the pin.
    """
    begun = next(findings.all(command), None)
    if begun is None:
        return
    if f"U{pin}O" not in findings.words[: begun[0]]:
        output = fixing(f"make pin {pin} an output", put_before(findings.text(begun[0])[0], f"U{pin}O "), sure=False)
        findings.report(rules.BRAKE_PIN, begun[0], f"U{pin}O must be given before {command}", output)
    disturbing = {f"U{pin}I", f"U{pin}=", *({"RS4", "OCHN()"} if pin == "G" else ())}
    since: int | None = None
    for number, keyword in enumerate(findings.words):
        if keyword in ("BRKI", *BRAKE_PINS):
            since = number if keyword == command else None
        taken = {name for part in findings.statements[number].computed for name in part.taken}
        if since is not None and (keyword in disturbing or not taken.isdisjoint({f"U{pin}", f"U{pin}I"})):
            findings.report(rules.BRAKE_USED, number, f"the brake uses pin {pin} since line {findings.line(since)}")
