from axistwin.sim.signal import Signal


def test_callbacks_run_in_the_order_of_their_subscription():
    log, signal = [], Signal()
    signal.subscribe(lambda value: log.append(("first", value)))
    signal.subscribe(lambda value: log.append(("second", value)))
    signal.emit(1)
    assert log == [("first", 1), ("second", 1)]


def test_a_signal_is_true_while_it_has_subscribers():
    signal = Signal()
    assert not signal
    unsubscribe = signal.subscribe(print)
    assert signal
    unsubscribe()
    assert not signal


def test_subscribers_of_an_emission_are_those_of_its_beginning():
    log, signal = [], Signal()

    def first():
        log.append("first")
        end_second()
        signal.subscribe(lambda: log.append("third"))

    end_first = signal.subscribe(first)
    end_second = signal.subscribe(lambda: log.append("second"))
    signal.emit()
    assert log == ["first", "second"]
    end_first()
    signal.emit()
    assert log == ["first", "second", "third"]
