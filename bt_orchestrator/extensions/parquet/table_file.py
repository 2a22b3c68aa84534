"""A Parquet file that grows by row groups."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

INT = pa.int64()
TEXT = pa.string()
SECONDS = pa.float64()
TIME = pa.timestamp('us', tz='UTC')
"""Given as whole microseconds since the epoch."""

MOST_ROWS = 50_000
MOST_CHARACTERS = 16_000_000
"""A row group is written with so many rows, or so much text: this is what is kept in memory."""


class TableFile:
    """Takes in one row after another. The file is at its place when it is complete."""

    def __init__(self, path: Path, columns: Mapping[str, pa.DataType], about: Mapping[str, str]):
        """Begin.

        :param about: kept with the table, as key-value metadata
        :raises OSError: it cannot be written
        """
        self._path = path
        self._unfinished = path.with_name(f'{path.name}.part')
        self._schema = pa.schema(columns.items(), metadata=dict(about))
        self._writer = pq.ParquetWriter(self._unfinished, self._schema)
        self._columns: dict[str, list[Any]] = {name: [] for name in columns}
        self._rows = self._characters = 0

    def add(self, row: Mapping[str, Any]) -> None:
        """Take in a row; what it does not name is null."""
        for name, values in self._columns.items():
            value = row.get(name)
            values.append(value if type(value) is not int or fits(value) else None)
            if isinstance(value, str):
                self._characters += len(value)
        self._rows += 1
        if self._rows >= MOST_ROWS or self._characters >= MOST_CHARACTERS:
            self._write_group()

    def close(self) -> None:
        """Write the rest, and put the file at its place."""
        self._write_group()
        self._writer.close()
        self._unfinished.replace(self._path)

    def discard(self) -> None:
        """Give it up."""
        self._writer.close()
        self._unfinished.unlink(missing_ok=True)

    def _write_group(self) -> None:
        if self._rows:
            arrays = [_array(values, self._schema.field(n).type) for n, values in self._items()]
            self._writer.write_table(pa.Table.from_arrays(arrays, schema=self._schema))
        for _, values in self._items():
            values.clear()
        self._rows = self._characters = 0

    def _items(self) -> Any:
        return self._columns.items()


def fits(number: int) -> bool:
    """Tell whether a number has 64 bits at most; one that has more is null."""
    return -(2**63) <= number < 2**63


def _array(values: list[Any], kind: pa.DataType) -> pa.Array:
    try:
        return pa.array(values, kind)
    except UnicodeEncodeError:  # half of a surrogate pair has no UTF-8; it is written out
        return pa.array([_whole(value) for value in values], kind)


def _whole(value: Any) -> Any:
    return value.encode('utf-8', 'backslashreplace').decode() if type(value) is str else value
