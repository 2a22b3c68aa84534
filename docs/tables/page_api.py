"""The endpoints of the operator page."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, cast

from bt_orchestrator.extensions.page.web.app import endpoints_of, with_description
from bt_orchestrator.extensions.page.web.endpoint import Endpoint
from tables.markdown import cell, code, table


def api_of_the_page() -> Iterator[str]:
    """Yield the table of all endpoints."""
    endpoints = with_description(endpoints_of(cast('Any', _Anything())))
    yield from table(('', 'path', 'does'), map(_row, endpoints))


def _row(endpoint: Endpoint) -> tuple[str, ...]:
    query = ', '.join(f'`{name}`' for name in endpoint.query)
    body = ', '.join(f'`{name}`' for name in endpoint.body if name not in ('reason', 'ticket'))
    takes = '; '.join(
        f'{where} {what}' for where, what in (('query:', query), ('body:', body)) if what
    )
    path = re.sub(r':\w+}', '}', endpoint.path)
    return endpoint.method, code(path), cell(f'{endpoint.does}{takes and f"; {takes}"}')


class _Anything:
    """Stands for a page: endpoints keep its parts and do not use them until somebody asks."""

    def __getattr__(self, _: str) -> _Anything:
        return self
