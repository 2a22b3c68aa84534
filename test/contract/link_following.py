"""What every CellLink tells its listeners, whatever happens to the node (see ports/door.py)."""

from __future__ import annotations

import pytest
from contract.link_bench import LinkBench, Seen, forget_events, restored_copy
from contract.link_doors import DoorTests, add, asked_of, happen, new_id, turn_until

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import CellLink

SILENT_S = 3.0
"""After so long a node is away; one that is there says something once a second."""


def told_until(link: CellLink, seen: Seen, last: int) -> None:
    turn_until(link, lambda: seen.seqs[-1:] >= [last], f'event {last}')


def assert_complete(seen: Seen, first: int) -> None:
    assert seen.seqs == list(range(first, first + len(seen.seqs))), 'each once and in order'


def _names(tree: Branch) -> set[str]:
    """Return the names of all behaviours."""
    return {tree.name}.union(*map(_names, tree.children))


def _is_followed(link: CellLink) -> bool:
    try:
        link.follow(Seen())
    except NodeUnreachable:
        return False
    return True


class FollowingContract(DoorTests):
    """Events, trees and silence."""

    def test_from_now_on(self, link: CellLink) -> None:
        known = happen(link)
        seen = Seen()
        link.follow(seen)
        last = happen(link, 3)
        told_until(link, seen, last)
        assert_complete(seen, known + 1)
        turn_until(link, lambda: seen.status and seen.status.seq >= last, 'status')

    def test_from_an_event_on_that_is_known(self, link: CellLink) -> None:
        known = happen(link)
        last = happen(link, 2)
        seen = Seen()
        link.follow(seen, known, link.status().history)
        told_until(link, seen, last)
        assert_complete(seen, known + 1)
        assert (seen.histories, seen.gaps) == ([], [])

    def test_events_are_those_of_the_journal(self, link: CellLink) -> None:
        known = happen(link)
        seen = Seen()
        link.follow(seen)
        told_until(link, seen, happen(link, 2))
        assert list(link.events_after(known).events)[: len(seen.events)] == seen.events

    def test_each_listener_has_a_beginning_of_its_own(self, link: CellLink) -> None:
        first, second = Seen(), Seen()
        known = happen(link)
        link.follow(first)
        last = happen(link)
        link.follow(second, known)
        for seen in (first, second):
            told_until(link, seen, last)
            assert_complete(seen, known + 1)

    @pytest.mark.parametrize('every', [1, 2, 3])
    def test_messages_that_are_lost(self, bench: LinkBench, link: CellLink, every: int) -> None:
        known = happen(link)
        seen = Seen()
        link.follow(seen)
        bench.lose(link, lambda event: event.seq % every == 0)
        told_until(link, seen, happen(link, 3))
        assert_complete(seen, known + 1)
        assert seen.gaps == []

    @pytest.mark.parametrize('is_killed', [True, False])
    def test_a_node_that_comes_back(
        self, bench: LinkBench, link: CellLink, is_killed: bool
    ) -> None:
        known = happen(link)
        seen = Seen()
        link.follow(seen)
        told_until(link, seen, happen(link))
        if is_killed:
            bench.kill()
        else:
            bench.stop()
        link.turn(0.2)
        bench.start(bench.journal)
        told_until(link, seen, happen(link, 2))
        assert_complete(seen, known + 1)
        assert (seen.histories, seen.gaps) == ([], [])

    def test_a_node_with_another_journal(self, bench: LinkBench, link: CellLink) -> None:
        before = link.status().history
        known = happen(link)
        seen = Seen()
        link.follow(seen)
        bench.kill()
        bench.start(None)
        last = happen(link, 2)
        told_until(link, seen, last)
        assert seen.histories == [link.status().history] != [before]
        assert_complete(seen, 1)
        self._begin_with_what_is_gone(link, known, before, last)
        bench.kill()

    def _begin_with_what_is_gone(
        self, link: CellLink, known: int, history: str, last: int
    ) -> None:
        seen = Seen()
        link.follow(seen, known, history)
        told_until(link, seen, last)
        assert seen.histories == [link.status().history]
        assert_complete(seen, 1)

    def test_a_journal_that_was_brought_back(self, bench: LinkBench, link: CellLink) -> None:
        before = link.status().history
        known = happen(link)
        seen = Seen()
        link.follow(seen)
        bench.stop()
        copy = bench.journal.with_name(f'{new_id()}.sqlite3')
        restored_copy(bench.journal, copy)
        bench.start(copy)
        told_until(link, seen, happen(link))
        assert seen.histories == [link.status().history] != [before]
        assert seen.seqs[0] <= known, 'it goes on from there, and all of it is told'
        assert_complete(seen, seen.seqs[0])
        bench.stop()

    def test_events_that_were_removed(self, bench: LinkBench, link: CellLink) -> None:
        last = happen(link, 2)
        bench.stop()
        forget_events(bench.journal, bench.cell(), last)
        bench.start(bench.journal)
        first = link.events_after(0).first_seq
        assert 1 < first <= last
        seen = Seen()
        link.follow(seen, 0)
        told_until(link, seen, happen(link))
        assert seen.gaps == [(1, first - 1)]
        assert_complete(seen, first)

    def test_whoever_has_left_hears_nothing_more(self, bench: LinkBench) -> None:
        link, other = bench.link(), bench.link()

        class Leaving(Seen):
            def on_event(self, event: Event) -> None:
                super().on_event(event)
                link.close()

        seen = Leaving()
        link.follow(seen)
        last = happen(other, 2)
        turn_until(link, lambda: seen.events, 'event')
        assert len(seen.events) == 1
        still = Seen()
        other.follow(still, last - 1)
        told_until(other, still, last)
        other.close()
        other.close()

    def test_the_tree_as_long_as_somebody_watches_it(
        self, bench: LinkBench, link: CellLink
    ) -> None:
        trees: list[Branch] = []
        link.follow(Seen())
        watch = link.watch_tree(trees.append)
        turn_until(link, lambda: trees, 'tree')
        assert _names(trees[-1]) >= {'belt', 'section 1', 'section 2'}
        assert asked_of(link, 'cell.pause').accepted, 'nothing is to run'
        self._see_a_job(link, trees)
        bench.kill()
        link.turn(0.2)
        bench.start(bench.journal)
        self._see_a_job(link, trees)
        watch.close()
        watch.close()
        trees.clear()
        last = happen(link, 2)
        seen = Seen()
        link.follow(seen, last - 1)
        told_until(link, seen, last)
        assert trees == []
        assert asked_of(link, 'cell.resume', everyones=True).accepted

    def _see_a_job(self, link: CellLink, trees: list[Branch]) -> None:
        """Queue a job, wait until its branch is there, and take it out again."""
        name = new_id()
        assert add(link, name, held=False).accepted
        turn_until(link, lambda: any(name in label for label in _names(trees[-1])), 'branch')
        assert asked_of(link, 'job.cancel', job=name).accepted

    def test_silence_is_not_the_same_as_no_news(self, bench: LinkBench, link: CellLink) -> None:
        seen = Seen()
        link.follow(seen)
        for _ in range(15):
            link.turn(0.1)
        turn_until(link, lambda: link.silent_s < SILENT_S / 2, 'sign of life')
        bench.kill()
        turn_until(link, lambda: link.silent_s > SILENT_S, 'silence')
        bench.start(bench.journal)
        turn_until(link, lambda: link.silent_s < SILENT_S / 2, 'sign of life')

    def test_calls_to_killed_node_raise_node_unreachable(self, bench: LinkBench) -> None:
        link = bench.link(timeout_s=1.0)
        # The first look may take longer than this link waits.
        turn_until(link, lambda: _is_followed(link), 'node')
        bench.kill()
        for call in (
            link.status,
            link.description,
            link.queue,
            link.jobs,
            lambda: link.events_after(0),
            lambda: link.follow(Seen()),
            lambda: asked_of(link, 'cell.pause'),
        ):
            with pytest.raises(NodeUnreachable, match='/bt_orchestrator'):
                call()
        link.turn(0.1)
        link.close()
