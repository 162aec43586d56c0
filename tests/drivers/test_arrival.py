"""A move has ended well only at its target: not where a switch, a fault, another host or another request ends it."""

from contextlib import contextmanager

import pytest

from axistwin.drivers import Scale, StoppedError, connect

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


@pytest.mark.parametrize("model", AXES)
def test_a_stop_by_another_host_is_no_arrival(ports, model):
    with moving(ports, model) as (controller, axis, position):
        by_another_host(controller, model)
        with pytest.raises(StoppedError, match=r"the target was not reached \(another host or program") as error:
            axis.wait(60)
        assert 0 < error.value.status.position == position() < 80_000
        axis.move_to(400)  # as the message says: begin the motion again
        assert axis.wait(60).position == position() == 400


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
            with pytest.raises(StoppedError):
                axis.wait(60)
            controller.run(controller.core._send_command(0x33, 0, 0, 0, 9))
        else:
            controller.run(controller.core.send(b"", "P=900 G"))
        with pytest.raises(StoppedError, match="another host"):
            axis.wait(60)


def test_a_command_that_the_board_ignores_is_no_arrival(ports):
    ports.add("1811")
    with connect("1811", "1811") as board:
        board.command(0x18, 1)  # position maintenance refuses open-loop moves
        board.axes["motor"].move_to(50)
        with pytest.raises(StoppedError, match="stopped at 0"):
            board.axes["motor"].wait(5)


def test_commands_of_ones_own_that_move_have_no_target(ports):
    ports.add("smartmotor")
    with connect("smartmotor", "smartmotor") as motor:
        shaft = motor.axes["shaft"]
        shaft.move_to(40)
        shaft.wait(5)
        motor.command("MP P=90 G")
        assert shaft.wait(5).position == 90


def test_a_search_for_home_that_another_host_stops(ports):
    """The IF1 has no position of its own: a stop before the switch must not make the place zero."""
    twin = ports.add("if1")
    with connect("if1", "if1", home_input=1) as if1:
        x = if1.axes["X"]
        x.home(1)
        ports.run(1)
        if1.message("#")
        with pytest.raises(StoppedError, match="home was not found"):
            x.wait(60)
        assert x.position() == twin.axes["X"].position > 0


def test_a_shaft_that_rests_beside_its_target_has_arrived(ports):
    """Gravity holds the shaft a few counts off; the trajectory has reached the target."""
    twin = ports.add("smartmotor", shaft={"motor": "frame23"})
    with connect("smartmotor", "smartmotor") as motor:
        shaft = motor.axes["shaft"]
        shaft.move_to(4000)
        shaft.wait(25)
        twin.axes["shaft"].load(0.02)
        shaft.move_to(8000)
        status = shaft.wait(25)
        assert 0 < abs(status.position - 8000) < 100
        shaft.move_to(80_000)
        ports.run(0.5)
        motor.send(b"", "X")
        with pytest.raises(StoppedError):
            shaft.wait(25)
