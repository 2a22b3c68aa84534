"""The order relations of a line: one graph for all items, of one script or of several.

docs/deadlock_proof.md says why these relations decide.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import product

from bt_orchestrator.model.proof.operations import Operation, Operations, Relation


class Precedence:
    """Operations, and the relations between them."""

    def __init__(self, scripts: Sequence[Operations]) -> None:
        """Relate scripts whose items may follow each other in any order.

        Scripts that share a flag have the same counts for it (semantics 4.1).
        """
        self.operations = [operation for one in scripts for operation in one.all]
        self.turns = [turn for one in scripts for turn in one.turns.values()]
        self.first = min(one.source for one in scripts)
        """The first section with work."""
        self.length = max(one.sink for one in scripts) - self.first
        """Number of moves from there to the last section with work."""
        self.after: Mapping[Operation, list[Relation]] = defaultdict(list)
        """By operation: the relations to what must come later."""
        self.before: Mapping[Operation, list[Relation]] = defaultdict(list)
        """By operation: the relations to what must come earlier."""
        lists = (relation for one in scripts for relation in one.order)
        for relation in (*lists, *_of_cycles(scripts), *_of_flags(scripts)):
            self.after[relation.before].append(relation)
            self.before[relation.after].append(relation)

    def beat(self, operation: Operation, item: int) -> int:
        """Return the beat of an operation for an item, if an item is begun in every beat."""
        return item + operation.section - self.first

    def item(self, operation: Operation, beat: int) -> int:
        """Return the item of an operation in a beat; below 1 there is none yet."""
        return beat - operation.section + self.first


def _of_cycles(scripts: Sequence[Operations]) -> Iterator[Relation]:
    """Yield the relations that a section ends each cycle before it begins the next."""
    for one, following in product(scripts, repeat=2):
        for section, end in one.ends.items():
            if section in following.begins:
                yield Relation(end, following.begins[section], 1)


def _of_flags(scripts: Sequence[Operations]) -> Iterator[Relation]:
    """Yield the relations of flags: adding needs room, taking needs a count (semantics 4.1).

    All but `capacity` of the initial and added counts must be taken before the next addition; the
    first `initial` takings need no addition. Each item belongs to one script.
    """
    shared = [
        (one, other, flag)
        for one, other in product(scripts, repeat=2)
        for flag in one.flags
        if flag in other.flags
    ]
    for one, other, flag in shared:
        wants, taking = one.flags[flag], other.flags[flag].downstream
        room = wants.capacity - wants.initial
        if room or one is other:
            up = one.of_task[wants.upstream]
            yield Relation(other.of_task[taking], up, room, (taking,), wants)
    for one, other, flag in shared:
        wants, adding = one.flags[flag], other.flags[flag].upstream
        if wants.initial or one is other:
            down = one.of_task[wants.downstream]
            yield Relation(other.of_task[adding], down, wants.initial, (adding,), wants)
