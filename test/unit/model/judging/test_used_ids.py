"""The set of order ids: as a set of texts, but small."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.model.judging import used_ids
from bt_orchestrator.model.judging.used_ids import UsedIds

IDS = st.one_of(
    st.from_regex(r'[A-Z]{0,2}-?0{0,2}[0-9]{1,2}', fullmatch=True), st.text(min_size=1, max_size=5)
)


@pytest.fixture(params=[1, 3, used_ids.FULL], scope='module')
def full(request: pytest.FixtureRequest) -> Iterator[int]:
    """Let a part be full with so many ids."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(used_ids, 'FULL', request.param)
        yield request.param


def lost(_: str) -> None:
    """Read no part."""


@given(st.lists(IDS), st.lists(IDS))
def test_it_holds_what_was_added_and_nothing_else(
    full: int, added: list[str], asked: list[str]
) -> None:
    ids = UsedIds()
    for order in added:
        ids.add(order)
    assert all(order in ids for order in added)
    assert [order in ids for order in asked] == [order in set(added) for order in asked]
    assert len(ids.others) + sum(map(len, ids.runs.values())) < full
    again = UsedIds(ids.others, ids.runs, ids.sealed)
    again.open_parts(lambda digest: ids.parts[digest].text)
    assert [order in again for order in asked] == [order in ids for order in asked]
    free = [f'-{n}' for n in range(1, 120) if f'-{n}' not in added]
    assert list(islice(again.free('-'), 15)) == free[:15]


@given(st.lists(IDS))
def test_plain_ids_of_older_version_are_sealed(full: int, added: list[str]) -> None:
    older = UsedIds()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(used_ids, 'FULL', used_ids.FULL + 10_000)
        for order in added:
            older.add(order)
    older.open_parts(lost)
    assert all(order in older for order in added)
    assert 'not there' not in older
    assert len(older.others) + sum(map(len, older.runs.values())) < full


def test_lost_part_raises_key_error() -> None:
    with pytest.raises(KeyError):
        UsedIds(sealed=['0123']).open_parts(lost)


@given(st.permutations([f'WO-{n}' for n in range(1, 30)]))
def test_counted_ids_become_one_run_in_any_order(orders: list[str]) -> None:
    ids = UsedIds()
    for order in orders:
        ids.add(order)
    assert ids == UsedIds(runs={'WO-': [[1, 29]]})


def test_leading_zeros_make_another_id() -> None:
    ids = UsedIds()
    ids.add('WO-7')
    assert 'WO-07' not in ids
    assert '7' not in ids


def test_free_ids_leave_out_what_was_used() -> None:
    ids = UsedIds()
    for number in (1, 2, 4, 7):
        ids.add(f'WO-{number}')
    assert list(islice(ids.free('WO-'), 5)) == ['WO-3', 'WO-5', 'WO-6', 'WO-8', 'WO-9']
    assert next(ids.free('X-')) == 'X-1'
