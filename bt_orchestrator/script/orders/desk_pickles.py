"""Questions to the order desk and its answers as bytes, between two processes of one program.

Scripts that the asking side has are named by what they say and what they were made from, so that
one script stays one object there, however many orders name it.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Mapping, Set
from typing import Any

from bt_orchestrator.model.codec import digest, text_of
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.orders.desk import Reading


def name_of(script: Script) -> str:
    """Return a name of a script; two versions of a recipe may come to scripts of one digest."""
    return f'{digest(script)} {script.made_from}'


def pickled(reading: Reading, held: Set[str]) -> bytes:
    """Return an answer for a process that has some scripts."""
    out = io.BytesIO()
    _Pickler(out, held).dump(reading)
    return out.getvalue()


def unpickled(data: bytes, held: Mapping[str, Script]) -> Any:
    """Return an answer, with the scripts that are here already."""
    return _Unpickler(io.BytesIO(data), held).load()


class _Pickler(pickle.Pickler):
    def __init__(self, out: io.BytesIO, held: Set[str]) -> None:
        super().__init__(out, pickle.HIGHEST_PROTOCOL)
        self._held = held

    def persistent_id(self, value: Any) -> str | None:
        """Name a script that is there already."""
        if not isinstance(value, Script):
            return None
        name = name_of(value)
        if name in self._held:
            return name
        value.work_out()  # here, and not in the thread that runs the line
        text_of(value)
        return None


class _Unpickler(pickle.Unpickler):
    def __init__(self, data: io.BytesIO, held: Mapping[str, Script]) -> None:
        super().__init__(data)
        self._held = held

    def persistent_load(self, name: Any) -> Any:
        """Return the script of a name."""
        return self._held[name]
