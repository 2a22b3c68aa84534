from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.base.deadlines import Deadlines, has_come
from bt_orchestrator.sim.gateway import VirtualClock


def pop_all(deadlines: Deadlines, now_ns: int) -> int:
    """Call what is due; return how many it were."""
    called = 0
    while callback := deadlines.pop_due(now_ns):
        callback()
        called += 1
    return called


def test_earliest_first_and_ties_in_the_order_added() -> None:
    deadlines = Deadlines()
    seen: list[str] = []
    for name, time_ns in [('late', 7), ('tie 1', 5), ('tie 2', 5), ('early', 1)]:
        deadlines.add(time_ns, lambda name=name: seen.append(name))  # type: ignore[misc]
    assert deadlines.next_ns() == 1
    assert pop_all(deadlines, 5) == 3
    assert seen == ['early', 'tie 1', 'tie 2']
    assert deadlines.next_ns() == 7


def test_cancelled_is_not_called_and_does_not_count() -> None:
    deadlines = Deadlines()
    cancelled = deadlines.add(1, lambda: None)
    deadlines.add(2, lambda: None)
    cancelled.cancel()
    cancelled.cancel()
    assert len(deadlines) == 1
    assert deadlines.next_ns() == 2


def test_cancel_after_the_call_changes_nothing() -> None:
    deadlines = Deadlines()
    passed = deadlines.add(1, lambda: None)
    deadlines.add(2, lambda: None)
    assert pop_all(deadlines, 1) == 1
    passed.cancel()
    assert len(deadlines) == 1


def test_many_cancelled_ones_are_not_kept() -> None:
    deadlines = Deadlines()
    for _ in range(10_000):
        deadlines.add(10**12, lambda: None).cancel()
    assert len(deadlines) == 0
    assert len(deadlines._heap) < 200


@given(st.lists(st.tuples(st.integers(0, 20), st.booleans()), max_size=300))
def test_calls_exactly_those_that_were_not_cancelled(plan: list[tuple[int, bool]]) -> None:
    deadlines = Deadlines()
    called: list[tuple[int, int]] = []
    armed = [
        deadlines.add(time_ns, lambda entry=(time_ns, n): called.append(entry))  # type: ignore[misc]
        for n, (time_ns, _) in enumerate(plan)
    ]
    for deadline, (_, cancel) in zip(armed, plan, strict=True):
        if cancel:
            deadline.cancel()
    expected = sorted((time_ns, n) for n, (time_ns, cancel) in enumerate(plan) if not cancel)
    assert len(deadlines) == len(expected)
    assert pop_all(deadlines, 20) == len(expected)
    assert called == expected
    assert deadlines.next_ns() is None


EPOCHS_S = st.sampled_from([0.0, 1.7e9, 4.0e9])


@given(EPOCHS_S, st.integers(0, 10**8), st.integers(0, 10**7), st.integers(-3, 3))
def test_has_come_agrees_with_clock_callback(
    epoch_s: float, began_ms: int, after_ms: int, beside_us: int
) -> None:
    clock = VirtualClock(epoch_s + began_ms / 1000)
    due_s = clock.now() + after_ms / 1000
    clock.call_at(due_s + beside_us / 1e6, lambda: None)
    clock.advance()
    assert has_come(due_s, clock.now()) is (beside_us >= 0 or after_ms == 0)
