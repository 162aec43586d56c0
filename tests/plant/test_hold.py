"""A held step output: pulses that a motion board has not made are subtracted from the axis position."""

from axistwin import Bench


def initialised(**axis):
    bench = Bench()
    if1 = bench.add("if1", X=axis)
    bench.run(1.5)
    if1.serial.write(b"(")
    bench.run(0.1)
    if1.serial.write(b"U61\r")
    bench.run(1.2)
    if1.serial.read()
    return bench, if1


def ask(bench, if1, command):
    if1.serial.read()
    if1.serial.write(command)
    bench.run(0.5)
    return if1.serial.read()


def test_the_position_and_the_count_of_an_if1_agree_with_the_metal():
    bench, if1 = initialised()
    if1.serial.write(b"X2000 $ \r")
    bench.run(2.0)
    issued = if1.axes["X"].position
    assert 100 < issued < 2000
    if1.axes["X"].hold(issued - 100)
    bench.run(10.0)
    assert if1.axes["X"].position == issued - 100 and if1.axes["X"].unmade == 2000 - (issued - 100)
    assert ask(bench, if1, b"N\r").strip().endswith(b"%d" % (issued - 100))
    if1.axes["X"].let_go()
    assert if1.axes["X"].position == issued - 100
    if1.serial.write(b"X-50 $ \r")
    bench.run(5.0)
    assert if1.axes["X"].position == issued - 150 and ask(bench, if1, b"N\r").strip().endswith(b"50")


def test_switches_follow_the_corrected_position():
    bench, if1 = initialised(limits=(-100, 1500))
    if1.serial.write(b"X1000 $ \r")
    bench.run(20.0)
    if1.axes["X"].hold(900)
    if1.axes["X"].let_go()
    if1.serial.write(b"X601 $ \r")
    bench.run(20.0)
    assert if1.axes["X"].position == 1501 and not if1.pins["limit_plus"].level


def test_the_count_of_an_1811():
    bench = Bench()
    board = bench.add("1811")
    bench.run(3.0)
    generator, axis = board._device._board.pulses, board.axes["motor"]
    assert generator.position == axis.position == 0
    axis.hold(-7)
    axis.let_go()
    assert generator.position == axis.position == -7
