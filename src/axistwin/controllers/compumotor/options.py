"""Options for differences between installed boards, and for values that the manual gives only as "about"."""

from dataclasses import dataclass
from typing import Literal, get_args

from axistwin.controllers.options import check
from axistwin.core.errors import UsageError

LEAST_MS = 0.001  # Shortest time to begin a command of a sequence.
Interrupt = Literal["message_ready", "input_ready", "failed"]


@dataclass(frozen=True)
class Options:
    """Keywords of `bench.add("1811", ...)`."""

    interrupts: tuple[Interrupt, ...] = ("message_ready",)
    """Conditions that interrupt the host, by jumpers: JU18 message_ready, JU20 input_ready, JU19 failed."""
    test_switch: bool = True
    """Jumper JU15: True if the test switch on the board's edge is connected."""
    initialisation_s: float = 1.0
    """Time from power-up or reset until the board accepts commands: "about one second"."""
    drain_ms: float = 1.0
    """Time from a command's CB bit 4 until SB bit 4 is set again: "in about one millisecond"."""
    reply_ms: float = 4.0
    """Time from the end of `drain_ms` to the reply in the ODB; a request "usually takes about 5+ milliseconds"."""
    start_ms: float = 3.0
    """Delay before a calculated move begins; "within five milliseconds of receipt of the command"."""
    calculation_ms: float = 10.0
    """Time to calculate ("crunch") a move; with `drain_ms` and `start_ms` "less than half" of 30 ms."""
    step_ms: float = 1.0
    """Time that the processor needs to begin a command of a sequence."""
    next_message_ms: float = 1.0
    """Time from CB bit 7 until a waiting message is in the ODB."""
    limit_us: float = 75.0
    """Time for which a limit input must be active before motion stops: "a minimum duration of 75 microseconds"."""
    trigger1_us: float = 200.0
    """Time from a rising edge of trigger 1 to its function."""
    trigger6_us: float = 400.0
    """Time from a rising edge of trigger 6 to its function."""
    trigger1_hold_us: float = 0.0
    """Time for which trigger 1 must stay high before it acts.  0: the response time, `trigger1_us`.

    "Requires a hold time of 500 microseconds to be recognized"; yet "response will be within 200".
    """
    trigger6_hold_us: float = 0.0
    """Time for which trigger 6 must stay high before it acts: "1 millisecond".  0: `trigger6_us`."""
    home_ms: float = 3.0
    """Time for which the home input must keep a level: the worst case of "TRIGGERS 2 through 5"."""
    invert_z: bool = False
    """Jumper JU16: True if the encoder's channel Z is inverted."""
    invert_encoder: bool = False
    """Jumper JU17: True if the encoder's direction bit is inverted."""
    marker_ms: float = 3.0
    """Time from a marker in the stream to the end of its command: "approximately two to four milliseconds"."""
    buffer_bytes: int = 600
    """Size of the memory for sequences or streaming: "about 600 decimal bytes"."""
    command_queue: int = 16
    """Number of commands that can wait after the IDB; while as many wait, SB bit 4 stays clear."""
    message_queue: int = 64
    """Number of messages that can wait for the ODB; further messages are lost."""
    interrupt_command: Literal["everywhere", "printed"] = "everywhere"
    """Places where 01h is valid: "everywhere", or as printed in the manual, without sequences and markers."""
    encoder_commands: Literal["kept", "performed", "ignored"] = "kept"
    """The effect of 2Fh, 35h to 37h, 3Ah, D4h and D5h on an 1810.

    "kept": positions and definitions are stored, but no move uses the missing encoder.
    "performed": all commands as on an 1811 without an encoder. "ignored": no command.
    """
    stop_after_stream: Literal["ramp", "ignored"] = "ramp"
    """Effect of 70h on a motor that runs after a stream: the ramp of the last move, or none."""
    high_impedance: bool = False
    """Level that the connected circuit gives to outputs in high impedance, after a failure of the board."""
    part_number: str = "94-003657-01A"
    """Answer to FDh: 94-, six digits, -, two digits, one or two letters."""

    def __post_init__(self) -> None:
        valid_interrupts = ", ".join(get_args(Interrupt))
        if not isinstance(self.interrupts, tuple | list):
            raise UsageError(f"interrupts={self.interrupts!r}: expected a list, e.g. ['message_ready']")
        for interrupt in self.interrupts:
            if interrupt not in get_args(Interrupt):
                raise UsageError(f"interrupts={interrupt!r}: expected one of {valid_interrupts}")
        number = self.part_number
        if not (str(number) == number and number.isascii() and len(number) in (13, 14)):
            raise UsageError(f"part_number={self.part_number!r}: expected 13 or 14 characters, e.g. 94-003657-01A")
        check(self, RANGES)


RANGES: dict[str, tuple[float, float]] = {
    **{name: (0, 60_000) for name, default in vars(Options).items() if isinstance(default, float)},
    "step_ms": (LEAST_MS, 60_000),
    "buffer_bytes": (16, 0xFFFF),
    "command_queue": (1, 1000),
    "message_queue": (1, 1000),
}
