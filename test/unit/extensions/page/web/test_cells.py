"""The cells of the plant, as the page serves them."""

from __future__ import annotations

import asyncio
import json
import sys
from argparse import Namespace
from collections.abc import Sequence
from typing import Any, cast

import pytest

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.base.extending import ExtensionMissing
from bt_orchestrator.extensions.page.verb import cells_of
from bt_orchestrator.extensions.page.web.app import cells_endpoints
from bt_orchestrator.extensions.page.web.endpoint import Problem
from bt_orchestrator.ports.records import PlantCell, PlantCells

LINE = PlantCell('line_1', 'Held', 12.5, 'own_fault', 99, 13.5, 0.5, 2, 'http://line-1:8080/')


def served(cells: PlantCells | None) -> Any:
    (endpoint,) = cells_endpoints(cells)

    async def ask() -> Any:
        response = await endpoint.answer(cast(Any, None))
        assert response is not None
        return json.loads(bytes(response.body))

    return asyncio.run(ask())


def test_cells_carry_all_database_fields() -> None:
    assert served(lambda: [LINE]) == {'has_plant': True, 'cells': [LINE._asdict()]}


def test_a_page_without_a_plant_says_so() -> None:
    assert served(None) == {'has_plant': False, 'cells': []}


@pytest.mark.parametrize('address', ['javascript:alert(1)', 'data:text/html,x', ''])
def test_unsafe_page_links_are_dropped(address: str) -> None:
    (cell,) = served(lambda: [LINE._replace(page=address)])['cells']
    assert cell['page'] == ''


def test_a_database_that_is_away_is_told() -> None:
    def away() -> Sequence[PlantCell]:
        raise JournalUnusable('the database is away')

    with pytest.raises(Problem, match='the database is away') as problem:
        served(away)
    assert problem.value.status == 503


def test_the_database_of_a_plant_needs_an_extension(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'psycopg', None)
    with pytest.raises(ExtensionMissing, match=r"pip install 'psycopg\[binary\]"):
        cells_of(Namespace(plant='postgresql://db/plant'))
    assert cells_of(Namespace(plant=None)) is None
