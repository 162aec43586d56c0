"""Chapter 5: brake commands in any order, compared with an independent model of the chapter's rules."""

from dataclasses import dataclass

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ready, send

SHORT = "MP A=65536 V=65536*4 D=40 G"  # ends within 20 samples
LONG = "MV A=65536 V=65536 G"
WORDS = [
    "BRKSRV",
    "BRKTRJ",
    "BRKRLS",
    "BRKENG",
    "BRKI",
    "BRKC",
    "BRKG",
    "MTB",
    "OFF",
    SHORT,
    LONG,
    "S D=0",  # the next G is a position move, which ends at once
    "X D=0",
    "G",
    "MF4",
]


@dataclass
class Rules:
    """A model of the rules of 5.1 and 5.2."""

    control: str = "BRKSRV"
    routing: str = "BRKI"
    enabled: bool = True  # MTB has not been disabled by BRKRLS and OFF
    servo: bool = False
    trajectory: bool = False
    for_ever: bool = False  # true if the move of G does not end by itself

    def obey(self, word: str) -> None:
        """Update the model to the state a long time after this command."""
        if word in {"BRKI", "BRKC", "BRKG"}:
            self.routing = word
        elif word.startswith("BRK"):
            self.control = word
        elif word == "MTB":
            self.enabled, self.servo, self.trajectory = True, False, False
        elif word == "OFF":
            self.enabled = self.enabled and self.control != "BRKRLS"
            self.servo = self.trajectory = False
        elif word in {"S D=0", "X D=0"}:
            self.servo, self.trajectory, self.for_ever = True, False, False
        else:
            self.for_ever = word in {LONG, "MF4"} or (word == "G" and self.for_ever)
            self.servo, self.trajectory = True, self.for_ever
        if self.control == "BRKTRJ" and self.enabled and not self.trajectory:
            self.servo = False

    @property
    def engaged(self) -> bool:
        by_control = {"BRKSRV": not self.servo, "BRKTRJ": not self.trajectory, "BRKRLS": False, "BRKENG": True}
        return by_control[self.control]

    @property
    def shorted(self) -> bool:
        """True if MTB shorts the windings."""
        return self.enabled and not self.servo


def said(bench: Bench, motor: Controller) -> tuple[bool, bool, bool]:
    """Return Bo, Bt, and True if RMODE reports B."""
    off, busy, mode = send(bench, motor, "RBo RBt RMODE").split()
    return off == b"1", busy == b"1", mode == b"B"


@settings(deadline=None, max_examples=50)
@given(words=st.lists(st.sampled_from(WORDS), max_size=14))
def test_any_order_of_brake_commands(words):
    """The internal brake, the signal on pin C or G, Bo, Bt and RMODE agree with the model after each command."""
    bench = Bench()
    motor = ready(bench)
    send(bench, motor, "UCO UGO")
    rules = Rules()
    for word in words:
        if word in {"S D=0", "X D=0"} and not rules.servo:
            continue  # the manual does not define the effect of these commands on a motor that is off
        send(bench, motor, word, 0.02)
        rules.obey(word)
        assert said(bench, motor) == (not rules.servo, rules.trajectory, rules.shorted)
        assert motor.pins["brake"].level is rules.engaged
        for routing, name in (("BRKC", "C"), ("BRKG", "G")):
            if rules.routing == routing:
                assert motor.pins[name].level is rules.engaged
