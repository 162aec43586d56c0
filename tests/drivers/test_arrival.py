"""A move has ended well only at its target: not where a switch, a fault, another host or another request ends it."""

from contextlib import contextmanager

import pytest

from axistwin.drivers import BusyError, Scale, StoppedError, connect

from ..told import raises

AXES = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}


def by_another_host(controller, model):
    """Stop the motion as another host would, with a ramp."""
    core = controller.core
    stops = {
        "if1": lambda: core.message("#"),
        "1811": lambda: core._send_command(0x70),
        "smartmotor": lambda: core.send(b"", "X"),
    }
    controller.run(stops[model]())


@contextmanager
def moving(ports, model, **options):
    """Yield a controller, its axis in motion, and its true position as a function."""
    twin = ports.add(model, **options)
    with connect(model, model, **({"limits": True} if options and model == "smartmotor" else {})) as controller:
        axis = controller.axes[AXES[model]]
        axis.clear_faults()
        axis.move_to(80_000)
        ports.run(0.2)
        assert axis.status().moving and not axis.status().missed
        yield controller, axis, lambda: twin.axes[AXES[model]].position


@pytest.mark.parametrize("ending", ["stop", "abort"])
@pytest.mark.parametrize(("model", "options"), [
    ("if1", {}), ("1811", {}), ("1811", {"interrupts": True}), ("smartmotor", {})])  # fmt: skip
def test_a_run_that_is_stopped_has_its_true_position(ports, model, options, ending):
    twin = ports.add(model)
    with connect(model, model, **options) as controller:
        axis = controller.axes[AXES[model]]
        if model == "1811":
            axis.set_profile(acceleration=50_000)
        axis.move_at(-900)
        while not -905 < axis.status().velocity < -800:
            pass
        if model == "1811":
            raises(BusyError, "", axis.move_to, 0)
            raises(BusyError, "", axis.set_position, 0)
        getattr(axis, ending)()
        assert axis.wait(60).position == twin.axes[AXES[model]].position < 0
        axis.move_at(0)
        assert axis.position() == twin.axes[AXES[model]].position


@pytest.mark.parametrize("model", AXES)
def test_an_own_stop_and_a_run_end_at_rest(ports, model):
    with moving(ports, model) as (controller, axis, position):
        axis.stop()
        assert axis.wait(60).position == position() < 80_000
        axis.move_at(900)
        ports.run(0.5)
        by_another_host(controller, model)
        assert axis.wait(60).position == position()
        axis.set_position(7)
        assert axis.wait(1).position == 7


@pytest.mark.parametrize("model", AXES)
def test_a_limit_is_no_arrival(ports, model):
    with moving(ports, model, **{AXES[model]: {"limits": [-500, 2000]}}) as (_, axis, position):
        axis.scale = Scale(-100, "mm")
        with pytest.raises(StoppedError, match=r"^axis \w+ stopped at -2\d.* \(.*limit") as error:
            axis.wait(60)
        assert round(-100 * error.value.status.position) == position() > 2000


@pytest.mark.parametrize("model", ["1811", "smartmotor"])
def test_another_target_of_another_host_is_no_arrival(ports, model):
    with moving(ports, model) as (controller, axis, _):
        if model == "1811":
            by_another_host(controller, model)
            raises(StoppedError, "", axis.wait, 60)
            controller.run(controller.core._send_command(0x33, 0, 0, 0, 9))
        else:
            controller.run(controller.core.send(b"", "P=900 G"))
        raises(StoppedError, "another host", axis.wait, 60)


def test_a_command_that_the_board_ignores_is_no_arrival(ports):
    ports.add("1811")
    with connect("1811", "1811") as board:
        board.command(0x18, 1)  # position maintenance refuses open-loop moves
        board.axes["motor"].move_to(50)
        raises(StoppedError, "stopped at 0", board.axes["motor"].wait, 5)


def test_commands_of_ones_own_that_move_have_no_target(ports):
    ports.add("smartmotor")
    with connect("smartmotor", "smartmotor") as motor:
        shaft = motor.axes["shaft"]
        shaft.move_to(40)
        shaft.wait(5)
        motor.command("MP P=90 G")
        assert shaft.wait(5).position == 90


PATH = [(2560 * number, 400 * number) for number in range(1, 12)]
MOVES = {
    "if1": {
        "move_to": lambda if1, x: x.move_to(4400),
        "move_by": lambda if1, x: x.move_by(4400),
        "move_together": lambda if1, x: if1.move_together({"X": 4400, "Y": -4400}),
    },
    "1811": {"move_to": lambda board, motor: motor.move_to(4400), "move_by": lambda board, motor: motor.move_by(4400)},
    "smartmotor": {
        "move_to": lambda motor, shaft: shaft.move_to(4400),
        "move_by": lambda motor, shaft: shaft.move_by(4400),
        "stream": lambda motor, shaft: motor.stream([(0, 0), *PATH, PATH[-1]]),
    },
}
RUNS = {
    "if1": {"move_at": lambda if1, x: x.move_at(900), "sequence": lambda if1, x: if1.sequence(["X4400@900"])},
    "1811": {
        "move_at": lambda board, motor: motor.move_at(900),
        "sequence": lambda board, motor: (
            board.define_sequence(1, [bytes([0x33, 0, 0, 0x11, 0x30])]), board.command(0x41, 1)
        ),
        "stream_times": lambda board, motor: board.stream_times(500, 1, 1, [9000] * 10 + [0]),
    },
    "smartmotor": {"move_at": lambda motor, shaft: shaft.move_at(900),
                   "command": lambda motor, shaft: motor.command("MV V=60000 A=100 G"),
                   "cam": lambda motor, shaft: motor.cam([0, 0, 0, 0], 800)},
}  # fmt: skip
"""Motions with and without a target, from position 0 in positive direction."""


def table(motions):
    return [(model, way) for model, ways in motions.items() for way in ways]


@pytest.mark.parametrize("end", ["nobody", "a switch", "another host"])
@pytest.mark.parametrize(("model", "way"), table(MOVES))
def test_each_motion_with_a_target_succeeds_only_there(ports, model, way, end):
    twin = ports.add(model, **({AXES[model]: {"limits": [-90_000, 2000]}} if end == "a switch" else {}))
    with connect(model, model, **({"limits": end == "a switch"} if model == "smartmotor" else {})) as controller:
        axis = controller.axes[AXES[model]]
        axis.set_profile(velocity=900)
        axis.move_by(0)
        axis.wait(1)
        MOVES[model][way](controller, axis)
        if end == "nobody":
            assert axis.wait(60).position == twin.axes[AXES[model]].position == 4400
            return
        ports.run(1)
        if end == "another host":
            by_another_host(controller, model)
        error = raises(StoppedError, "another host or program" if end == "another host" else "limit", axis.wait, 60)
        assert 0 < error.status.position == axis.position() == twin.axes[AXES[model]].position < 4400


@pytest.mark.parametrize("end", ["a switch", "another host"])
@pytest.mark.parametrize("model", AXES)
def test_a_search_for_home_succeeds_only_there(ports, model, end):
    """The switch comes before home; the place does not become 0."""
    twin = ports.add(model, **({AXES[model]: {"limits": [-300, 300]}} if end == "a switch" else {}))
    options = {"if1": {"home_input": 1}, "smartmotor": {"limits": end == "a switch"}}.get(model, {})
    with connect(model, model, **options) as controller:
        axis = controller.axes[AXES[model]]
        axis.set_profile(velocity=900)
        axis.home(1)
        if end == "another host":
            ports.run(0.4)
            assert axis.status().moving
            by_another_host(controller, model)
        raises(StoppedError, "home was not found", axis.wait, 60)
        assert axis.position() == twin.axes[AXES[model]].position != 0


@pytest.mark.parametrize("end", ["a switch", "another host"])
@pytest.mark.parametrize(("model", "way"), table(RUNS))
def test_each_motion_without_a_target_ends_at_rest(ports, model, way, end):
    twin = ports.add(model, **({AXES[model]: {"limits": [-90_000, 2000]}} if end == "a switch" else {}))
    with connect(model, model, **({"limits": end == "a switch"} if model == "smartmotor" else {})) as controller:
        axis = controller.axes[AXES[model]]
        axis.move_to(40)
        axis.wait(5)
        RUNS[model][way](controller, axis)
        if end == "another host" or way == "cam":  # the master of the cam stands still
            ports.run(1)
            by_another_host(controller, model)
        status = axis.wait(60)
        assert not status.missed
        if end == "a switch" and way != "cam":
            assert twin.axes[AXES[model]].position >= 2000
            assert status.limit_plus and (status.faults or model == "1811")


@pytest.mark.parametrize(("text", "ends"), [
    ("S", True), ("OFF", True), ("MT T=0", True), ("O=500", True), ("RUN", True), ("END", True), ("GOSUB5", True),
    ("UA=1 UAO", False), ("a=5", False)])  # fmt: skip
def test_which_raw_commands_of_ones_own_end_a_move(ports, text, ends):
    ports.add("smartmotor")
    with connect("smartmotor", "smartmotor") as motor:
        motor.load("END\nC5\nRETURN\n")
        shaft = motor.axes["shaft"]
        shaft.move_to(40)
        shaft.wait(5)
        motor.command(text)
        assert (shaft.core.target is None) == ends and not shaft.status().missed


def test_a_command_of_ones_own_ends_a_search_for_home(ports):
    twin = ports.add("smartmotor")
    with connect("smartmotor", "smartmotor") as motor:
        motor.axes["shaft"].home(1)
        motor.command("X")
        assert motor.axes["shaft"].wait(5).position == twin.axes["shaft"].position
        motor.axes["shaft"].home(1)
        motor.stream([(0, 0), *PATH, PATH[-1]])
        assert motor.axes["shaft"].wait(60).position == 4400  # not 0 at the index that it passes


def test_a_sequence_is_defined_at_rest_and_moves_nothing(ports):
    """A moving board ignores D9h, and would perform the commands at once."""
    sequence = [bytes([0x33, 0, 0, 0, 9])]
    twin = ports.add("1811")
    with connect("1811", "1811") as board:
        motor = board.axes["motor"]
        motor.move_to(4000)
        raises(BusyError, "wait for the end of the motion", board.define_sequence, 1, sequence)
        assert motor.wait(60).position == twin.axes["motor"].position == 4000
        board.define_sequence(1, sequence)
        assert motor.core.target == 4000


def test_a_move_of_no_length_has_arrived_after_a_search_that_failed(ports):
    ports.add("if1")
    with connect("if1", "if1", home_input=1) as if1:
        x = if1.axes["X"]
        for move in (x.move_to, lambda target: if1.move_together({"X": target})):
            x.home(1)
            if1.message("#")
            raises(StoppedError, "home was not found", x.wait, 60)
            move(x.position())
            x.wait(1)


def test_a_shaft_that_rests_beside_its_target_has_arrived(ports):
    """Gravity holds the shaft a few counts off; the trajectory has reached the target."""
    twin = ports.add("smartmotor", shaft={"motor": "frame23"})
    with connect("smartmotor", "smartmotor") as motor:
        shaft = motor.axes["shaft"]
        shaft.move_to(4000)
        shaft.wait(25)
        twin.axes["shaft"].load(0.02)
        shaft.move_to(8000)
        assert 0 < abs(shaft.wait(25).position - 8000) < 100
        shaft.move_to(80_000)
        ports.run(0.5)
        motor.send(b"", "X")
        raises(StoppedError, "", shaft.wait, 25)
