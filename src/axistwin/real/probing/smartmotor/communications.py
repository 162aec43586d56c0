"""Communications and AniLink: echo, addresses, sleep, terminators, error flags of a channel; nothing moves."""

from collections.abc import Mapping

from axistwin.controllers.smartmotor.language.forms import Instruction
from axistwin.real.probing.cases import Case
from axistwin.real.probing.smartmotor.still import case

ALL, FIRST = 0x80, 0x81  # Address bytes: all motors of a chain, and the motor with address 1.
DEVICES = "ABCDEFGH"


def talk(commands: Mapping[str, Instruction], address: str) -> list[Case]:
    serial, anilink = commands["ECHO"].chapter, commands["AOUTp"].chapter
    variables, status, eeprom = commands["a…zzz="].chapter, commands["Zs"].chapter, commands["EPTR="].chapter
    found = [
        case("echo", serial, "a=5", "ECHO", "Ra", "a=7", "ECHO_OFF", "Ra"),
        case("sleep", serial, "SLEEP", "RSP", "a=8 Ra", "WAKE", "RSP", "Ra"),
        case("terminators", serial, b"a=1 Ra ", b"a=2\nRa\n", b"a=3\0Ra\0", b"\r\r \r", b"RSP\r"),
        case("several commands on a line", serial, "a=1 Ra b=2 Rb a=a+b Ra"),
        case("an address byte ends a command", serial, b"Zs RB", bytes((ALL,)) + b"s RBs ", b"Zs RBs "),
        case("errors of the channels", serial, "Zs Zb Zc Zf", "XX", "RCHN", "RCHN0", "RCS", "RCHN1", "RCS1", "Zs",
             "RCHN", "RCS"),
        case("a wrong baud rate", serial, "Zs", "BAUD9601", "RBs", "Zs", "OCHN(RS2,0,N,9601,1,8,C)", "RBs", "Zs",
             "CCHN(X,0)", "RBs", "Zs"),
        case("host mode: status without points", commands["Q"].chapter, "Q", depends=True),
        case("AniLink inputs without a device", anilink, "RAINA1", "RAINH4", "RDINA0", "RDINH63", "a=AINB2+DINC5 Ra",
             depends=True),
        case("AniLink: wrong channels", anilink, "Zs", "RAINA5", "RBs", "Zs", "RDINA64", "RBs", "Zs", "AOUTI,1", "RBs",
             "Zs", "DOUTA64,1", "RBs", "Zs"),
        *(case(f"PRINT{device}() on AniLink", anilink, "Zs", f'PRINT{device}("x")', "RBs") for device in DEVICES),
        case("EPTR=", eeprom, "zzz=EPTR", "EPTR=100", "REPTR", "PRINT(EPTR,#13)", "EPTR=7999 REPTR", "Zs EPTR=8000",
             "RBs REPTR", "Zs EPTR=-1", "RBs REPTR", "EPTR=zzz Zs"),
        case("the sample counter", commands["CLK="].chapter, "CLK=3000000 PRINT(CLK/100000,#13)",
             "CLK=0 PRINT(CLK/100000,#13)"),
        case("named variables and al[]", commands["al[]="].chapter, "aa=5 zz=6 aaa=7 yyy=8",
             "Ral[0] Ral[25] Ral[26] Ral[50]", "al[1]=9 Rbb", "aa=0 zz=0 aaa=0 yyy=0 bb=0"),
        case("bytes and words of an array", commands["aw[]="].chapter, "al[2]=16909060 Rab[8] Rab[11] Raw[4] Raw[5]",
             "al[2]=0", "ab[3+5]=1 Ral[2] al[2]=0"),
        case("a list of values", commands["aw[]="].chapter, b"aw[4] 10 -20 30.\r", "Raw[4] Raw[5] Raw[6]",
             "al[2]=0 al[3]=0"),
        case("powers, remainders and brackets", variables, "a=2^4 Ra", "a=-7%3 Ra", "a=(1+2)*(3+4) Ra", "a=6!|3 Ra",
             "a=1 b=(a==1)&(a<2) Rb"),
        case("an index that does not exist", status, "Zu ab[204]=1", "RBu", "a=ab[-1]", "RBu", "Zu RBu"),
        case("an overflow", status, "Zd a=2147483647 a=a+1 Ra RBd", "Zd RBd", "a=1/0 RBd", "Zd RBd"),
        case("only in a program", commands["IF"].chapter, *(f"Zs {word} RBs" for word in (
             "C5", "ELSE", "ENDIF", "LOOP", "DEFAULT", "BREAK", "ENDS", "WAIT=1", "TWAIT", "RUN?", "!")), "Zs"),
        case("flow without a program", commands["GOSUBn"].chapter, "Zs GOSUB5 RBs", "Zs GOTO5 RBs", "Zs RUN RBs",
             "Zs END RBs", "Zs RETURN RBs", "Zs STACK RBs Zs"),
        case("limits of the buffered settings", commands["MFMUL="].chapter, *(
             line for name, low, high in (("MFMUL", -32768, 32767), ("MFDIV", -32768, 32767), ("T", -1023, 1023),
                                          ("BASE", 0, 2147483647), ("SIZE", 0, 101))
             for line in (f"zzz={name} Zs", *(f"{name}={value} PRINT({name},#13)" for value in (low, low - 1, high, 5)),
                          *((f"{name}={high + 1} RBs",) if high < 0x7FFF_FFFF else ()), f"{name}=zzz"))),
        case("values of software limits", commands["SLN="].chapter, "zz=SLN zzz=SLP", "SLN=-70000 SLP=80000",
             "PRINT(SLN,#32,SLP,#13)", "SLN=zz SLP=zzz", depends=True),
        case("reports of cam settings", commands["RBASE"].chapter, "zzz=BASE zz=SIZE", "BASE=800 SIZE=8", "RBASE RSIZE",
             "BASE=zzz SIZE=zz"),
    ]  # fmt: skip
    if address == "0":
        here, other = (b"%cRADDR\r" % byte for byte in (FIRST, FIRST + 1))
        found.append(
            case("addresses", serial, b"%cRSP\r" % (ALL + 9), b"%cRSP\r" % ALL, "SADDR1", here, other, b"a=1\r",
                 b"%cRADDR\r" % ALL, "Zs SADDR121 RBs RADDR Zs", "SADDR0", "RADDR")
        )  # fmt: skip
    return found
