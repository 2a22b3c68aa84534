"""Parts with the plain values of a status."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellDescription, CellStatus


class PlainShow:
    """Shows a status as it is. Implements `seams.Show`."""

    def begin(self, history: str) -> None:
        """Nothing is remembered."""

    def hear(self, event: Event) -> None:
        """Nothing is remembered."""

    def parts(
        self,
        status: CellStatus,
        description: CellDescription | None,
        node: str,
    ) -> Mapping[str, object]:
        """Return the fields of a status in parts."""
        plain = to_plain(status, whole=True)
        now = {key: plain.pop(key) for key in ('seq', 'history', 'stamp')}
        lists = {
            'section': ('sections', 'number'),
            'hold': ('holds', 'id'),
            'job': ('jobs', 'id'),
            'component': ('components', 'name'),
        }
        parts: dict[str, object] = {'now': now}
        for kind, (field, name) in lists.items():
            members = plain[field]
            plain[field] = [member[name] for member in members]
            parts |= {f'{kind}/{member[name]}': member for member in members}
        parts['belt'], parts['flags'] = plain.pop('belt'), {'flags': plain.pop('flags')}
        parts['cell'] = {'name': plain.pop('cell'), 'node': node, **plain}
        parts['line'] = to_plain(description, whole=True)
        return parts
