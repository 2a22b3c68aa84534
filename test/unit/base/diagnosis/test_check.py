from __future__ import annotations

import pytest

from bt_orchestrator.base.diagnosis.check import Verdict, fail, ok, warn, worst

A, B, C = ok('a', 'fine'), warn('b', 'odd', 'look'), fail('c', 'gone', 'mend')


@pytest.mark.parametrize(
    ('checks', 'verdict'),
    [([], Verdict.OK), ([A], Verdict.OK), ([B, A], Verdict.WARN), ([A, C, B], Verdict.FAIL)],
)
def test_the_worst_counts(checks: list[object], verdict: Verdict) -> None:
    assert worst(checks) is verdict  # type: ignore[arg-type]
