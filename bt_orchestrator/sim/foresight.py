"""Forecasts when jobs of a running cell end: runs the real engine on from the present state.

A cell that waits for an answer, or was stopped, gets no forecast: the time until it continues is
unknown.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import closing
from typing import Any

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.sim.run_on import LONGEST_S, RunOn


def expected_ends(
    cell: Cell,
    types: ActionTypes,
    plain_state: Mapping[str, Any],
    observed_s: Mapping[str, Mapping[str, float]],
    now_s: float,
) -> dict[str, float]:
    """Return when each live job will end, on the clock of `now_s`; those unknown are left out.

    :param plain_state: of `model.keeping.snapshot`
    :param observed_s: seconds that tasks took, by component and task constant
    """
    until = time.monotonic() + LONGEST_S
    with closing(RunOn(cell, types, plain_state, observed_s, now_s)) as run:
        run.go_on(until)
        return run.ends_s()
