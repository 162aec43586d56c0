"""A long scripted run of a motor, divided in any way, and a record of all its outputs."""

from random import Random

from axistwin import Bench

from .talking import SAMPLE_NS, load, ready

PROGRAM = """
UAI UBI UEO UFO
F=64
e=0
GOSUB5
MP
A=150 V=300000
WHILE e<6
  e=e+1
  UE=e&1
  P=e*700-(e%3)*900
  G
  WHILE Bt
    IF @P>400
      UF=1
    ELSE
      UF=0
    ENDIF
    f=f+@PE
  LOOP
  TWAIT
  WAIT=30
  PRINT("at ",@P," ",f%1000,#13)
LOOP
MFMUL=3 MFDIV=7 MFR G
WAIT=2000
PRINT("followed ",CTR,#13)
MV V=100000 G
END
C2
  g=g+1
  PRINT("pin ",g,#13)
RETURNI
C5
  al[30]=12345
  PRINT(al[30],#13)
RETURN
"""
END_NS = 3_100_000_000


class Day:
    """A motor with its program and wiring, and a record of its outputs."""

    def __init__(self, model="frame23"):
        self.bench = bench = Bench()
        shaft = {"limits": (-3000, 20_000)} | ({"motor": model} if model else {})
        self.motor = motor = ready(bench, shaft=shaft)
        load(bench, motor, PROGRAM)
        self.pins = []
        for name in (*"ABCDEFG", "brake", "index"):
            motor.pins[name].subscribe(lambda pin, name=name: self.pins.append((bench.now, name, bool(pin.level))))
        self.samples = {}
        motor.axes["shaft"].subscribe(self._sampled)
        self.begin_ns = bench.now
        self.said = b""
        self.hears = []

    def _sampled(self, samples):
        for n, place in enumerate(zip(samples.positions, samples.commanded, strict=True)):
            self.samples[samples.time_ns(n)] = tuple(map(int, place))

    def script(self):
        """Return the actions of the script with their times."""
        motor, shaft, said = self.motor, self.motor.axes["shaft"], self.motor.serial.write
        return [
            (0, lambda: said(b"RUN ")),
            (40_000_000, lambda: motor.pins["G"].drive(False)),
            (41_000_001, lambda: motor.pins["G"].drive(True)),
            (90_123_456, lambda: said(b"RP RPE RW a=a+1 Ra ")),
            (200_000_000, lambda: shaft.load(0.05)),
            (300_000_000, lambda: motor.pins["G"].drive(False)),
            (300_100_000, lambda: motor.pins["G"].drive(True)),  # too short to count as a level
            (800_000_000, lambda: said(b"KP=80 F RV ")),
            (1_000_000_000, lambda: shaft.encoder.displace(40)),
            (2_000_000_000, lambda: motor.master.move(9000, 0.3)),
            (2_200_000_007, lambda: motor.master.move(-5000, 0.2)),
            (2_500_000_000, lambda: said(b"RMODE RCTR ")),
            (2_600_000_000, lambda: said(b"X ")),
            (2_700_000_000, lambda: shaft.jam(True)),
            (2_750_000_000, lambda: said(b"P=0 MP G ")),
            (END_NS, lambda: said(b"RP RW ")),
            (END_NS + 10_000_000, lambda: None),
        ]

    def live(self, passing):
        """Execute the whole script; `passing(day, ns)` advances the clock."""
        for at, action in self.script():
            passing(self, self.begin_ns + at - self.bench.now)
            action()
        return self.seen()

    def seen(self):
        """Return bytes, pin levels, and each change of the actual and commanded positions."""
        self.motor.axes["shaft"].catch_up()
        self.said += self.motor.serial.read()
        places, before = [], None
        for time, place in sorted(self.samples.items()):
            if place != before:
                places.append((time, *place))
            before = place
        return [self.said.decode("latin-1"), self.pins, places]


def whole(day, ns):
    """Advance the clock in one step."""
    day.bench.run(ns / 1e9)


def watched(day, ns):
    """Advance the clock, reading the position at every event."""
    shaft = day.motor.axes["shaft"]
    day.bench.run_until(lambda: shaft.position == 1 << 40, ns / 1e9)


def by_chance(seed):
    """Advance the clock in random steps, with random reads in between."""
    random = Random(seed)

    def passing(day, ns):
        end = day.bench.now + ns
        while day.bench.now < end:
            some = random.choice([1, SAMPLE_NS, SAMPLE_NS // 2, random.randint(1, 300 * SAMPLE_NS), ns])
            day.bench.run(min(some, end - day.bench.now) / 1e9)
            look(random, day)

    return passing


def look(random, day):
    motor, shaft = day.motor, day.motor.axes["shaft"]
    random.choice([
        lambda: shaft.position, lambda: shaft.commanded, lambda: shaft.velocity, lambda: shaft.moving,
        lambda: shaft.temperature, shaft.catch_up, lambda: motor.pins["E"].level, lambda: motor.pins["index"].level,
        lambda: motor.master.count, lambda: shaft.pulse_times(), lambda: None,
    ])()  # fmt: skip
    if random.random() < 0.2:
        day.said += motor.serial.read()
