"""The format `parquet` of the verb `events`: a folder with two tables, for BI tools."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

from bt_orchestrator.base.extending import PARQUET
from bt_orchestrator.cli.output import cannot_write
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.events import OrchestratorStarted
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.view.report.account.booked import steady_time
from bt_orchestrator.view.report.reading import Reading


@contextmanager
def tables_in(folder: Path | None, reading: Reading) -> Iterator[Callable[[str], None]]:
    """Give what takes one record after another; the tables are at their places at the end.

    :param reading: of the journal
    :raises WrongUse: no folder is named, it cannot be written, or pyarrow is missing
    """
    if folder is None:
        raise WrongUse('parquet is two tables in a folder; name it: -o FOLDER')
    PARQUET.demand()
    started = reading.events(Wanted(events=(OrchestratorStarted.event,)))
    starts = [event.seq for event in started]
    try:
        export = import_module(f'{PARQUET.room}.export').ParquetExport(
            folder, reading.records.extent().history, steady_time(reading), starts
        )
    except OSError as error:
        raise WrongUse(cannot_write(folder, error)) from error
    try:
        yield export.write
        export.close()
    except BaseException:
        export.discard()
        raise
