"""Options: differences between SmartMotors, and questions that the manuals leave open."""

from dataclasses import dataclass
from typing import Literal

from axistwin.controllers.options import check

RANGES: dict[str, tuple[int | float, int | float]] = {
    "statements_per_sample": (1, 100), "boot_window_s": (0.0, 10.0), "debounce_samples": (1, 100),
    "reset_below_v": (0.0, 100.0), "host_buffer": (2, 4096), "program_bytes": (256, 1 << 20),
    "data_bytes": (256, 1 << 20), "index_at": (0, 1 << 20),
}  # fmt: skip


@dataclass(frozen=True)
class Options:
    """Keywords of `bench.add("smartmotor", ...)`."""

    statements_per_sample: int = 1
    """Statements of its program that the motor executes in a sample of 245,760 ns."""
    cam_multiplier: Literal["master", "table"] = "master"
    """Numbers that MC2, MC4 and MC8 multiply: counts of the external encoder, or entries of the cam table."""
    array_overlay: bool = True
    """True if aa…zz and aaa…yyy share the memory of al[0…50]."""
    boot_window_s: float = 0.2
    """Time after switching on, after which the stored program starts unless a character has been received."""
    stop_buffers: Literal["position", "same"] = "position"
    """The mode of the next G after S and X: position mode as soon as P= or D= is assigned, as hosts expect that send
    `D=n G` after a jog; or always the mode buffered before."""
    debounce_samples: int = 3
    """Samples for which pin G must be low to count as an edge."""
    host_buffer: int = 32
    """Points of host mode that the motor can store."""
    reset_below_v: float = 18.0
    """The processor is held in reset while the supply is below this voltage; 0: it never is."""
    brake: bool = False
    """True if the shaft has a static brake."""
    program_bytes: int = 32768
    """The size of the program memory."""
    data_bytes: int = 8000
    """The size of the data EEPROM."""
    load_block: Literal[8, 32] = 8
    """Bytes of a program that are sent before the motor asks for more."""
    index_at: int = 500
    """Encoder counts from the shaft's first position to the index mark."""

    def __post_init__(self) -> None:
        check(self, RANGES)
