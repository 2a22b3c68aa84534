"""The pace of scripts as the verbs tell it: by the graph, and by the engine what is expected."""

from __future__ import annotations

import argparse
from contextlib import closing

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.keeping.journal_place import JournalPlace, journal_place
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.view.report.pace_text import ScriptPace, script_pace
from bt_orchestrator.view.report.rates import RatesSeen, rates_of, rates_seen
from bt_orchestrator.view.report.reading import Reading


def add_rates_option(parser: argparse.ArgumentParser) -> None:
    """Declare the journal that knows better than the files."""
    parser.add_argument(
        '--journal',
        type=journal_place,
        metavar='FILE',
        help='for the expected pace: how often conditions held and tasks failed in this journal; '
        '`likely` of the files counts where it has seen that too few times',
    )


class Pacing:
    """Works out how fast a cell is with scripts."""

    def __init__(
        self, cell: Cell, types: ActionTypes, journal: JournalPlace | None = None
    ) -> None:
        """Read what a journal has seen.

        :raises JournalUnusable: it cannot be read
        """
        self._cell = cell
        self._judge = PaceJudge(cell, types, bootstrap.memory_store)
        self._seen = RatesSeen()
        if journal is not None:
            with closing(open_records(journal)) as records:
                self._seen = rates_seen(Reading(records, say_damage))

    def of(self, script: Script) -> ScriptPace:
        """Return the pace; the expected one only where something is known to be likely."""
        rates = list(rates_of(script, self._seen))
        expected = self._judge.expected(script, rates) if rates else None
        return script_pace(script, self._cell, expected)
