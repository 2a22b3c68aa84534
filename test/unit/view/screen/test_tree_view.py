"""The lines of a behaviour tree, and which of them go first."""

from __future__ import annotations

from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.view.screen.plain import paths, printable, twigs


def branch(name: str, status: Outcome, *children: Branch, is_decorator: bool = False) -> Branch:
    return Branch(name, status, '', is_decorator, children)


def sample() -> Branch:
    """Return a tree of which one leaf runs below two decorators, and one waits."""
    run, done, new, bad = Outcome.RUNNING, Outcome.SUCCESS, Outcome.INVALID, Outcome.FAILURE
    work = branch('work', run)
    retry = branch('retry', run, work, is_decorator=True)
    guarded = branch('flags', run, retry, is_decorator=True)
    waiting = branch('belt at rest', run, branch('pack', new), is_decorator=True)
    return branch(
        'cell',
        run,
        branch('section 2', run, branch('place', done, branch('inner', done)), guarded),
        branch('section 1', run, waiting, branch('job', bad, branch('no', bad))),
    )


def names(room: int) -> tuple[list[str], int]:
    shown, hidden = twigs(sample(), room)
    return [twig.branch.name for twig in shown], hidden


def test_with_room_all_of_it_is_shown() -> None:
    shown, hidden = twigs(sample(), 50)
    assert hidden == 0
    assert [(t.depth, t.branch.name) for t in shown][:4] == [
        (0, 'cell'),
        (1, 'section 2'),
        (2, 'place'),
        (3, 'inner'),
    ]


def test_what_does_not_run_is_folded_first() -> None:
    shown, hidden = names(11)
    assert 'inner' not in shown
    assert 'no' not in shown
    assert {'place', 'job', 'retry', 'pack'} <= set(shown)
    assert hidden == 2


def test_then_decorators_that_only_wrap() -> None:
    shown, _ = names(8)
    assert shown == ['cell', 'section 2', 'work', 'section 1', 'belt at rest', 'job']


def test_active_branches_are_hidden_last() -> None:
    shown, hidden = names(3)
    assert shown == ['work', 'belt at rest']
    assert hidden == 10


def test_every_behaviour_has_a_path() -> None:
    assert dict(paths(sample()))['/cell/section 2/flags/retry/work'].status is Outcome.RUNNING


def test_what_is_shown_steers_no_terminal() -> None:
    tree = Branch('a', Outcome.RUNNING, 'words\nof it', False, (branch('b\x1b', Outcome.SUCCESS),))
    shown = printable(tree)
    assert (shown.words, shown.children[0].name) == ('words of it', 'b\ufffd')
