"""A host computer: an 8086 in real mode, emulated by Unicorn, with boards on its bus.

IN and OUT access the boards of a bench.  While a board interrupts and interrupts are enabled, the processor takes the
vector between two instructions.  Every instruction takes the same time (`instruction_ns`), so only average speed is
realistic.  Virtual time follows the processor at each port access, and events of the bench are executed when due.
Unicorn is an optional extra: `pip install ".[x86]"` in a clone, or `pip install unicorn`.
"""

from collections.abc import Mapping

from axistwin.bench import Bench, Controller
from axistwin.core.errors import require
from axistwin.core.units import US, to_ns
from axistwin.sim.registers import NOBODY_DRIVES, RegisterPort

require("unicorn", "x86")

from unicorn import UC_ARCH_X86, UC_HOOK_CODE, UC_HOOK_INSN, UC_HOOK_INTR, UC_MODE_16, Uc  # noqa: E402  # after the check
from unicorn import x86_const as x86  # noqa: E402  # after the check

MEMORY = 0x10_0000  # Address space of an 8086 in bytes.
INTERRUPT_FLAG, TRAP_FLAG = 0x200, 0x100
HALT, STI = 0xF4, 0xFB
INSTRUCTION_NS = 2 * US  # Time of one instruction: ten cycles of a 5 MHz clock.


class Computer:
    """An emulated 8086 computer with a megabyte of memory and boards on its bus.

    `boards`: boards by the base address of their two ports.  `vector`: interrupt number of their common (wire-ORed)
    request line, which is level sensitive.  Ports without a board read FFh.
    """

    def __init__(
        self, bench: Bench, boards: Mapping[int, Controller], *, vector: int = 0x20,
        instruction_ns: int = INSTRUCTION_NS,
    ) -> None:  # fmt: skip
        self.bench, self.vector, self.instruction_ns = bench, vector, instruction_ns
        self.instructions = 0  # Number of instructions that have been executed.
        self._ports: dict[int, tuple[RegisterPort, int]] = {
            base + offset: (board.bus, offset) for base, board in boards.items() for offset in (0, 1)
        }
        self._buses = [board.bus for board in boards.values()]
        self._time_ns = bench.now
        self._stop_ns = 0
        self._last = 0  # Address of the last executed instruction.
        self._halted = False
        self._uc = Uc(UC_ARCH_X86, UC_MODE_16)
        self._uc.mem_map(0, MEMORY)
        self._uc.hook_add(UC_HOOK_CODE, self._instruction)
        self._uc.hook_add(UC_HOOK_INTR, self._software_interrupt)
        self._uc.hook_add(UC_HOOK_INSN, self._in, None, 1, 0, x86.UC_X86_INS_IN)
        self._uc.hook_add(UC_HOOK_INSN, self._out, None, 1, 0, x86.UC_X86_INS_OUT)

    # Memory and registers

    def load(self, segment: int, offset: int, data: bytes) -> None:
        self._uc.mem_write((segment << 4) + offset, data)

    def memory(self, segment: int, offset: int, size: int) -> bytes:
        """Return `size` bytes of the emulated computer's memory, from the address `segment`:`offset`."""
        return bytes(self._uc.mem_read((segment << 4) + offset, size))

    def set_vector(self, number: int, segment: int, offset: int) -> None:
        self.load(0, 4 * number, offset.to_bytes(2, "little") + segment.to_bytes(2, "little"))

    def start_at(self, segment: int, offset: int, stack: int = 0xFFFE) -> None:
        """Set the address of the first instruction.  DS, ES and SS equal CS; `stack` is the initial stack pointer."""
        for register in (x86.UC_X86_REG_CS, x86.UC_X86_REG_DS, x86.UC_X86_REG_ES, x86.UC_X86_REG_SS):
            self._uc.reg_write(register, segment)
        self._uc.reg_write(x86.UC_X86_REG_SP, stack)
        self._uc.reg_write(x86.UC_X86_REG_IP, offset)
        self._halted = False

    @property
    def interruptible(self) -> bool:
        return bool(self._uc.reg_read(x86.UC_X86_REG_EFLAGS) & INTERRUPT_FLAG)

    @property
    def stopped(self) -> bool:
        """True if the processor has executed HLT with interrupts disabled, and can never continue."""
        return self._halted and not self.interruptible

    # Running

    def run(self, seconds: float) -> None:
        """Execute instructions for `seconds`, or until `stopped`."""
        end_ns = self.bench.now + to_ns(seconds)
        self._time_ns = self.bench.now
        while self._time_ns < end_ns and not self.stopped:
            if self._requested and self.interruptible:
                self._interrupt(self.vector)
                self._halted = False
            if self._halted:
                self._sleep(end_ns)
            else:
                self._execute(end_ns)
        self.bench.clock.run_to(max(min(self._time_ns, end_ns), self.bench.now))

    @property
    def _requested(self) -> bool:
        return any(bus.interrupt for bus in self._buses)

    def _execute(self, end_ns: int) -> None:
        """Execute instructions until the next event; only one instruction while an interrupt is pending."""
        due_ns = self.bench.clock.next_event_ns()
        self._stop_ns = min(end_ns, end_ns if due_ns is None else max(due_ns, self._time_ns + 1))
        if self._requested:
            self._stop_ns = self._time_ns + 1
        begin = (self._uc.reg_read(x86.UC_X86_REG_CS) << 4) + self._uc.reg_read(x86.UC_X86_REG_IP)
        # The emulator runs until the instruction callback stops the emulated processor.
        self._uc.emu_start(begin, MEMORY)
        self._halted = self._has_just_halted()
        self._catch_up()

    def _has_just_halted(self) -> bool:
        here = (self._uc.reg_read(x86.UC_X86_REG_CS) << 4) + self._uc.reg_read(x86.UC_X86_REG_IP)
        return bool(self._uc.mem_read(self._last, 1)[0] == HALT and here == self._last + 1)

    def _sleep(self, end_ns: int) -> None:
        due_ns = self.bench.clock.next_event_ns()
        self._time_ns = end_ns if due_ns is None else min(end_ns, max(due_ns, self._time_ns))
        self._catch_up()

    def _catch_up(self) -> None:
        if self._time_ns > self.bench.now:
            self.bench.clock.run_to(self._time_ns)

    def _interrupt(self, number: int) -> None:
        flags = self._uc.reg_read(x86.UC_X86_REG_EFLAGS) & 0xFFFF
        for value in (flags, self._uc.reg_read(x86.UC_X86_REG_CS), self._uc.reg_read(x86.UC_X86_REG_IP)):
            self._push(value)
        self._uc.reg_write(x86.UC_X86_REG_EFLAGS, flags & ~(INTERRUPT_FLAG | TRAP_FLAG))
        entry = self.memory(0, 4 * number, 4)
        self._uc.reg_write(x86.UC_X86_REG_CS, int.from_bytes(entry[2:], "little"))
        self._uc.reg_write(x86.UC_X86_REG_IP, int.from_bytes(entry[:2], "little"))

    def _push(self, value: int) -> None:
        pointer = (self._uc.reg_read(x86.UC_X86_REG_SP) - 2) & 0xFFFF
        self._uc.reg_write(x86.UC_X86_REG_SP, pointer)
        self.load(self._uc.reg_read(x86.UC_X86_REG_SS), pointer, value.to_bytes(2, "little"))

    # Callbacks of the processor emulator

    def _instruction(self, uc: Uc, address: int, size: int, _: object) -> None:  # noqa: ARG002
        """Handle one instruction before Unicorn executes it; after STI, an interrupt waits for one more instruction."""
        if self._time_ns >= self._stop_ns and uc.mem_read(self._last, 1)[0] != STI:
            uc.emu_stop()
            return
        self._last = address
        self._time_ns += self.instruction_ns
        self.instructions += 1

    def _software_interrupt(self, uc: Uc, number: int, _: object) -> None:  # noqa: ARG002
        self._interrupt(number)

    def _in(self, uc: Uc, port: int, size: int, _: object) -> int:  # noqa: ARG002
        return sum(self._read(port + place) << 8 * place for place in range(size))

    def _read(self, port: int) -> int:
        self._catch_up()
        bus, offset = self._ports.get(port, (None, 0))
        return NOBODY_DRIVES if bus is None else bus.read(offset)

    def _out(self, uc: Uc, port: int, size: int, value: int, _: object) -> None:  # noqa: ARG002
        self._catch_up()
        for place in range(size):
            bus, offset = self._ports.get(port + place, (None, 0))
            if bus is not None:
                bus.write(offset, value >> 8 * place & 0xFF)
        # Pause the emulated processor after an OUT instruction, because OUT may cause a new event in the simulation.
        self._stop_ns = 0
