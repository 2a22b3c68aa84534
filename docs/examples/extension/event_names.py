"""An extension of bt-orchestrator: a verb, a format of `events`, an output of `run`."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from bt_orchestrator.model.events import Event


class Names:
    """A format: the name of each event, one a line."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file

    def write(self, text: str) -> None:
        """Take one record, as JSON."""
        self._file.write(json.loads(text)['event'] + '\n')

    def close(self) -> None:
        """Write what is still to be written: nothing."""


class LastEvent:
    """An output of a node, `run --sink last-event`: a file with the name of the last event."""

    def publish(self, events: Sequence[Event]) -> None:
        """Take the events of one commit, in their order."""
        Path('last_event.txt').write_text(events[-1].event)


class count_events:  # noqa: N801 - a verb is anything with these two functions, a module as well
    """The verb `count-events`."""

    @staticmethod
    def add_arguments(parser: argparse.ArgumentParser) -> None:
        """Declare the options."""
        parser.description = 'Count the events of a file that `events --format names` wrote.'
        parser.add_argument('file', type=argparse.FileType(), metavar='FILE')

    @staticmethod
    def run(args: argparse.Namespace) -> int:
        """Carry it out; returns the exit status."""
        for name, number in sorted(Counter(args.file.read().split()).items()):
            print(f'{number:6} {name}')
        return 0
