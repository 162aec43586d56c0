"""Loading, storing and uploading the program (section 15 of the base language, and 2.0 item 6 of the 4.76 manual).

    host  LOAD ␣        8 bytes        8 bytes    …   the rest  FF FF
    motor        06            06             06

The program memory is invalid from LOAD until FF FF has been received: an incomplete program is not run and sets flag
Bk.  UPLOAD and UP work in the other direction: the motor sends 8 bytes, the host 06, the motor the next 8 bytes … FF.
"""

from axistwin.controllers.smartmotor.chapters import faults, flow
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.processor import Processor
from axistwin.controllers.smartmotor.serial.channel import Channel
from axistwin.core.units import MS, S

ACKNOWLEDGE, END = 0x06, 0xFF
END_OF_TEXT = bytes([END])
UPLOAD_BLOCK = 8
DECODED_AT_ONCE = 256
GIVE_UP_NS = 5 * S  # Time without a character after which a download ends.
SECOND_END_NS = 50 * MS  # Delay of the answer to an FF at a block's end; a second FF in it ends the program.


class Download:
    """Receives a program that a host sends, and stores the program."""

    def __init__(self, motor: Processor, channel: Channel) -> None:
        # lazy import: a program decoder is needed only if a host sends a program to the motor
        from axistwin.controllers.smartmotor.language.image import Decoder

        self.motor, self.channel = motor, channel
        self._decoder = Decoder()
        self._size = 0  # Number of received bytes of the program.
        self._fresh = bytearray()  # Received bytes of the program that are not decoded yet.
        self._complete = False  # True after the byte FF, which ends the text of the program.
        self._count, self._last = 0, 0
        self._sound = True
        self._last_ns = motor.clock.now
        channel.transfer = self
        self._supervise()

    def take(self, byte: int) -> None:
        """Receive a byte of the program, and acknowledge each complete block with the byte 06."""
        ended = byte == self._last == END
        self._count, self._last, self._last_ns = self._count + 1, byte, self.motor.clock.now
        self._complete |= byte == END
        if self._size == self.motor.options.program_bytes:
            # The program memory is full, so the received character is not stored.
            self._sound &= self._complete
        elif not self._complete:
            self._keep(byte)
        if ended:
            self._finish()
        elif self._count % self.motor.options.load_block == 0:
            self._answer(byte)

    def _keep(self, byte: int) -> None:
        self._size += 1
        self._fresh.append(byte)
        if len(self._fresh) == DECODED_AT_ONCE:
            self._decode()

    def _decode(self) -> None:
        self._decoder.feed(bytes(self._fresh))
        self._fresh.clear()

    def spoil(self) -> None:
        """Receive a byte with a line error, which makes the program invalid."""
        self._sound = False
        self.take(0)

    @property
    def _active(self) -> bool:
        return self.channel.transfer is self

    def _answer(self, byte: int) -> None:
        count = self._count

        def acknowledge() -> None:
            if self._active and self._count == count:
                self.channel.send(bytes((ACKNOWLEDGE,)))

        if byte == END:
            self.motor.clock.call_later(SECOND_END_NS, acknowledge)
        else:
            acknowledge()

    def _supervise(self) -> None:
        """End the download after 5 s without a character.  If a single FF was received, the program is complete."""
        if not self._active:
            return
        clock = self.motor.clock
        silent_ns = clock.now - self._last_ns
        if silent_ns >= GIVE_UP_NS:
            self._sound &= self._complete
            self._finish()
            return
        clock.call_in_background(GIVE_UP_NS - silent_ns, self._supervise)

    def _finish(self) -> None:
        self.channel.end_transfer()
        memory = self.motor.nonvolatile
        self._decode()
        memory.program, intact = self._decoder.result()
        memory.broken = not (self._sound and intact)
        memory.locked = False
        memory.save(self.motor.store)
        self.motor.catch_up()
        power_up(self.motor)
        self.motor.update_outputs()


class Upload:
    """Sends the stored program to a host, block by block."""

    def __init__(self, channel: Channel, data: bytes) -> None:
        self.channel = channel
        self._rest = data + END_OF_TEXT
        channel.transfer = self
        self._send()

    def take(self, byte: int) -> None:
        """Handle a character: 06 requests the next block; any other ends the upload and is handled as usual."""
        if byte == ACKNOWLEDGE:
            self._send()
        else:
            self.channel.end_transfer()
            self.channel.take(byte)

    def spoil(self) -> None: ...

    def _send(self) -> None:
        block, self._rest = self._rest[:UPLOAD_BLOCK], self._rest[UPLOAD_BLOCK:]
        if not self._rest:
            self.channel.end_transfer()
        self.channel.send(block)


def power_up(motor: Processor) -> None:
    """Load the program from the nonvolatile memory; if that is not valid, set Bk and have no program."""
    broken = motor.nonvolatile.broken
    motor.i[s.BK] = broken
    motor.set_program("" if broken else motor.nonvolatile.program)


def load(motor: Processor) -> None:
    """LOAD: stop the program, and receive a new program as source text or as an image.

    Comments and blanks are not stored.  LOAD is refused while a fault has not been cleared (2.0 item 6): Bs is set and
    no 06 is sent.  The new program is not locked.
    """
    channel = motor.host
    if channel is None or any(motor.i[fault] for fault in (s.BR, s.BL, s.BE, s.BH)):
        motor.syntax_error(faults.latched(motor))
        return
    flow.end(motor)
    motor.nonvolatile.program, motor.nonvolatile.broken = "", True
    motor.nonvolatile.save(motor.store)
    power_up(motor)
    Download(motor, channel)
    channel.send(bytes((ACKNOWLEDGE,)))


def upload(motor: Processor) -> None:
    """UPLOAD: send the program as readable text.  For a locked program, nothing is sent and the flag Bs is set."""
    _upload(motor, motor.nonvolatile.program.encode("latin-1"))


def upload_image(motor: Processor) -> None:
    """UP: send the program's image with header and jump targets; a locked program only sets Bs."""
    # lazy import: the function `encode` is needed only to send a program to the host
    from axistwin.controllers.smartmotor.language.image import encode

    _upload(motor, encode(motor.nonvolatile.program))


def lock(motor: Processor) -> None:
    """LOCKP: forbid uploads of the program until another program is loaded."""
    motor.nonvolatile.locked = True
    motor.nonvolatile.save(motor.store)


def checksum_report(motor: Processor) -> str:
    """RCKS: report the two checksums of the program, and P (valid) or F (invalid).

    The checksums are those of the label addresses and of the text, six hexadecimal digits each.  For a program of END
    alone the report is 000000 0000E1 P.  A report with F sets Bk.
    """
    # lazy import: only the report RCKS needs the checksums
    from axistwin.controllers.smartmotor.language.image import sums

    header, program = sums(motor.nonvolatile.program)
    if motor.nonvolatile.broken:
        motor.i[s.BK] = 1
    return f"{header:06X} {program:06X} {'F' if motor.nonvolatile.broken else 'P'}"


def _upload(motor: Processor, data: bytes) -> None:
    if motor.host is None or motor.nonvolatile.locked:
        motor.syntax_error("the stored program is locked: only a new program ends this, by LOAD")
    else:
        Upload(motor.host, data)
