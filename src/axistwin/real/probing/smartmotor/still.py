"""Commands of the SmartMotor that cannot move anything, by the command table; and the form of a case."""

from axistwin.controllers.smartmotor.language.forms import Form, Instruction
from axistwin.controllers.smartmotor.language.language import read
from axistwin.real.probing.cases import Case

CR = b"\r"
BUFFERED = ("A=", "V=", "P=", "KP=", "KI=", "KD=", "KL=", "KS=", "KV=", "KA=", "KG=", "MFMUL=", "MFDIV=", "BASE=",
            "SIZE=", "SLN=", "SLP=", "T=", "CLK=")  # fmt: skip
"""Settings that take effect only at the next G, F, MT or SLE, and the counter of samples."""
DATA = ("a…zzz=", "ab[]=", "aw[]=", "al[]=", "EPTR=", "VLD()", "VST()", "Zd", "Zu", "Zs", "Zb", "Zc", "Zf")
"""Variables, the data EEPROM, and flags that do not prevent motion."""
FLOW = ("Cn", "GOTOn", "GOSUBn", "RETURN", "STACK", "IF", "ELSEIF", "ELSE", "ENDIF", "WHILE", "LOOP", "SWITCH", "CASE",
        "DEFAULT", "BREAK", "ENDS", "END", "RUN", "RUN?", "WAIT=", "TWAIT", "!")  # fmt: skip
"""Program flow without interrupts and without the total reset Z."""
SERIAL = ("SADDRn", "ECHO", "ECHO_OFF", "SLEEP", "WAKE", "SILENT", "TALK", "BAUDn", "OCHN()", "CCHN()", "Q",
          "PRINT()", "AOUTp", "DOUTp", "LOAD", "UPLOAD", "UP", "LOCKP", "RCKS")  # fmt: skip
"""Communications on channel 0, and the transfer of programs."""
STILL = frozenset((*BUFFERED, *DATA, *FLOW, *SERIAL))
WIRED = "RS4"  # Type of a channel that makes pin G an output.


def report(command: Instruction) -> bool:
    reports = command.form in (Form.REPORT_VARIABLE, Form.REPORT_ARRAY) or command.form is Form.BARE
    others = ("RETURN", "RETURNF", "RETURNI", "RUN", "RUN?", "RI", "RS2", "RS4")
    return reports and str(command.code).startswith("R") and command.code not in others


def still(text: str) -> bool:
    """Return True if a command never moves the motor (whitelist `STILL`); invalid text only sets Bs."""
    statement = read(text)
    if statement.problem is not None or statement.command is None:
        return True
    return (statement.command.code in STILL and WIRED not in text) or report(statement.command)


def words(text: str) -> list[str]:
    """Split a line into its commands.  A keyword such as IF stays together with its expression."""
    found: list[str] = []
    for word in text.split():
        if found and found[-1] in ("IF", "ELSEIF", "WHILE", "SWITCH", "CASE"):
            found[-1] += f" {word}"
        elif word:
            found.append(word)
    return found


def case(
    name: str, section: str, *lines: str | bytes, moves: bool = False, wait_s: float = 0.0,
    waits: tuple[tuple[int, float], ...] = (), bare: bool = False, stores: bool = False, depends: bool = False,
) -> Case:  # fmt: skip
    """Return a test case that sends lines of commands (str) or raw characters (bytes).

    CR is added to each line of commands.  The test case moves if a command is not in the whitelist.
    """
    says = tuple(line if isinstance(line, bytes) else line.encode() + CR for line in lines)
    told = [line for line in lines if isinstance(line, str) and "aw[0] " not in line]
    stays = all(still(word) for line in told for word in words(line))
    return Case(
        name, section, says, moves=moves or bare or not stays, writes=True, wait_s=wait_s, waits=waits, bare=bare,
        stores=stores, depends=depends,
    )  # fmt: skip
