"""What the inspection server sends becomes a tree."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any
from uuid import UUID, uuid5

from bt_orchestrator.model.branch import Outcome
from bt_orchestrator.ros.link.inspection_streams import DECORATOR, tree_of

OTHER = 1
_NAMES = UUID(int=1)


def message(name: str, parent: str, *children: str, kind: int = OTHER) -> Any:
    def own(of: str) -> Any:
        return SimpleNamespace(uuid=list(uuid5(_NAMES, of).bytes if of else bytes(16)))

    return SimpleNamespace(
        name=name,
        own_id=own(name),
        parent_id=own(parent),
        child_ids=[own(child) for child in children],
        status=2,
        message='words\nof it',
        type=kind,
    )


def test_a_snapshot_becomes_a_tree() -> None:
    root = tree_of(
        [
            message('root', '', 'a', 'b'),
            message('a', 'root', 'c', kind=DECORATOR),
            message('c', 'a'),
            message('b', 'root'),
        ]
    )
    assert root is not None
    assert [child.name for child in root.children] == ['a', 'b']
    assert root.children[0].is_decorator
    assert root.status is Outcome.RUNNING
    assert root.children[0].children[0].words == 'words\nof it'
    assert tree_of([]) is None
