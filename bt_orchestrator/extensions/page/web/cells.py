"""The list of all cells of the plant."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Json, Problem
from bt_orchestrator.ports.plant import PlantCell, PlantCells


def endpoints(cells: PlantCells | None) -> tuple[Endpoint, ...]:
    """Return the endpoint.

    :param cells: reads them; None: the page was started without --plant
    """

    def plain(cell: PlantCell) -> Mapping[str, object]:
        is_address = cell.page.startswith(('http://', 'https://'))  # and no script for a browser
        return {**cell._asdict(), 'page': cell.page if is_address else ''}

    async def listed(_: Request) -> Response:
        if cells is None:
            return Json({'has_plant': False, 'cells': []})
        try:
            found = await asyncio.to_thread(cells)
        except JournalUnusable as error:
            raise Problem(503, str(error)) from error
        return Json({'has_plant': True, 'cells': [plain(one) for one in found]})

    return (
        Endpoint(
            'GET',
            '/api/cells',
            listed,
            'returns the cells of the plant (`--plant`), each with its state, the age of its copy '
            'and the address of its page; `has_plant` is false without a plant',
            refusals={503: "the plant's database cannot be read: the message says why"},
        ),
    )
