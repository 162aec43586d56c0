"""The driver of the 1810 and 1811 at a bus."""

import pytest

from axistwin.drivers import MESSAGE, RefusedError, SilentError, WrongAnswerError, connect

from ..told import raises


@pytest.fixture(params=[False, True], ids=["polling", "interrupts"])
def interrupts(request):
    return request.param


@pytest.fixture
def twin(ports):
    return ports.add("1811")


@pytest.fixture
def board(twin, interrupts):
    with connect("1811", "1811", interrupts=interrupts) as controller:
        yield controller


def true_position(twin):
    return twin.axes["motor"].position


def test_moves_end_at_the_exact_position(twin, board):
    motor = board.axes["motor"]
    motor.move_to(400)
    assert motor.wait(25).position == 400
    motor.move_by(-1000)
    assert motor.wait(25).position == true_position(twin) == -600
    motor.move_to(-600)
    assert not motor.status().moving
    motor.set_position(70)
    motor.set_profile(velocity=60_000, acceleration=1_000_000)
    motor.move_to(80)
    assert motor.wait(25).position == 80 and true_position(twin) == -590


def test_messages_before_a_new_connection_are_discarded(ports, twin, board):
    board.command(0xA5, 1)  # a message at each end of motion
    board.axes["motor"].move_to(50)
    assert ports.run_until(lambda: twin.bus.read(1) & MESSAGE, 25)
    board.close()
    assert board.request(0x97) and not board.take_messages()


def test_a_distance_beyond_the_counter_is_refused(board):
    motor = board.axes["motor"]
    motor.set_position(2**31 - 1)
    raises(RefusedError, "at most 2147483647 pulses", motor.move_to, -10)


def test_without_a_marker_a_reset_is_not_noticed(ports, twin):
    with connect("1811", "1811", marker_bit=None) as board:
        board.axes["motor"].move_to(30)
        board.axes["motor"].wait(25)
        twin.power_cycle()
        ports.run(1.5)
        assert not board.axes["motor"].status().lost


def test_home(ports, interrupts):
    twin = ports.add("1811", motor={"home": [150, 5000]})
    with connect("1811", "1811", interrupts=interrupts, home_edge_ccw=True) as board:
        motor = board.axes["motor"]
        motor.set_profile(velocity=2000, acceleration=100_000)
        motor.home(1)
        status = motor.wait(50)
        assert (status.position, status.faults) == (0, ())
        assert abs(true_position(twin) - 150) <= 1 or abs(true_position(twin) - 5000) <= 1


def test_events_sequences_closed_loop_and_streams(twin, board):
    board.command(0xA5, 1)  # a message at each end of motion
    board.axes["motor"].move_to(50)
    board.axes["motor"].wait(25)
    while not (messages := board.take_messages()):
        pass
    assert messages[0][0] == 0xA5
    board.define_sequence(1, [bytes([0x0C, 1]), bytes([0x0C, 2])])
    board.command(0x41, 1)
    assert board.request(0x97)[0] == 0
    board.outputs(True, False)
    assert board.request(0x97)[0] == 2 and board.triggers().keys() == {2, 3, 4, 5}
    board.closed_loop((4, 1), 25_000, 0)
    assert board.request(0x9C)[:4] == bytes([0, 4, 0, 1]) and isinstance(board.encoder(), int)
    board.command(1, 7)
    while not (messages := board.take_messages()):
        pass
    assert messages[0][:2] == bytes([1, 7])
    for wrong in ([100], [], [0x8000, 0]):
        with pytest.raises(RefusedError, match=r"-32767 to 32767|0 as the last"):
            board.stream_times(2, 4, 1, wrong)
    board.stream_times(2, 4, 1, [100, -100, 0])
    while board.axes["motor"].status().moving:
        pass
    board.command(0x50)


def test_a_stream_longer_than_the_buffer_is_refilled(twin, board):
    board.stream_times(20, 1, 1, [100] * 250 + [-40] * 99 + [0])
    assert not board.axes["motor"].wait(50).moving
    updates = 13_107_200 / 3 / 65_536 * 0.02
    expected = updates * (250 * 100 - 99 * 40)
    assert abs(true_position(twin) - expected) < 350  # each update may lose the fraction of a pulse


def status(request, byte):
    """Return the answer to `r 1` or `r 1 COUNT` of a board with this status byte."""
    count = int(request.split()[-1]) if len(request.split()) == 3 else 1
    return b" ".join([byte] * count) + b"\n"


@pytest.mark.parametrize(("answer", "says"), [
    (b"error: no\n", "error: no"), (b"zz\n", "hex bytes"), (b"10 10\n", "hex bytes")])  # fmt: skip
def test_garbage_raises_a_clear_error(ports, answer, says):
    with pytest.raises(WrongAnswerError, match=says):
        connect(ports.answering(lambda data: answer if data.strip() else b""), "1811", timeout=0.1)


def test_a_write_that_is_not_accepted(ports):
    port = ports.answering(lambda data: status(data, b"10") if b"r" in data else b"?\n" if data.strip() else b"")
    raises(WrongAnswerError, "expected ok", connect, port, "1811", timeout=0.1)


def test_a_board_that_is_never_ready(ports):
    with pytest.raises(SilentError, match="not ready"):
        connect(ports.answering(lambda data: status(data, b"00") if data.strip() else b""), "1811", timeout=0.2)
