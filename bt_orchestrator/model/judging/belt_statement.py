"""An operator's statement of the belt after an abort, compared with the state.

A statement covers every slot, so that the operator has to check the belt before a clear. It either
lists all slots, or confirms the status that the operator saw; a status older than the last change
of the belt is not valid.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model import events as e
from bt_orchestrator.model.state import CellState, Hold, ItemState, Phase
from bt_orchestrator.model.words import joined, sentence

EMPTY = 'empty'
"""The word for a slot without an item, whether or not it holds an empty position."""


@dataclass(frozen=True)
class AsShown:
    """The belt is as a status showed it."""

    seq: int
    """Last event of that status."""


@dataclass(frozen=True)
class Slots:
    """The content of each slot: an item, or `empty`."""

    by_section: Mapping[int, str]


Statement = AsShown | Slots


def parse_slots(words: Sequence[str]) -> Slots:
    """Read `1=WO-1/3`, `2=empty`, ... one slot per word.

    :raises CommandRefused: says what was expected
    """
    items: dict[int, str] = {}
    for word in words:
        match = re.fullmatch(r'\s*(\d+)\s*=\s*(\S.*?)\s*', word)
        if match is None:
            raise CommandRefused(sentence('slot_form', found=repr(word)))
        if int(match[1]) in items:
            raise CommandRefused(sentence('slot_twice', slot=match[1]))
        items[int(match[1])] = match[2]
    return Slots(items)


def corrections(state: CellState, statement: Statement) -> Iterator[e.ItemRemoved]:
    """Yield the changes by the statement: items that are no longer there.

    :raises CommandRefused: it is not about the belt as it is now, or names another item
    """
    _refuse_while_the_move_is_open(state)
    if isinstance(statement, AsShown):
        _check_seq(state, statement.seq)
        return
    _check_complete(state, statement)
    gone = [_gone(state, number, content) for number, content in statement.by_section.items()]
    for item in gone:
        if item is not None:
            yield e.ItemRemoved(job=item.job, item=item.id, section=item.section, how='by_hand')


def believed(state: CellState) -> str:
    """Return the belt of the state as a statement: `1=WO-1/3,2=empty`."""
    return ','.join(f'{n}={_standing(state, n) or EMPTY}' for n in state.sections)


def _standing(state: CellState, section: int) -> str | None:
    item = state.slot(section)
    return item.id if item is not None and item.present else None


def _refuse_while_the_move_is_open(state: CellState) -> None:
    if state.indexing and state.move is not None and state.move.phase is Phase.HELD:
        raise CommandRefused(sentence('move_open', hold=state.move.hold))


def _check_seq(state: CellState, seq: int) -> None:
    if not state.belt_seq <= seq <= state.seq:
        seqs = {'seq': seq, 'event': state.belt_seq, 'last': state.seq}
        raise CommandRefused(sentence('belt_changed', **seqs, belt=believed(state)))


def _check_complete(state: CellState, statement: Slots) -> None:
    stated_slots, there = set(statement.by_section), set(state.sections)
    for kind, numbers in (
        ('slot_missing', there - stated_slots),
        ('no_slot', stated_slots - there),
    ):
        if numbers:
            slots = ', '.join(map(str, sorted(numbers)))
            words = sentence(kind, slots=slots, last=len(there), belt=believed(state))
            raise CommandRefused(words)


def _gone(state: CellState, section: int, content: str) -> ItemState | None:
    """Return the item that is in a slot by the state, but not by the statement.

    :raises CommandRefused: the statement names another item there
    """
    standing = _standing(state, section)
    if content == standing or (content == EMPTY and standing is None):
        return None
    if content == EMPTY:
        return state.slot(section)
    mismatch = sentence('slot_other', slot=section, content=standing or EMPTY, stated=content)
    raise CommandRefused(joined(mismatch, _remedy(state, content)))


def _remedy(state: CellState, name: str) -> str:
    item = state.items.get(name)
    if item is None:
        return sentence('not_on_line')
    if item.section and item.present:
        return sentence('belongs', item=name, slot=item.section)
    held = next((hold for hold in state.holds.values() if _places(state, hold, name)), None)
    if held is not None:
        return sentence('if_placed', task=held.task, hold=held.id)
    return sentence('not_believed')


def _places(state: CellState, hold: Hold, item: str) -> bool:
    """Tell whether a hold is about the task that puts an item onto the belt."""
    task = state.task(hold.key) if hold.item == item and hold.key is not None else None
    return task is not None and task.qty_change == 1
