"""Differences between installed boards, and figures for which the manual gives only an "about"."""

from dataclasses import dataclass, fields
from typing import Literal, get_args, get_type_hints

from axistwin.errors import UsageError

Interrupt = Literal["message_ready", "input_ready", "failed"]


@dataclass(frozen=True)
class Options:
    """Keywords of `bench.add("1811", ...)`."""

    interrupts: tuple[Interrupt, ...] = ("message_ready",)
    """Which conditions interrupt the host: the jumpers JU18 (message_ready), JU20 (input_ready), JU19 (failed)."""
    test_switch: bool = True
    """Jumper JU15: True if the test switch on the board's edge is connected."""
    initialisation_s: float = 1.0
    """From power-up or reset until the board accepts commands: "about one second"."""
    drain_ms: float = 1.0
    """From a command's CB bit 4 until SB bit 4 is set again: "in about one millisecond"."""
    reply_ms: float = 4.0
    """From the end of `drain_ms` until the message is in the ODB; asking "usually takes about 5+ milliseconds"."""
    start_ms: float = 3.0
    """Before a calculated move begins; "within five milliseconds of receipt of the command"."""
    calculation_ms: float = 10.0
    """To calculate ("crunch") a move: "less than half" of 30 ms, with what is above."""
    step_ms: float = 1.0
    """The processor's own time for a command in a sequence."""
    next_message_ms: float = 1.0
    """From CB bit 7 until a waiting message is in the ODB."""
    limit_us: float = 75.0
    """A limit input must be active for "a minimum duration of 75 microseconds"; it acts "within 200 microseconds"."""
    trigger1_us: float = 200.0
    """From a rising edge to the function of trigger 1."""
    trigger6_us: float = 400.0
    """From a rising edge to the function of trigger 6."""
    trigger1_hold_us: float = 0.0
    """The time for which trigger 1 must stay high before it acts.  0: its response time.

    "Requires a hold time of 500 microseconds to be recognized"; yet "response will be within 200".
    """
    trigger6_hold_us: float = 0.0
    """The same for trigger 6: "1 millisecond", and "within 400 microseconds"."""
    home_ms: float = 3.0
    """The time for which the home input must keep a level: "like TRIGGERS 2 through 5", whose worst case it is."""
    invert_z: bool = False
    """Jumper JU16: True if the encoder's channel Z is inverted."""
    invert_encoder: bool = False
    """Jumper JU17: True if the encoder's direction bit is inverted."""
    marker_ms: float = 3.0
    """From a marker in the stream until its command has been carried out: "approximately two to four milliseconds"."""
    buffer_bytes: int = 600
    """Memory for sequences or streaming: "about 600 decimal bytes"."""
    command_queue: int = 16
    """Commands taken from the IDB and not yet obeyed; full: SB bit 4 stays clear."""
    message_queue: int = 64
    """Messages waiting for the ODB; full: further ones are lost."""
    interrupt_command: Literal["everywhere", "printed"] = "everywhere"
    """The places of 01h: in sequences and markers too, or in neither, as its printed attributes say."""
    encoder_commands: Literal["kept", "performed", "ignored"] = "kept"
    """The effect of 2Fh, 35h to 37h, 3Ah, D4h and D5h on an 1810.

    "kept": the position and the definitions are kept, nothing moves by the missing encoder.
    "performed": all of them as on an 1811 without an encoder.  "ignored": none of them.
    """
    stop_after_stream: Literal["ramp", "ignored"] = "ramp"
    """The effect of 70h on a motor that a stream has left at a velocity: a ramp as of the last move, or none."""
    high_impedance: bool = False
    """The level of the outputs in high impedance, after a failure: what they are connected to pulls them there."""
    part_number: str = "94-003657-01A"
    """The answer to FDh: 94-, six digits, -, two digits, one or two letters."""

    def __post_init__(self) -> None:
        for name in self.interrupts:
            if name not in get_args(Interrupt):
                raise UsageError(f"interrupts: no {name!r}: choose of {', '.join(get_args(Interrupt))}")
        for choice in ("interrupt_command", "encoder_commands", "stop_after_stream"):
            known = get_args(get_type_hints(Options)[choice])
            if getattr(self, choice) not in known:
                raise UsageError(f"{choice}={getattr(self, choice)!r}: choose one of {', '.join(known)}")
        for flag in ("test_switch", "invert_z", "invert_encoder", "high_impedance"):
            if not isinstance(getattr(self, flag), bool):
                raise UsageError(f"{flag}={getattr(self, flag)!r}: give true or false")
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type in (float, "float"):
                _check_number(field.name, value, 0, 60_000, (int, float))
        _check_number("buffer_bytes", self.buffer_bytes, 16, 0xFFFF, (int,))
        _check_number("command_queue", self.command_queue, 1, 1000, (int,))
        _check_number("message_queue", self.message_queue, 1, 1000, (int,))
        if self.step_ms == 0:
            raise UsageError("step_ms=0: give a number above 0")
        if not (self.part_number.isascii() and len(self.part_number) in (13, 14)):
            raise UsageError(f"part_number={self.part_number!r}: give 13 or 14 characters like 94-003657-01A")


def _check_number(name: str, value: object, low: int, high: int, types: tuple[type, ...]) -> None:
    if isinstance(value, bool) or not isinstance(value, types) or not low <= value <= high:  # type: ignore[operator]
        raise UsageError(f"{name}={value!r}: give a number from {low} to {high}")
