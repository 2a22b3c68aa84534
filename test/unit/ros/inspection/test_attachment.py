"""Whether a stream still has a watcher."""

from __future__ import annotations

import pytest

from bt_orchestrator.ros.inspection.streams import (
    DISCOVERY_S,
    FIRST_WAIT_S,
    GRACE_S,
    Attachment,
    StreamRefused,
    to_end_for_another,
)


def test_first_subscriber_has_long_time_to_attach() -> None:
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


def test_last_subscriber_may_return_within_grace() -> None:
    stream = Attachment(now=0.0)
    stream.look(1, 100.0)
    stream.look(0, 200.0)
    stream.look(0, 200.0 + GRACE_S / 2)
    assert not stream.is_over(200.0 + GRACE_S / 2)
    assert stream.look(1, 200.0 + GRACE_S / 2)
    stream.look(0, 300.0)
    assert stream.is_over(300.0 + GRACE_S)


def test_announced_watcher_is_waited_for() -> None:
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


# --- too many ---------------------------------------------------------------------------------


class Stream:
    def __init__(self, opened: float, watchers: int = 0) -> None:
        self.attachment = Attachment(opened)
        self.attachment.look(watchers, opened)


LATER = 10.0 + DISCOVERY_S


def test_there_is_room_for_eight() -> None:
    streams = {f'/{number}': Stream(10.0, 1) for number in range(7)}
    assert to_end_for_another(streams, 'snapshot', LATER) is None


def test_the_oldest_without_a_watcher_gives_way() -> None:
    streams = {f'/{number}': Stream(10.0, watchers=number < 3) for number in range(8)}
    assert to_end_for_another(streams, 'snapshot', LATER) == '/3'


def test_freshly_opened_stream_does_not_give_way() -> None:
    streams = {f'/{number}': Stream(10.0) for number in range(8)}
    with pytest.raises(StreamRefused, match='8 snapshot streams are open'):
        to_end_for_another(streams, 'snapshot', LATER - 0.1)


def test_one_that_is_watched_never_gives_way() -> None:
    streams = {f'/{number}': Stream(10.0, 1) for number in range(8)}
    with pytest.raises(StreamRefused, match='close one'):
        to_end_for_another(streams, 'snapshot', 1e9)


def test_the_default_stream_is_none_of_them() -> None:
    streams = {f'/{number}': Stream(10.0, 1) for number in range(8)}
    streams['/0'].attachment.is_permanent = True
    assert to_end_for_another(streams, 'snapshot', LATER) is None
