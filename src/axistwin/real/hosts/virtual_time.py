"""The host's end of a port of a bench; all times are in virtual time."""

from axistwin.bench import Bench, Controller
from axistwin.core.units import MS, S
from axistwin.real.hosts.end import USER_BITS, End
from axistwin.sim.frames import UartFormat


class VirtualEnd(End):
    """Sends data to a virtual controller, and receives the controller's answers.  All times are in virtual time."""

    grain_s = 0.0005
    exact = True
    _STEP_S, _STEP_NS, _PHASE_NS = 0.02, 20 * MS, 10 * MS
    _BUS_GRAIN_S = 0.00002

    def __init__(self, bench: Bench, controller: Controller) -> None:
        super().__init__()
        self.bench, self.controller, self._messages = bench, controller, bytearray()
        self._host = None
        self.messages = controller.product.attend is not None
        self.has_line = not self.messages
        if controller.product.attend is not None:
            self._host = controller.product.attend(controller.bus)
            self._host.subscribe_received(self._messages.extend)
            # A board on a bus answers at once, but a SmartMotor answers at the end of a sample period.
            self.grain_s = self._BUS_GRAIN_S
        else:
            controller.serial.subscribe_received(lambda byte, _: self._messages.append(byte))
            self.frame_s = controller.serial.host.format.frame_ns / S

    def set_line(self, line: UartFormat) -> None:
        self.controller.serial.host.format = line
        self.frame_s = line.frame_ns / S

    @property
    def user_bits(self) -> int:
        return self.controller.bus.status & USER_BITS

    @property
    def now(self) -> float:
        return self.bench.now / S

    def send(self, data: bytes) -> None:
        if self._host is not None:
            self._host.write(data)
        else:
            self.controller.serial.write(data)

    def receive(self, silence_s: float = 0.0) -> bytes:
        """Advance virtual time until the controller sends data, and return the data.

        Virtual time advances by at most 20 ms, or by the multiple of 20 ms that is 20 to 40 ms less than `silence_s`.
        """
        clock = self.bench.clock
        end_ns = clock.later(max(1, int(silence_s / self._STEP_S) - 1) * self._STEP_NS)
        # The controller sends data only during events of the simulation, so check for new data after each event.
        while not self._messages:
            due_ns = clock.next_event_ns()
            if due_ns is None or due_ns > end_ns:
                clock.run_to(end_ns)
                break
            clock.step()
        return self._taken()

    def drain(self) -> bytes:
        """Return the rest of the answers to earlier requests.

        Virtual time advances to the next multiple of 10 ms.  Two controllers on two benches thus receive each request
        in the same phase of their 10 ms cycle.
        """
        self.bench.clock.run_to(-(-self.bench.now // self._PHASE_NS) * self._PHASE_NS)
        return self._taken()

    def _taken(self) -> bytes:
        data = bytes(self._messages)
        self._messages.clear()
        if self.has_line:
            self.controller.serial.read()  # else the port would keep all that it has ever received
        return data

    def close(self) -> None:
        if self._host is not None:
            self._host.close()
