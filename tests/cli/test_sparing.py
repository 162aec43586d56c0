"""Repeated errors of one client are logged in full ten times, and then only counted."""

import logging

import pytest

from axistwin.cli.serving.sparing import IN_FULL, Sparing, log_to_stderr


@pytest.fixture
def written():
    """Return the records of all loggers below `t`, in order."""
    records, handler, logger = [], logging.Handler(), logging.getLogger("t")
    handler.emit = lambda record: records.append((record.getMessage(), record.exc_info is not None))
    handler.addFilter(Sparing())
    logger.addHandler(handler)
    logger.propagate = False
    yield records
    logger.removeHandler(handler)
    logger.propagate = True


def fail(name, number):
    for count in range(number):
        try:
            raise ValueError(count)
        except ValueError:
            logging.getLogger(name).exception("message %d", count)


def test_a_million_bad_messages_are_a_few_lines(written):
    fail("t.web", 1000)
    assert written[:IN_FULL] == [(f"message {count}", True) for count in range(10)]
    assert written[IN_FULL:] == [
        (f"t.web has reported {count} errors; later ones are only counted", False)
        for count in (16, 32, 64, 128, 256, 512)
    ]


def test_each_logger_has_its_own_count(written):
    fail("t.one", 20)
    fail("t.other", 1)
    assert written[-1] == ("message 0", True)


def test_lines_of_our_own_are_not_limited():
    record = logging.LogRecord("axistwin.links", logging.INFO, "", 0, "host connected", (), None)
    sparing = Sparing()
    assert all(sparing.filter(record) for _ in range(50))


def test_tracebacks_of_our_own_are_limited():
    sparing, passed = Sparing(), 0
    for _ in range(100):
        error = (ValueError, ValueError(), None)
        record = logging.LogRecord("axistwin.cli", logging.ERROR, "", 0, "a task has failed", (), error)
        passed += sparing.filter(record)
    assert passed == IN_FULL + 3  # the records 16, 32 and 64


def test_a_program_that_has_its_own_handlers_keeps_all_its_records(caplog):
    log_to_stderr(logging.WARNING)
    for _ in range(2 * IN_FULL):
        logging.getLogger("library").warning("one of many")
    assert len(caplog.records) == 2 * IN_FULL
