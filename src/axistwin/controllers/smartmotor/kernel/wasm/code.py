"""The binary format of WebAssembly, as far as the kernel needs it: instructions, functions and a module.

Instructions are bytes; their names are those of the WebAssembly specification, 5.4.
"""

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

I32, I64, F64, NO_RESULT = 0x7F, 0x7E, 0x7C, 0x40
"""Types of values, and the type of a block without a result."""

UNREACHABLE, BLOCK, LOOP, IF, ELSE, END = b"\x00", b"\x02", b"\x03", b"\x04", b"\x05", b"\x0b"
RETURN, DROP, SELECT = b"\x0f", b"\x1a", b"\x1b"
I32_EQZ, I32_ADD, I32_AND, I32_OR, I32_SHL = b"\x45", b"\x6a", b"\x71", b"\x72", b"\x74"
I64_EQZ, I64_ADD, I64_MUL, I64_SUB, I64_DIV, I64_XOR = b"\x50", b"\x7c", b"\x7e", b"\x7d", b"\x7f", b"\x85"
I64_EQ, I64_NE, I64_LT = b"\x51", b"\x52", b"\x53"
F64_NE, F64_LT, F64_ABS, F64_NEG, F64_FLOOR, F64_SQRT = b"\x62", b"\x63", b"\x99", b"\x9a", b"\x9c", b"\x9f"
I32_WRAP, I64_EXTEND, F64_CONVERT = b"\xa7", b"\xad", b"\xb9"
I64_TRUNCATE = b"\xfc\x06"
"""`i64.trunc_sat_f64_s`."""

_ALIGNED = 3
_PAGE = 1 << 16


def unsigned(value: int) -> bytes:
    """Encode an unsigned number in LEB128."""
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*out, value))


def signed(value: int) -> bytes:
    """Encode a signed number in LEB128."""
    out = bytearray()
    while not -0x40 <= value < 0x40:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*out, value & 0x7F))


def i32_const(value: int) -> bytes:
    """Return the WebAssembly instruction that pushes a 32-bit integer onto the stack."""
    return b"\x41" + signed(value)


def i64_const(value: int) -> bytes:
    """Return the WebAssembly instruction that pushes a 64-bit integer onto the stack."""
    return b"\x42" + signed(value)


def f64_const(value: float) -> bytes:
    """Return the WebAssembly instruction that pushes a float onto the stack."""
    return b"\x44" + struct.pack("<d", value)


def local_get(index: int) -> bytes:
    """Return the WebAssembly instruction that pushes a local variable onto the stack."""
    return b"\x20" + unsigned(index)


def local_set(index: int) -> bytes:
    """Return the instruction that pops the top of the stack into a local variable."""
    return b"\x21" + unsigned(index)


def local_tee(index: int) -> bytes:
    """Return the instruction that copies the top of the stack into a local variable, without a pop."""
    return b"\x22" + unsigned(index)


def call(index: int) -> bytes:
    """Return the WebAssembly instruction that calls the function with the given index."""
    return b"\x10" + unsigned(index)


def br(depth: int) -> bytes:
    """Return a jump out of `depth` enclosing blocks, or to the beginning of a loop."""
    return b"\x0c" + unsigned(depth)


def br_if(depth: int) -> bytes:
    """Return the instruction that pops an i32 from the stack, and jumps if the i32 is not 0."""
    return b"\x0d" + unsigned(depth)


def load(kind: int, offset: int) -> bytes:
    """Return the WebAssembly instruction that reads a number of type I64 or F64 from memory."""
    return (b"\x29" if kind == I64 else b"\x2b") + bytes((_ALIGNED,)) + unsigned(offset)


def store(kind: int, offset: int) -> bytes:
    """Return the WebAssembly instruction that writes a number of type I64 or F64 to memory."""
    return (b"\x37" if kind == I64 else b"\x39") + bytes((_ALIGNED,)) + unsigned(offset)


@dataclass(frozen=True)
class Function:
    """A function.  `variables`: types of its local variables, which come after the parameters."""

    parameters: tuple[int, ...]
    results: tuple[int, ...]
    variables: tuple[int, ...]
    code: bytes


def module(functions: Sequence[Function], exported: str) -> bytes:
    """Return a module that exports its first function as `exported`, and one page of memory."""
    types = list(dict.fromkeys((each.parameters, each.results) for each in functions))
    exports = [(exported, 0, 0), ("memory", 2, 0)]
    sections = (
        _vector(b"\x60" + _values(parameters) + _values(results) for parameters, results in types),
        _vector(unsigned(types.index((each.parameters, each.results))) for each in functions),
        _vector([b"\x00" + unsigned(1)]),
        _vector(_sized(name.encode()) + bytes((kind,)) + unsigned(index) for name, kind, index in exports),
        _vector(_sized(_body(each)) for each in functions),
    )
    numbers = 1, 3, 5, 7, 10
    return b"\0asm\x01\0\0\0" + b"".join(
        bytes((number,)) + _sized(section) for number, section in zip(numbers, sections, strict=True)
    )


def pages(size: int) -> int:
    """Return the number of memory pages that `size` bytes need."""
    return -(-size // _PAGE)


def _body(function: Function) -> bytes:
    return _vector(unsigned(1) + bytes((kind,)) for kind in function.variables) + function.code + END


def _values(kinds: Iterable[int]) -> bytes:
    return _vector(bytes((kind,)) for kind in kinds)


def _vector(items: Iterable[bytes]) -> bytes:
    found = list(items)
    return unsigned(len(found)) + b"".join(found)


def _sized(data: bytes) -> bytes:
    return unsigned(len(data)) + data
