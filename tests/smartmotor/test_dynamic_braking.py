"""Section 5.2 with a real motor: shorted windings brake a turning shaft; with open windings the shaft coasts."""

from itertools import pairwise

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .scripts import play, scripts
from .talking import SAMPLE_NS, ask, ready, send

MOTORS = ["frame17", "frame23", "frame34"]


def spinning(bench: Bench, name: str, torque: int = 400) -> Controller:
    """Return a motor at constant speed in torque mode."""
    motor = ready(bench, shaft={"motor": name})
    send(bench, motor, f"MT T={torque}", 1.0)
    assert abs(motor.axes["shaft"].velocity) > 10_000
    return motor


def stop(bench: Bench, motor: Controller, seconds: float = 20) -> tuple[int, int]:
    """Return the counts and the nanoseconds that the shaft still turns until it is at rest."""
    shaft = motor.axes["shaft"]
    position, start = shaft.position, bench.now
    assert bench.run_until(lambda: shaft.velocity == 0, seconds)
    return shaft.position - position, bench.now - start


def speeds(bench: Bench, motor: Controller, every: float, count: int) -> list[float]:
    """Return `count` speeds in counts per second, each averaged over an interval of `every` seconds."""
    shaft, found = motor.axes["shaft"], []
    for _ in range(count):
        before = shaft.position
        bench.run(every)
        found.append((shaft.position - before) / every)
    return found


def stopped_by(name: str, command: str, torque: int = 400) -> tuple[int, int]:
    bench = Bench()
    motor = spinning(bench, name, torque)
    send(bench, motor, command, 0)
    return stop(bench, motor)


@scripts({
    "5.2: the commands for MTB work in a program too":
    "with frame23; load MT / T=300 / WAIT=2000 / MTB / WAIT=1000 / PRINT(@V,#13) / RMODE / END; "
    "RUN -> 0 B in 1.0 s; still",
    "2.0 item 2: MTB is the mode at power-up":
    "with frame23; MT T=400; 1.0 s; moving; power off; 0.01 s; power on; 0.3 s; RMODE RBo -> B 1; 1 s; still",
})  # fmt: skip
def test_dynamic_braking(script):
    play(script)


@pytest.mark.parametrize("name", MOTORS)
def test_mtb_stops_a_turning_shaft_much_sooner_than_coasting(name):
    """5.2, MTB: "a resistance torque [that] helps decelerate the motor"; 3.2: else "freewheel coast to a stop"."""
    braked, braked_ns = stopped_by(name, "MTB")
    coasted, coasted_ns = stopped_by(name, "BRKRLS OFF")
    assert 0 < braked < coasted / 3 and 0 < braked_ns < coasted_ns / 3


@pytest.mark.parametrize("name", MOTORS)
def test_braking_is_the_same_in_both_directions(name):
    """5.2: a resistance in both directions."""
    right, right_ns = stopped_by(name, "MTB", 400)
    left, left_ns = stopped_by(name, "MTB", -400)
    assert abs(right + left) <= 1 and abs(right_ns - left_ns) <= 2 * SAMPLE_NS


@pytest.mark.parametrize("command", ["MTB", "BRKRLS OFF"])
def test_a_shaft_that_is_not_driven_only_becomes_slower_and_never_turns_back(bench, command):
    """5.2: a resistance torque cannot drive."""
    motor = spinning(bench, "frame23")
    send(bench, motor, command, 0)
    bench.clock.run_to(-(-bench.now // SAMPLE_NS) * SAMPLE_NS)
    places = [motor.axes["shaft"].position]
    for _ in range(400):
        bench.clock.run_to(bench.now + 4 * SAMPLE_NS)
        places.append(motor.axes["shaft"].position)
    ways = [later - earlier for earlier, later in pairwise(places)]
    assert all(later <= earlier + 1 for earlier, later in pairwise(ways))  # one count of rounding
    assert min(ways) >= 0


def test_off_brakes_with_brksrv(bench):
    """5.2: "when the motor is off for any reason, MTB will be active"."""
    assert stopped_by("frame23", "OFF") == stopped_by("frame23", "MTB")


def test_brkrls_alone_does_not_end_mtb():
    """5.2: MTB ends with BRKRLS and then OFF; in the other order the windings stay shorted."""
    braked = stopped_by("frame23", "MTB")[0]
    assert stopped_by("frame23", "OFF BRKRLS")[0] == braked and stopped_by("frame23", "BRKRLS MTB")[0] == braked


def test_mtb_after_coasting_has_begun(bench):
    """5.2: "To re-enable the mode torque brake issue MTB again"."""
    motor = spinning(bench, "frame23")
    send(bench, motor, "BRKRLS OFF", 0.02)
    assert motor.axes["shaft"].velocity > 10_000
    send(bench, motor, "MTB", 0)
    assert ask(bench, motor, "RMODE", 0) == "B" and stop(bench, motor)[1] < 100_000_000


def test_shorted_windings_give_way_to_a_load_at_a_speed_that_grows_with_it(bench):
    """5.2: "applies braking torque to a *moving* motor shaft": the speed is proportional to the torque above friction.

    Three equally spaced torques, much larger than friction, give three equally spaced speeds.
    """
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "BRKRLS MTB BRKRLS")
    found = []
    for torque in (0.1, 0.2, 0.3):
        motor.axes["shaft"].load(torque)
        bench.run(0.5)
        found.append(abs(speeds(bench, motor, 0.5, 1)[0]))
    assert 0 < found[0] < found[1] < found[2] and found[2] - found[1] == pytest.approx(found[1] - found[0], rel=0.05)


def test_without_mtb_a_load_accelerates_the_shaft(bench):
    """3.2: without MTB the shaft is free, so a load accelerates it."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "BRKRLS OFF")
    motor.axes["shaft"].load(0.1)
    found = [abs(speed) for speed in speeds(bench, motor, 0.01, 5)]
    assert found[0] < found[1] < found[2] < found[3] < found[4]
    assert found[4] - found[3] == pytest.approx(found[1] - found[0], rel=0.1)  # the acceleration is constant


def test_the_position_is_counted_while_braking_and_while_coasting(bench):
    """4 of the base language, OFF: "position tracking continues"."""
    motor = spinning(bench, "frame23")
    send(bench, motor, "BRKRLS OFF", 0.05)
    assert ask(bench, motor, "RP", 0) == str(motor.axes["shaft"].position)
    send(bench, motor, "MTB", 0.5)
    assert ask(bench, motor, "RP", 0) == str(motor.axes["shaft"].position)


def wired(bench: Bench, motor: Controller) -> None:
    motor.pins["C"].drive(False)
    motor.pins["D"].drive(False)
    send(bench, motor, "UCP UDM ZS", 0.01)


@pytest.mark.parametrize(("words", "letter", "off"), [("", "B", "1"), ("BRKRLS OFF", "O", "1")])
def test_a_limit_while_turning(bench, words, letter, off):
    """3.2 note 3.1: with MTB the motor will "rapidly and dynamically brake", else "freewheel coast to a stop"."""
    motor = ready(bench, shaft={"motor": "frame23"})
    wired(bench, motor)
    send(bench, motor, f"{words} MT T=400", 0.5)
    motor.pins["C"].drive(True)
    bench.run(0.002)
    assert send(bench, motor, "RMODE RBo", 0) == f"{letter}\r{off}\r".encode()
    _, lasted_ns = stop(bench, motor)
    assert (lasted_ns < 50_000_000) is (letter == "B")


def test_the_trajectory_follows_the_shaft_after_a_stop_by_mtb(bench):
    """After a stop by MTB a move begins at the shaft's resting position, without a jump back or a position error."""
    motor = spinning(bench, "frame23")
    send(bench, motor, "MTB", 0.5)
    at = motor.axes["shaft"].position
    send(bench, motor, "MP A=100 V=100000 D=0 G", 0.2)
    assert abs(motor.axes["shaft"].position - at) <= 2 and send(bench, motor, "RBe RBo") == b"0\r0\r"


@pytest.mark.parametrize("command", ["MTB", "BRKRLS OFF"])
def test_the_same_stop_whole_or_in_pieces(command):
    """The division of virtual time does not matter: the same inputs at the same times give the same counts."""

    def course(pieces: int) -> list[int]:
        bench = Bench()
        motor = spinning(bench, "frame34")
        send(bench, motor, command, 0)
        found = []
        for _ in range(5):
            for _ in range(pieces):
                bench.clock.run_to(bench.now + 12_000_000 // pieces)
            found.append(motor.axes["shaft"].position)
        return found

    assert course(1) == course(1) == course(96)


@pytest.mark.parametrize("name", MOTORS)
def test_bt_and_brake_with_brktrj_on_a_real_motor(bench, name):
    """5.2: at the end of the trajectory the windings are shorted, and the shaft stays near its target."""
    motor = ready(bench, shaft={"motor": name})
    send(bench, motor, "BRKTRJ A=50 V=100000 P=5000 G", 1.5)
    assert send(bench, motor, "RBt RMODE") == b"0\rB\r" and abs(motor.axes["shaft"].position - 5000) < 50
