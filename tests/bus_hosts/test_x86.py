"""An 8086 as the host: IN and OUT reach the board, and the board's interrupt is accepted.

The programs follow the manual's advice on interrupts: STATE holds a copy of the control byte, which cannot be read
back, and interrupts are disabled during each write to the control byte.
"""

import pytest

pytest.importorskip("unicorn")

from axistwin.links.bus_hosts.x86 import Computer

BASE = 0x60  # the board: data at 60h, status and control at 61h
CODE = 0x1000
VECTOR = 0x23
STATE, COUNT, BUFFER = 0x0800, 0x0801, 0x0810  # variables in the program's segment
HANDLER, COMMANDS = 0x0200, 0x0900


def code(*lines):
    """Return the machine code in lines of hex with comments."""
    return b"".join(bytes.fromhex(line.partition(";")[0]) for line in lines)


SEND = code(  # at 0100: send the commands at DS:SI, each with its length before it, until a length is 0
    "FC           ;       CLD",
    "8A 0C        ; next: MOV CL,[SI]",
    "46           ;       INC SI",
    "30 ED        ;       XOR CH,CH",
    "E3 1D        ;       JCXZ done",
    "E4 61        ; wait: IN AL,61h          ; status byte",
    "A8 10        ;       TEST AL,10h        ; is the IDB ready?",
    "74 FA        ;       JZ wait",
    "AC           ; fill: LODSB",
    "E6 60        ;       OUT 60h,AL         ; into the IDB",
    "E2 FB        ;       LOOP fill",
    "9C           ;       PUSHF              ; save the interrupt flag",
    "FA           ;       CLI",
    "B0 10        ;       MOV AL,10h         ; command ready",
    "80 3E 00 08 00 ;     CMP BYTE [STATE],0 ; are the board's interrupts enabled?",
    "74 02        ;       JZ off",
    "0C 40        ;       OR AL,40h          ; keep them so",
    "E6 61        ; off:  OUT 61h,AL",
    "9D           ;       POPF",
    "EB DC        ;       JMP next",
)
THEN_SLEEP = code(
    "FB           ; done: STI",
    "F4           ;       HLT                ; until the board interrupts",
    "80 3E 01 08 02 ;     CMP BYTE [COUNT],2 ; two messages?",
    "72 F7        ;       JB done",
    "FA           ;       CLI",
    "F4           ;       HLT                ; for ever",
)
ON_INTERRUPT = code(  # at 0200: read a message into BUFFER + 16 * COUNT
    "50 51 57     ;       PUSH AX; PUSH CX; PUSH DI",
    "A0 01 08     ;       MOV AL,[COUNT]",
    "B1 04        ;       MOV CL,4",
    "30 E4        ;       XOR AH,AH",
    "D3 E0        ;       SHL AX,CL",
    "05 10 08     ;       ADD AX,BUFFER",
    "89 C7        ;       MOV DI,AX",
    "B9 10 00     ;       MOV CX,16",
    "E4 60        ; read: IN AL,60h          ; out of the ODB",
    "AA           ;       STOSB",
    "E2 FB        ;       LOOP read",
    "FE 06 01 08  ;       INC BYTE [COUNT]",
    "B0 C0        ;       MOV AL,0C0h        ; message taken, interrupts stay enabled",
    "E6 61        ;       OUT 61h,AL",
    "5F 59 58     ;       POP DI; POP CX; POP AX",
    "CF           ;       IRET",
)


def commands(*strings):
    """Return command strings, each with its length before it, and the end mark."""
    data = [bytes.fromhex(string) for string in strings]
    return b"".join(bytes([len(each)]) + each for each in data) + b"\0"


def computer(bench, board, program, **options):
    made = Computer(bench, {BASE: board}, vector=VECTOR, **options)
    made.load(CODE, 0x100, program)
    made.load(CODE, HANDLER, ON_INTERRUPT)
    made.set_vector(VECTOR, CODE, HANDLER)
    made.start_at(CODE, 0x100)
    return made


def test_a_move_and_its_messages_by_interrupt(bench):
    """The host sets a default velocity, requests a message at the end of motion, and moves one revolution."""
    board = bench.add("1811", initialisation_s=0.1)
    enable = code("BE 00 09 ; MOV SI,COMMANDS", "C6 06 00 08 FF ; MOV BYTE [STATE],0FFh")
    pc = computer(bench, board, enable + SEND + THEN_SLEEP)
    pc.load(CODE, COMMANDS, commands("31 00 00 00 00 61 A8 00 03 D0 90", "A4 01", "33 00 00 61 A8", "01 2A"))
    pc.run(10)
    assert pc.stopped and pc.memory(CODE, COUNT, 1) == b"\x02"
    assert pc.memory(CODE, BUFFER, 2) == b"\x01\x2a"  # only the first message, because the move takes longer
    assert pc.memory(CODE, BUFFER + 16, 2) == b"\xa4\x00"
    assert (board.axes["motor"].position, len(board.axes["motor"].pulse_times())) == (25_000, 25_000)
    assert bench.seconds < 1.6


def test_virtual_time_passes_with_the_instructions(bench):
    """The board needs 100 ms to initialise; polling takes three instructions of 2 microseconds."""
    board = bench.add("1811", initialisation_s=0.1)
    pc = computer(bench, board, code("E4 61", "A8 10", "74 FA", "F4"))  # IN AL,61h; TEST AL,10h; JZ; HLT
    pc.run(2)
    assert pc.stopped and 0.1 <= bench.seconds < 0.1001
    assert pc.instructions == pytest.approx(50_000, rel=0.001)


def test_an_interrupt_waits_until_it_is_let_in(bench):
    """With interrupts disabled the line stays active; after STI, one instruction is executed before the interrupt."""
    board = bench.add("1811", interrupts=("input_ready",), initialisation_s=0.1)
    program = code(
        "B0 40     ; MOV AL,40h       ; enable the board's interrupts",
        "E6 61     ; OUT 61h,AL",
        "E4 61     ; IN AL,61h        ; wait for SB bit 7",
        "A8 80     ; TEST AL,80h",
        "74 FA     ; JZ",
        "B3 00     ; MOV BL,0",
        "FB        ; STI",
        "B3 01     ; MOV BL,1",
        "B3 02     ; MOV BL,2",
    )
    pc = computer(bench, board, program)
    pc.load(CODE, HANDLER, code("88 1E 00 08 ; MOV [STATE],BL", "FA ; CLI", "F4 ; HLT"))
    pc.run(2)
    assert pc.stopped and pc.memory(CODE, STATE, 1) == b"\x01"


def test_a_software_interrupt_and_its_return(bench):
    board = bench.add("1811")
    pc = computer(bench, board, code("CD 40 ; INT 40h", "FE 06 00 08 ; INC BYTE [STATE]", "F4 ; HLT"))
    pc.set_vector(0x40, CODE, 0x300)
    pc.load(CODE, 0x300, code("C6 06 00 08 05 ; MOV BYTE [STATE],5", "CF ; IRET"))
    pc.run(1)
    assert pc.memory(CODE, STATE, 1) == b"\x06"


def test_ports_where_no_board_sits(bench):
    pc = computer(
        bench, bench.add("1811"), code("E6 70 ; OUT 70h,AL", "E5 70 ; IN AX,70h", "A3 00 08 F4 ; MOV [STATE],AX")
    )
    pc.run(1)
    assert pc.memory(CODE, STATE, 2) == b"\xff\xff"


def test_a_program_for_ever_ends_with_its_time(bench):
    pc = computer(bench, bench.add("1811"), code("EB FE ; JMP $"))
    pc.run(0.01)
    assert not pc.stopped and bench.seconds == pytest.approx(0.01, abs=1e-5)
    pc.run(0.01)
    assert bench.seconds == pytest.approx(0.02, abs=1e-5)
