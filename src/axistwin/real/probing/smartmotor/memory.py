"""Program storage, program flow and the data EEPROM: programs that move nothing, and their contents restored.

Each program ends at RUN? if it is started by power-up, so that a program that is left behind does nothing.
"""

import re
from collections.abc import Mapping

from axistwin.controllers.smartmotor.language.forms import Instruction
from axistwin.core.errors import LinkError
from axistwin.real.hosts.end import End
from axistwin.real.probing.cases import Case, Condition
from axistwin.real.probing.smartmotor.still import CR, case, still

BLOCK = 8
ACKNOWLEDGE, END_OF_PROGRAM = b"\x06", b"\xff\xff "
LINE = "9600 8N1"  # Line format for which the programs change and restore the settings of channel 0.
AT, USED = 7900, 12  # First byte and number of bytes of the data EEPROM that the cases write.
SAVED = (*"abcdefghijklmnopqrz", *(f"al[{index}]" for index in (*range(6), 25, 26, 50)), "zzz")
"""Variables whose values are restored: those that the cases change."""
CONTENTS = {"000000 000000": "", "000000 0000E1": "END\n"}  # May be overwritten, by their sums: none, and END.
FLOW = """\
PRINT("boot",#13)
RUN?
PRINT("run",#13)
END
C10
b=1
GOSUB11
b=b*10+3
RETURN
C11
b=b*10+2
RETURN
C12
WHILE c<5
c=c+1
IF c==2
d=d+1
ELSEIF c==3
d=d+10
ELSE
d=d+100
ENDIF
IF c==4
BREAK
ENDIF
LOOP
RETURN
C13
SWITCH e
CASE 1
f=f+1
CASE 2
f=f+10
BREAK
CASE 3
f=f+100
DEFAULT
f=f+1000
ENDS
RETURN
C14
g=1
GOTO15
g=2
RETURN
C15
g=g+10
RETURN
C16
STACK
h=1
RETURN
h=2
END
C17
PRINT("w",#13)
WAIT=163
PRINT("x",#13)
RETURN
C18
!
PRINT("y",#13)
RETURN
C19
CLK=0
RCLK
RETURN
C20
j=j+1
GOSUB20
RETURN
C21
k=k+1
GOTO21
C22
SILENT
PRINT("s",#13)
TALK
PRINT("t",#13)
RETURN
C23
h=5
END
C24
m=CLK
n=1
n=2
n=3
n=4
n=5
n=6
n=CLK-m
RETURN
C25
PRINT("p",#13)
RETURN
C26
TWAIT
PRINT("q",#13)
RETURN
C27
WAIT=2035
RETURN
"""
CHANNEL = """\
RUN?
END
C30
BAUD19200
WAIT=2035
BAUD9600
RETURN
C31
OCHN(RS2,0,E,9600,1,8,C)
WAIT=2035
OCHN(RS2,0,N,9600,1,8,C)
RETURN
C32
OCHN(RS2,0,N,9600,1,8,D)
WAIT=2035
o=LEN
p=GETCHR
q=GETCHR
OCHN(RS2,0,N,9600,1,8,C)
RETURN
C33
CCHN(RS2,0)
WAIT=2035
OCHN(RS2,0,N,9600,1,8,C)
RETURN
"""
ADDRESS_ALL = b"\x80\r"
CHANNEL_S = 0.6  # Time after which a WAIT=2035 has ended, and a program of `CHANNEL` has restored the channel.


def loading(program: str) -> tuple[bytes, ...]:
    data = program.encode("latin-1")
    return b"LOAD ", *(data[at : at + BLOCK] for at in range(0, len(data), BLOCK)), END_OF_PROGRAM


def sending(command: str, size: int) -> tuple[bytes, ...]:
    """Return the requests that read `size` bytes: a command, then an acknowledgement for each block."""
    return command.encode() + CR, *((ACKNOWLEDGE,) * (size // BLOCK))


def loaded(name: str, section: str, program: str, *lines: str | bytes, bare: bool = False, moves: bool = False) -> Case:
    """Return a test case that loads a program into the motor, then sends lines of commands."""
    stays = all(still(line) for line in program.splitlines())
    return case(
        name, section, *loading(program), "RCKS", "RBk", *lines, moves=moves or not stays, bare=bare, stores=True
    )  # fmt: skip


def stored(commands: Mapping[str, Instruction], line: str) -> list[Case]:
    return [*_eeprom(commands), *_flow(commands), *(_channel(commands) if line == LINE else ())]


def _eeprom(commands: Mapping[str, Instruction]) -> list[Case]:
    section = commands["VST()"].chapter

    def kept(name: str, *lines: str) -> Case:
        return case(name, section, f"Zs EPTR={AT}", *lines, stores=True)

    return [
        kept("two variables", "a=11 b=-22 VST(a,2)", "REPTR", f"a=0 b=0 EPTR={AT}", "VLD(a,2)", "Ra Rb REPTR RBs"),
        kept("bytes, words and longs", "ab[0]=1 ab[1]=-2 ab[2]=3 VST(ab[0],3)", "REPTR",
             "aw[3]=-300 aw[4]=301 VST(aw[3],2)",
             "REPTR", "al[5]=70000 VST(al[5],1)", "REPTR", "al[0]=0 al[1]=0 al[2]=0 al[5]=0", f"EPTR={AT} VLD(ab[0],3)",
             "VLD(aw[3],2)", "VLD(al[5],1)", "Rab[0] Rab[1] Rab[2] Raw[3] Raw[4] Ral[5] REPTR",
             "al[0]=0 al[1]=0 al[2]=0 al[5]=0"),
        kept("the most significant byte first", "a=16909060 VST(a,1)", f"EPTR={AT} VLD(ab[0],4)",
             "Rab[0] Rab[1] Rab[2] Rab[3] al[0]=0"),
        kept("beyond a group", "VST(z,2)", "RBs REPTR", "Zs VLD(z,2)", "RBs REPTR", "Zs VST(ab[203],2)", "RBs Zs"),
        kept("beyond the memory", "EPTR=7997 VST(a,1)", "RBs REPTR", "Zs EPTR=7996 VLD(a,1)", "RBs", "Zs"),
        kept("no variables", "VST(a,0)", "RBs REPTR", "Zs VLD(P,1)", "RBs REPTR Zs"),
    ]  # fmt: skip


def _flow(commands: Mapping[str, Instruction]) -> list[Case]:
    storage, section = commands["LOAD"].chapter, commands["GOSUBn"].chapter

    def called(name: str, *lines: str | bytes, code: str = "", waits: tuple[tuple[int, float], ...] = ()) -> Case:
        chapter = commands[code].chapter if code else section
        return case(name, chapter, *lines, stores=True, waits=waits)

    return [
        loaded("load a program", storage, FLOW),
        called("upload the program", *sending("UPLOAD", len(FLOW)), b"RBk\r", code="UPLOAD"),
        called("upload the image", *sending("UP", 160), b"RSP\r", code="UP"),
        called("RUN and RUN?", "RUN", "RUN", "RBs"), called("a subroutine in a subroutine", "Zs GOSUB10", "Rb RBs"),
        called("WHILE, IF, BREAK", "c=0 d=0 GOSUB12", "Rc Rd RBs"),
        *(called(f"SWITCH with {value}", f"e={value} f=0 GOSUB13", "Rf") for value in (1, 2, 3, 9)),
        called("GOTO", "g=0 GOSUB14", "Rg RBs"), called("GOTO of a host", "h=0 GOTO23", "Rh RBs"),
        called("STACK", "h=0 GOSUB16", "Rh RBs Zs", code="STACK"), called("WAIT", "GOSUB17", "RBs"),
        called("a pause until a character", "GOSUB18", "a=0", "RBs", code="!"),
        called("a program's report of the sample counter", "GOSUB19", code="RCLK"),
        called("more than ten calls", "j=0 GOSUB20", "Rj RBs Zs"),
        called("END of a host", "k=0 GOSUB21", "END", "k=0", "Rk"),
        called(
            "STACK of a host, in a subroutine", "Zs GOSUB27", "STACK", "RBs Zs", code="STACK", waits=((1, CHANNEL_S),)
        ),
        called("RETURN of a host", "Zs GOSUB27", "RETURN", "RBs", "RETURN", "RBs Zs", code="RETURN"),
        called("SILENT and TALK of a program", "GOSUB22", "SILENT GOSUB25", "TALK GOSUB25", code="SILENT"),
        called("the duration of a statement", "GOSUB24", "Rn"), called("TWAIT without motion", "GOSUB26"),
        called("an unknown label", "Zs GOSUB99 RBs", "Zs GOTO999 RBs Zs"),
    ]  # fmt: skip


def _channel(commands: Mapping[str, Instruction]) -> list[Case]:
    status = commands["Zf"].chapter

    def changed(name: str, label: int, *sent: str | bytes, code: str, then: tuple[str, ...]) -> Case:
        # A byte sent at a wrong baud rate can deselect the motor, so ADDRESS_ALL selects the motor again.
        lines = ("Zb Zc Zf Zs", f"GOSUB{label}", *sent, ADDRESS_ALL, *then)
        return case(name, commands[code].chapter, *lines, stores=True, waits=((1 + len(sent), CHANNEL_S),))

    return [
        loaded("load a program for the channel", commands["LOAD"].chapter, CHANNEL),
        changed("BAUD", 30, b"\x55", code="BAUDn", then=("RBf", "RBs RCHN", "Zf Zs RBf")),
        changed("OCHN with parity", 31, b"\n", code="OCHN()", then=("RBb RBf", "RCHN", "Zb Zf Zs RBb")),
        changed("OCHN for data", 32, b"XY", code="OCHN()", then=("Ro Rp Rq RBc",)),
        changed("too much data", 32, b"0123456789ABCDEFGH", code="OCHN()", then=("Ro RBc", "RCHN", "Zc RBc")),
        changed("CCHN", 33, b"RSP\r", code="CCHN()", then=("RSP",)),
        case("flags of the channel", status, "Zb Zc Zf Zs", "RBb RBc RBf", stores=True),
    ]


def locking(commands: Mapping[str, Instruction]) -> list[Case]:
    """Return the test cases for the command that locks a stored program.  Loading another program ends the lock."""
    section = commands["LOCKP"].chapter
    return [
        case("a locked program", section, *loading("RUN?\nEND\n"), "Zs LOCKP", "UPLOAD", "RBs", "Zs UP", "RBs",
             "RCKS Zs", stores=True, bare=True),
        case("a program after a lock", section, *loading("RUN?\nEND\n"), *sending("UPLOAD", 9), "RBs", stores=True,
             bare=True),
    ]  # fmt: skip


def save(end: End, condition: Condition) -> None:
    """Save the variables and EEPROM bytes that cases change.  Raises LinkError if one is not reported."""
    before = CONTENTS[condition.facts["checksum"].removesuffix(" P")]
    pointer = _number(end, b"PRINT(EPTR,#13)\r")
    values = {name: _number(end, b"R%s\r" % name.encode()) for name in SAVED}
    end.ask(b"EPTR=%d VLD(ab[0],%d)\r" % (AT, USED))
    kept = [_number(end, b"Rab[%d]\r" % index) for index in range(USED)]
    condition.saved = [b"WAKE\r", b"ECHO_OFF\r", b"TALK\r", b"END\r", *loading(before)]
    condition.saved += [b"ab[%d]=%d\r" % item for item in enumerate(kept)]
    condition.saved.append(b"EPTR=%d VST(ab[0],%d)\r" % (AT, USED))
    condition.saved += [b"%s=%d\r" % (name.encode(), value) for name, value in values.items()]
    condition.saved.append(b"EPTR=%d Zs\r" % pointer)
    for request in condition.saved[-len(values) - 1 :]:
        end.ask(request)


def _number(end: End, request: bytes) -> int:
    answer = end.ask_again(request, rb"-?\d+\r").removeprefix(request)
    if not re.fullmatch(rb"-?\d+\r", answer):
        raise LinkError(
            f"the motor's answer to {request!r} is {answer!r}, not a number: run axistwin probe without --memory"
        )
    return int(answer)


def restore(end: End, condition: Condition) -> str:
    """Restore the program, variables and data EEPROM of the motor.

    Return an error message if the checksum of the program is not the checksum from before the tests; otherwise "".
    """
    for request in condition.saved:
        # Wait for the acknowledgement of a program block; the motor acknowledges all blocks except the last.
        end.ask(request, wait_s=0.1)
    now = end.ask_again(b"RCKS\r", rb"\w{6} \w{6} \w\r").strip().decode("latin-1")
    if now == condition.facts["checksum"]:
        return ""
    return (
        f"RCKS reports {now or 'nothing'} instead of {condition.facts['checksum']}: switch the motor off and on, "
        "then load the program END"
    )
