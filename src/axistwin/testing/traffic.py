"""Traffic of a host of any model: whole commands of its table, damaged ones, and any bytes, all from a seed."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from random import Random
from typing import Any, NamedTuple

from axistwin.controllers.commandset import Command, Field
from axistwin.controllers.product import Product

ORDINARY = 2000  # Largest magnitude of a number whose field has no range, so that moves end within the check.
MOST_BURST = 24
MOST_ON_A_BUS = 16  # Bytes of a command.
PAUSES_S = (0.0, 0.001, 0.02, 0.1, 0.4)
Pick = Callable[[Field], Any]


class Burst(NamedTuple):
    """Data that a host sends at once, and the seconds until it sends the next ones."""

    data: bytes  # On a bus: one command.
    then: float


class Dialect:
    """Language of the hosts of a model.  `opening`: what they send first, e.g. to initialise it."""

    opening: tuple[Burst, ...] = ()

    def __init__(self, product: Product) -> None:
        self.product = product

    def phrases(self, command: Command, pick: Pick) -> Iterable[bytes]:
        """Return what a host sends so that a command, as just switched on, is carried out."""
        assert self.product.phrase is not None, "only a device that has it is asked"
        yield self.product.phrase(command, {field.name: pick(field) for field in command.parameters})

    def forget(self) -> None:
        """Empty the caches that spare a command its handler."""


class Digiplan(Dialect):
    """An IF1 or IF2 with the format U61; commands that are part of a message are sent in one."""

    opening = (Burst(b"(", 0.2), Burst(b"U61\r", 1.3))
    _MESSAGES: Mapping[str, str] = {
        "%": ":%:$", "/": "X20/Y10$", "=": ":X1:=2,1:$", "A": ":X@500G:A:$", "B": "X10B$", "G": "X@500G$",
    }  # fmt: skip
    _SIGNS = frozenset("\n\r $+,-:(*UV")

    def phrases(self, command: Command, pick: Pick) -> Iterable[bytes]:
        code = str(command.code)
        if code in self._SIGNS:
            return
        text = self._MESSAGES.get(code) or code + "".join(self._written(field, pick) for field in command.parameters)
        if code in "HL":
            text += "X1"
        alone = code in "#EFIKNOQ[]" or code in self._MESSAGES
        yield f"{text}{'' if alone else '$'}\r".encode("latin-1")
        if code == ":":
            yield b"#\r"

    def forget(self) -> None:
        from axistwin.controllers.digiplan.interface import read

        read.cache_clear()

    def _written(self, field: Field, pick: Pick) -> str:
        if field.name == "direction":
            return "+"
        value = str(pick(field))
        comma = "," if "," in getattr(field, "pattern", "") else ""
        return comma + (f"+{value}" if field.name == "signed distance" else value)


class Compumotor(Dialect):
    """A board on a bus: opcode and parameters; what is valid in a sequence or a stream only is sent in one."""

    _STREAMS: Mapping[int, str] = {0xE0: "51 01 01 00000000", 0xE1: "52 01 01 00000000 0064",
                                   0xE3: "53 01 01 00000000 0064"}  # fmt: skip

    def phrases(self, command: Any, pick: Pick) -> Iterable[bytes]:
        own = bytes([command.code]) + b"".join(self._encoded(field, pick) for field in command.fields)
        allowed = {flag.name for flag in command.accepted}
        if not allowed:
            return
        if "INDEXER" in allowed:
            yield own
        elif "SEQUENCE" in allowed:
            yield from (b"\xd9\x01", own, b"\xd8", b"\x41\x01")
        else:
            yield from (bytes.fromhex(self._STREAMS.get(command.code, self._STREAMS[0xE0])), own)

    def _encoded(self, field: Any, pick: Pick) -> bytes:
        if field.name == "ranges":
            return b"\x00"
        value = next(iter(getattr(field, "choices", ())), None) or pick(field)
        return bytes(field.encode(value % 256**field.size if field.low is None else value))


class SmartMotor(Dialect):
    """A motor whose limit pins are inputs."""

    opening = (Burst(b"UCI UDI ZS ", 0.2),)
    _PARAMETERS: Mapping[str, str] = {
        "NUMBER": "1", "LET": "1", "AFTER": " 1", "ITEMS": '"a",1)', "CALL": "a,1)", "ARRAY": "[1]=1", "OUTPUT": "A,1",
        "REPORT_ARRAY": "[1]",
    }  # fmt: skip
    _WHOLE: Mapping[str, str] = {
        "PIDn": "PID2", "BAUDn": "BAUD9600", "DOUTp": "DOUTA1,1", "a…zzz=": "a=1", "Ra…Rzzz": "Ra", "RAINpc": "RAINA1",
        "RDINpc": "RDINA1", "OCHN()": "OCHN(RS4,1,N,9600,1,8,C)", "CCHN()": "CCHN(RS4,1)",
    }  # fmt: skip

    def phrases(self, command: Any, pick: Pick) -> Iterable[bytes]:
        if not any(flag.name == "HOST" for flag in command.accepted):
            return
        code, form = str(command.code), command.form.name
        stems = {"NUMBER": code[:-1], "ITEMS": code[:-1], "CALL": code[:-1], "OUTPUT": code[:-1]}
        stem = code[: code.index("[")] if "[" in code else stems.get(form, code)
        words = self._PARAMETERS.get(form, "")
        if form in ("NUMBER", "LET") and command.parameters[0].low is not None:
            words = str(pick(command.parameters[0]))
        yield f"{self._WHOLE.get(code, stem + words)} ".encode("latin-1")


DIALECTS: Mapping[str, type[Dialect]] = {"digiplan": Digiplan, "compumotor": Compumotor, "smartmotor": SmartMotor}


def dialect_of(product: Product) -> Dialect:
    return DIALECTS.get(product.family, Dialect)(product)


def lowest(product: Product, field: Any) -> Any:
    """Return the plainest value of a field."""
    if hasattr(field, "example"):
        return field.example(next(iter(product.axes), ""))
    return 0 if field.low is None else field.low


def chosen(product: Product, rng: Random, field: Any) -> Any:
    """Return any value of a field."""
    kind = getattr(field, "kind", "int")
    if kind == "axis" or "|" in kind:
        return rng.choice(product.axes if kind == "axis" else kind.split("|"))
    if kind in ("word", "text"):
        return "".join(rng.choices("abcXYZ0189_", k=rng.randint(1, 6)))
    low = -ORDINARY if field.low is None else max(field.low, -ORDINARY)
    high = max(low, ORDINARY if field.high is None else min(field.high, ORDINARY))
    return round(rng.uniform(low, high), 3) if kind == "float" else rng.randint(int(low), int(high))


class Traffic:
    """Bursts for a model, the same for the same seed."""

    def __init__(self, product: Product, rng: Random) -> None:
        self.product, self.rng, self.dialect = product, rng, dialect_of(product)
        speaks = product.phrase is not None or product.family in DIALECTS
        self._commands = [one for one in product.commands if one.implemented] if speaks else []

    def bursts(self, count: int, *, wild: bool = False) -> list[Burst]:
        """Return valid commands; `wild`: also damaged ones and any bytes."""
        found: list[Burst] = []
        while len(found) < count:
            for data in self._phrases():
                damaged = wild and self.rng.random() < 0.6
                found.append(Burst(self._damaged(data) if damaged else data, self.rng.choice(PAUSES_S)))
        return found

    def _phrases(self) -> list[bytes]:
        pick, found = partial(chosen, self.product, self.rng), list[bytes]()
        while self._commands and not found:
            found = list(self.dialect.phrases(self.rng.choice(self._commands), pick))
        return found or [self.rng.randbytes(self.rng.randint(1, MOST_BURST))]

    def _damaged(self, whole: bytes) -> bytes:
        data, rng = bytearray(whole), self.rng
        for _ in range(rng.randint(1, 3)):
            place = rng.randrange(len(data) + 1)
            match rng.randrange(4):
                case 0:
                    data[place:place] = rng.randbytes(rng.randint(1, 3))
                case 1:
                    del data[place : place + 2]
                case 2:
                    data[place : place + 1] = rng.choice((b"9" * 30, b"-", b"\r", b"\xff", b"\x00", b"."))
                case 3:
                    data = bytearray(rng.randbytes(rng.randint(1, MOST_BURST)))
        return bytes(data[:MOST_ON_A_BUS] if self.product.attend else data) or b"\x00"
