"""Further test processes begin a test only where the machine has time."""

from __future__ import annotations

from collections.abc import Sequence

import on_idle
import pytest

BEFORE = 'cpu  100 10 40 800 50 0 0 0 0 0\ncpu0 50 5 20 400 25 0 0 0 0 0\n'
BUSY = 'cpu  176 10 60 802 52 0 0 0 0 0\n'
IDLE = 'cpu  180 10 80 880 60 0 0 0 0 0\n'
GIVES_WAY = 'cpu  110 90 50 800 50 0 0 0 0 0\n'


class Kernel:
    """Tells what the cores did, one text after the other; the last one for ever."""

    def __init__(self, texts: Sequence[str]) -> None:
        self.left = [*texts]

    def read_text(self, encoding: str) -> str:
        return self.left.pop(0) if len(self.left) > 1 else self.left[0]


@pytest.mark.parametrize(
    ('after', 'share'), [(BUSY, 0.04), (IDLE, 0.43), (GIVES_WAY, 0.8), (BEFORE, 0.0)]
)
def test_the_share_of_idle_time(after: str, share: float) -> None:
    assert on_idle.idle_share(BEFORE, after) == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize(
    ('worker', 'at_once', 'waits'),
    [('', '3', False), ('gw2', '3', False), ('gw3', '3', True), ('gw9', '', False)],
)
def test_the_first_processes_never_wait(worker: str, at_once: str, waits: bool) -> None:
    assert on_idle.needs_idle(worker, at_once) is waits


@pytest.mark.parametrize(
    ('texts', 'left'),
    [([BEFORE, BUSY, IDLE, 'never read'], 1), ([BEFORE, IDLE, 'never read'], 1), ([BUSY], 1)],
)
def test_wait_ends_when_cores_idle_or_time_expires(
    monkeypatch: pytest.MonkeyPatch, texts: list[str], left: int
) -> None:
    kernel = Kernel(texts)
    monkeypatch.setattr(on_idle, 'TIMES', kernel)
    monkeypatch.setattr(on_idle, 'LOOK_S', 0.0)
    monkeypatch.setattr(on_idle, 'LONGEST_S', 0.5)
    on_idle.wait_for_idle()
    assert len(kernel.left) == left
