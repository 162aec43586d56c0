"""Orders: the messages of a host that start and stop a stored program, as defined by its product."""

import pytest

from axistwin import Bench
from axistwin.bench import host_at, product
from axistwin.controllers.registry import OURS


def board(bench):
    """Return an 1811 with a sequence 2 that waits for 1 s, and then for 7 s."""
    controller = bench.add("1811", "board")
    bench.run(2)
    say(bench, "board", *map(bytes, ((0xD9, 2), (0x29, 0, 0, 0x03, 0xE8), (0x2A, 0, 7), (0xD8,))))
    return controller


def say(bench, name, *messages, seconds=0.5):
    with host_at(bench, name) as host:
        for message in messages:
            host.write(message)
            bench.run(seconds)


def order(bench, controller, program, label):
    says = next(each.says for each in controller.product.orders(program) if each.label == label)
    say(bench, controller.name, says, seconds=0.1)
    return controller.programs[program].running


@pytest.mark.parametrize("model", OURS)
def test_each_program_has_orders_that_differ(model):
    made = product(model)
    for program in made.programs:
        orders = made.orders(program)
        assert len({each.label for each in orders}) == len({each.says for each in orders}) == len(orders) > 1
        assert all(each.doc for each in orders)


def test_a_sequence_of_a_board_is_performed_suspended_continued_and_discontinued():
    bench = Bench()
    controller = board(bench)
    assert order(bench, controller, "sequence 2", "perform") == 0
    assert order(bench, controller, "sequence 2", "suspend") == 0
    bench.run(3)
    assert controller.programs["sequence 2"].running == 0  # command 0 has ended, and the sequence is suspended
    assert order(bench, controller, "sequence 2", "continue") == 1
    assert order(bench, controller, "sequence 2", "discontinue") == 1
    bench.run(8)
    assert controller.programs["sequence 2"].running is None


def test_a_sequence_of_a_board_is_killed():
    bench = Bench()
    controller = board(bench)
    assert order(bench, controller, "sequence 2", "perform") == 0
    assert order(bench, controller, "sequence 2", "kill") is None


def test_the_sequence_of_an_interface_is_carried_out_again_and_cancelled():
    bench = Bench()
    controller = bench.add("if2", "table")
    bench.run(1.5)
    say(bench, "table", b"(", b"U61\r", seconds=1.3)
    say(bench, "table", b":S1:H1:R1:$\r", seconds=0.2)
    assert controller.programs["sequence"].running == 1  # command 1 waits for input 1
    assert order(bench, controller, "sequence", "cancel #") is None
    assert controller.pins["output1"].level and order(bench, controller, "sequence", "start :$") == 1
    controller.pins["input1"].drive(True)
    bench.run(0.1)
    assert (controller.programs["sequence"].running, controller.pins["output1"].level) == (None, False)
