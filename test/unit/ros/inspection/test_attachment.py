"""Whether a stream still has a watcher."""

from __future__ import annotations

from bt_orchestrator.ros.inspection.attachment import FIRST_WAIT_S, GRACE_S, Attachment


def test_a_first_subscriber_is_waited_for_a_long_time() -> None:
    stream = Attachment(now=100.0)
    assert not stream.look(0, 100.0 + FIRST_WAIT_S - 1)
    assert not stream.is_over(100.0 + FIRST_WAIT_S - 1)
    assert stream.is_over(100.0 + FIRST_WAIT_S)


def test_it_lasts_as_long_as_somebody_is_there() -> None:
    stream = Attachment(now=0.0)
    assert stream.look(1, 1.0), 'a new one'
    assert not stream.look(1, 2.0), 'the same'
    assert stream.look(2, 3.0), 'a second one'
    assert not stream.look(1, 4.0), 'one left'
    assert not stream.is_over(1e9)


def test_the_last_one_may_come_back_within_a_grace() -> None:
    stream = Attachment(now=0.0)
    stream.look(1, 100.0)
    stream.look(0, 200.0)
    stream.look(0, 200.0 + GRACE_S / 2)
    assert not stream.is_over(200.0 + GRACE_S / 2)
    assert stream.look(1, 200.0 + GRACE_S / 2)
    stream.look(0, 300.0)
    assert stream.is_over(300.0 + GRACE_S)


def test_a_further_watcher_that_was_announced_is_waited_for() -> None:
    stream = Attachment(now=0.0)
    stream.look(1, 1.0)
    stream.look(0, 50.0)
    stream.expect(52.0)
    assert not stream.is_over(50.0 + GRACE_S)
    assert stream.is_over(52.0 + FIRST_WAIT_S)


def test_a_permanent_stream_needs_nobody() -> None:
    stream = Attachment(now=0.0)
    stream.is_permanent = True
    assert not stream.is_over(1e9)
