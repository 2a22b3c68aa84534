"""Events by pages, as records."""

from __future__ import annotations

import json
from typing import Any

from bt_orchestrator.extensions.page.web.archive.archive import Look
from bt_orchestrator.model.records import Wanted

MOST = 1000
"""Most records of one answer."""


def events_page(look: Look, wanted: Wanted, most: int) -> dict[str, Any]:
    """Return the next wanted records, and where to go on."""
    page = look.records.page(wanted, min(most, MOST))
    look.note(list(page.damage))
    rest = page.rest
    cursor = {'before': rest.before_seq} if wanted.newest_first else {'after': rest.after_seq}
    return {
        'history': page.history,
        'first_seq': look.extent.first_seq,
        'last_seq': look.extent.last_seq,
        'records': [json.loads(record.text) for record in page.records],
        'rest': None if page.is_last else cursor,
        'damage': look.damage,
    }
