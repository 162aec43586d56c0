"""`axistwin demo`: a short session with each kind of controller: messages, moves, and a picture.

The sessions are also an example: they control the hardware only through `from axistwin import Bench`.
"""

from pathlib import Path

import click

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.bench.codec import word
from axistwin.cli.common.parameters import FILE
from axistwin.core.version import VERSION
from axistwin.scenes.reports import transcript
from axistwin.scenes.reports.columns import columns
from axistwin.scenes.reports.run_record import recording_run

COLOURS = {">": None, "<": "green", "!": "magenta", "=": "cyan"}
"""Colour of each kind of line: message of the host, message of the controller, action, reached state."""
WIDTH = 22  # Width of the column of messages in characters; after a longer message, its note is on the next line.

NEXT = (
    ("axistwin learn if1", "six short lessons about an IF1"),
    ("axistwin term if1", "a terminal for an IF1"),
    ("axistwin serve if1 --tcp :5001 --show-hosts", "an IF1 for your host program"),
    ("axistwin run if1 moves.if1 --plot moves.png", "your own command lines"),
    ("axistwin run smartmotor home.sms --plot home.png", "the program of a motor"),
    ("axistwin check if1 moves.if1", "errors in command lines"),
    ("axistwin commands if1", "all commands of an IF1"),
)


@click.command()
@click.option("--plot", type=FILE, default=Path("axistwin-demo.png"), show_default=True,
              help="The picture: FILE.png or FILE.svg.")  # fmt: skip
def demo(plot: Path) -> None:
    """Run a short demonstration of all emulated controllers.

    An IF1 moves three motors, an IF2 survives a power cut, an 1811 moves by opcodes, a SmartMotor runs into a limit
    switch and its shaft is held.  Everything is computed in virtual time, as fast as possible.  A picture of the IF1's
    moves is written to the current directory, or to the file given by --plot.

    \b
    Examples:
      axistwin demo
      axistwin demo --plot /tmp/demo.svg
    """
    from axistwin.records.plots.picture import check_suffix, save
    from axistwin.records.plots.trace_chart import of_trace
    from axistwin.records.traces.memory import tracing_in_memory

    check_suffix(plot)
    click.secho(f"axistwin {VERSION}: legacy motion controllers without the hardware", bold=True)
    bench = Bench()
    if1 = bench.add("if1", X={"limits": (-500, 6500)})
    with recording_run(bench) as record, tracing_in_memory(bench) as memory:
        three_motors(_Session(bench, if1))
    power_cut()
    two_registers()
    motor_with_a_language()
    _chapter("What the IF1 has moved")
    for line in transcript.summary(record):
        click.echo(f"    {line}")
    save(of_trace(memory.trace(), title="axistwin demo: an IF1 moves three motors"), plot)
    _chapter(f"Drawn in {plot}.  And now:")
    for line in columns(NEXT):
        click.echo(f"    {line}")


def three_motors(if1: "_Session") -> None:
    _chapter("An IF1 is switched on, and detects the baud rate of its host")
    if1.wait(1.5)
    if1.say("(", "its first bits tell the baud rate", end="")
    if1.receive("it was 9600")
    if1.say("U61", "8 data bits, 2 stop bits, no parity")
    if1.wait(1.2)

    _chapter("It runs motors")
    if1.say("^20", "from now on ramps of 20,000 steps/s²")
    if1.wait(1.1)
    if1.explain("its new ramp takes it a second")
    if1.say("X4000@4000$", "X by 4000 steps, at 4000 steps/s")
    if1.wait(0.3)
    if1.ask("E", "it is busy")
    if1.ask("N", "at speed it counts by 256 steps")
    if1.come_to_rest()
    if1.show_positions("X", "Y")
    if1.say("X-2000/Y1000@3000$", "a straight line: Y at half the speed")
    if1.come_to_rest()
    if1.show_positions("X", "Y")

    _chapter("It waits for a button, and drills two holes")
    if1.say(":H1Z400@2000S1:P0,20:Z-R1:=1,1:$", "input 1: down, drill, 200 ms, up; once more")
    if1.wait(0.3)
    if1.press("input1", True)
    if1.ask("O", "step 1 is being executed")
    if1.wait(1.6)
    if1.press("input1", False)
    if1.show_positions("Z")

    _chapter("It runs X into a limit switch, and away from it")
    if1.say("X@4000G$", "no distance: a run without end")
    if1.come_to_rest()
    if1.ask("K", "limit; asking has cleared it")
    steps = if1.ask("N", "steps since the run began")
    if1.say(f"X-{steps}$", "as many the other way")
    if1.come_to_rest()
    if1.show_positions("X")


def power_cut() -> None:
    bench = Bench()
    if2 = _Session(bench, bench.add("if2", wiring="3-wire"))
    _chapter("An IF2 keeps its sequence through a power cut, and then needs no host")
    if2.wait(1.5)
    if2.say("(", "", end="")
    if2.receive("")
    if2.say("U61")
    if2.wait(1.2)
    if2.say("@2000", "2000 steps/s")
    if2.say(":H1X800:L1X-:=0,1:$", "input 1 high: out, low: back; without end")
    if2.say("[", "locked: that is kept without power")
    if2.power(False)
    if2.wait(0.5)
    if2.power(True)
    if2.wait(1.5)
    if2.explain("its battery has kept the sequence")
    if2.press("input1", True)
    if2.come_to_rest()
    if2.show_positions("X")
    if2.press("input1", False)
    if2.come_to_rest()
    if2.show_positions("X")
    if2.ask("E", "locked: it accepts report requests only")


def two_registers() -> None:
    bench = Bench()
    board = _BoardSession(bench, bench.add("1811"))
    _chapter("An 1811 has two registers on a Multibus, and is controlled by opcodes")
    board.wait(1.1)
    board.say("31 00 00 00 00 61 A8 00 03 D0 90", "default move: 25,000 pulses/s, 250,000 pulses/s²")
    board.say("33 00 00 C3 50", "go 50,000 pulses")
    board.wait(1.0)
    board.ask("80", "pulses issued so far")
    board.come_to_rest()
    board.show_positions("motor")
    board.ask("83", "C3 50 hex are 50,000 pulses from absolute zero")


def motor_with_a_language() -> None:
    bench = Bench()
    motor = _MotorSession(bench, bench.add("smartmotor", shaft={"motor": "frame23", "limits": (-1000, 9000)}))
    _chapter("A SmartMotor is a servo motor with a language of its own")
    motor.wait(0.3)
    motor.ask("RSP", "245.76 µs from sample to sample; firmware 4.76")
    motor.say("MP A=300 V=400000 P=6000 G", "to 6000 counts, with its own units of speed")
    motor.wait(0.2)
    motor.ask("RP", "its position now")
    motor.come_to_rest()
    motor.ask("RPE", "position error in counts")
    motor.say("MV G", "without end: the switch at 9000 stops it")
    motor.come_to_rest()
    motor.ask("RMODE", "B: its windings are shorted, which brakes it")
    motor.show_positions("shaft")
    motor.say("ZS MP P=0 G", "the fault is cleared; away from the switch")
    motor.wait(0.2)
    motor.jam()
    motor.wait(0.5)
    motor.ask("RBe", "position error too large: the motor is off")
    motor.show_positions("shaft")


class _Session:
    def __init__(self, bench: Bench, controller: Controller) -> None:
        self.bench, self.controller = bench, controller
        self.received = b""

    def say(self, text: str, note: str = "", end: str = "\r") -> None:
        data = (text + end).encode()
        self._print(">", "".join(map(word, data)), note)
        self.controller.serial.write(data)
        self.bench.run(0.002 + 0.00115 * len(data))  # A character of 11 bits takes 1.15 ms at 9600 baud.

    def receive(self, note: str) -> None:
        self.received = b""
        self.bench.run_until(self._answered, 2.0)
        self._print("<", "".join(map(word, self.received)), note)

    def _answered(self) -> bool:
        self.received += self.controller.serial.read()
        return self.received.endswith(b"\r")

    def ask(self, question: str, note: str) -> str:
        self.say(question)
        self.receive(note)
        return self.received.decode().strip()

    def wait(self, seconds: float) -> None:
        self.bench.run(seconds)

    def press(self, button: str, down: bool) -> None:
        self.controller.pins[button].drive(down)
        self._print(
            "!", f"{button} {'high' if down else 'low'}", "the button is pressed" if down else "the button is released"
        )
        self.bench.run(0.01)

    def power(self, on: bool) -> None:
        self.controller.power(on)
        self._print("!", f"power {'on' if on else 'off'}", "")

    def come_to_rest(self) -> None:
        axes = self.controller.axes.values()
        self.bench.run_until(lambda: not any(axis.velocity for axis in axes), 60.0)
        self.bench.run(0.01)

    def show_positions(self, *names: str) -> None:
        self._print("=", ", ".join(f"{name} {self.controller.axes[name].position}" for name in names), "")

    def _print(self, mark: str, what: str, note: str) -> None:
        time = click.style(f"{self.bench.seconds:9.3f} s", dim=True)
        said = f"  {time}  {click.style(f'{mark} {what}', fg=COLOURS[mark])}"
        if len(what) > WIDTH:
            click.echo(said)
            self.explain(note)
        else:
            gap = " " * (WIDTH - len(what) + 2)
            click.echo(said + (gap + click.style(note, dim=True)) * bool(note))

    def explain(self, note: str) -> None:
        click.secho(f"{' ' * (WIDTH + 19)}{note}", dim=True)


class _MotorSession(_Session):
    def come_to_rest(self) -> None:
        while self.controller.axes["shaft"].moving:
            self.bench.run(0.01)

    def jam(self) -> None:
        self.controller.axes["shaft"].jam()
        self._print("!", "shaft.jam on", "the shaft is held")


class _BoardSession(_Session):
    def say(self, text: str, note: str = "", end: str = "") -> None:
        """Write a command to the board, and set bit 4 of its control byte (CB)."""
        bus = self.controller.bus
        self._print(">", text + end, note)
        for byte in bytes.fromhex(text):
            bus.write(0, byte)
        bus.write(1, 0x10)
        self.bench.run_until(lambda: bus.read(1) & 0x10, 1.0)

    def receive(self, note: str) -> None:
        """Wait for SB bit 3, read a message, and set CB bit 7."""
        bus = self.controller.bus
        self.bench.run_until(lambda: bus.read(1) & 0x08, 1.0)
        self.received = bytes(bus.read(0) for _ in range(16))
        bus.write(1, 0x80)
        self._print("<", self.received.hex(" ").upper(), note)

    def ask(self, question: str, note: str) -> str:
        self.say(question)
        self.receive(note)
        return self.received.hex()


def _chapter(title: str) -> None:
    click.echo()
    click.secho(title, bold=True)
