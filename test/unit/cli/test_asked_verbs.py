"""Verbs that ask something of a cell take their words and their help from the table."""

from __future__ import annotations

import shlex

import pytest

from bt_orchestrator.cli.main import main, parsed
from bt_orchestrator.cli.verbs import actions_of, command_of, help_line
from bt_orchestrator.model.requests import (
    ANSWERS,
    CONTROLS,
    TABLE,
    UNIT_MODES,
    About,
    Request,
    Why,
)

IN_GROUPS = (About.CELL, About.JOB, About.COMPONENT)


def command(request: Request) -> list[str]:
    """Return the verb of a request, and its action if it has one."""
    word = request.word.replace('_', '-')
    if word.startswith('stop-after'):
        return ['cell', 'stop-after']
    return [request.about.value, word] if request.about in (*IN_GROUPS, About.QUEUE) else [word]


ASKED = [request for request in TABLE if request.about is not About.HOLD]


@pytest.mark.parametrize('request_', ASKED, ids=lambda request: request.name)
def test_each_request_has_its_own_help(
    request_: Request, capsys: pytest.CaptureFixture[str]
) -> None:
    words = command(request_)
    with pytest.raises(SystemExit, match='0'):
        main([*words, '--help'])
    output = ' '.join(capsys.readouterr().out.split())
    assert output.startswith(f'usage: bt-orchestrator {" ".join(words)} ')
    assert request_.effect[1:] in output
    for role in request_.roles:
        assert role.value in output


def test_a_group_lists_its_actions(capsys: pytest.CaptureFixture[str]) -> None:
    for about in IN_GROUPS:
        with pytest.raises(SystemExit, match='0'):
            main([about.value, '--help'])
        output = ' '.join(capsys.readouterr().out.split())
        for request in TABLE:
            if request.about is about and 'stop_after' not in request.word:
                assert f' {request.word.replace("_", "-")} {request.effect}' in output


def test_group_help_lists_common_actions() -> None:
    assert {word for word in actions_of('cell') if word != 'stop-after'} <= set(
        help_line('cell').partition(': ')[2].split(', ')
    )
    assert set(help_line('job').partition(': ')[2].split(', ')) <= set(actions_of('job'))


OLD_FORMS = [
    ('pause', 'cell pause'),
    ('stop --reason "end of shift"', 'cell stop --reason "end of shift"'),
    ('abort --json', 'cell abort --json'),
    ('reset --reason w', 'cell reset --reason w'),
    ('start --reason w', 'cell start --reason w'),
    ('resume --hold 3 --reason w', 'cell resume --hold 3 --reason w'),
    ('resume --all --reason w', 'cell resume --all --reason w'),
    ('clear --as-shown 7 --reason w', 'cell clear --as-shown 7 --reason w'),
    ('out-of-service arm --reason w', 'component out-of-service arm --reason w'),
    ('in-service arm --reason w', 'component in-service arm --reason w'),
    ('queue move A 2 --reason w', 'job move A 2 --reason w'),
    ('queue --as B requeue A --reason w', 'job requeue A --as B --reason w'),
    ('queue --reason next hold A', 'job hold A --reason next'),
    ('queue remove A --reason w', 'job remove A --reason w'),
    ('queue stop-after job --reason w', 'cell stop-after job --reason w'),
    ('queue update A --param lot=A8 --reason w', 'job update A --param lot=A8 --reason w'),
]


@pytest.mark.parametrize(('old', 'new'), OLD_FORMS)
def test_old_form_works_and_names_new_one(
    old: str, new: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before, after = parsed(shlex.split(old)), parsed(shlex.split(new))
    captured = capsys.readouterr()
    assert vars(before).keys() == vars(after).keys()
    for name, value in vars(before).items():
        if name not in ('carry_out', 'ros_args'):
            assert value == getattr(after, name), name
    assert captured.out == ''
    assert captured.err.endswith(f'` is now `{after.verb}`\n')
    assert len(captured.err.splitlines()) == 1


def test_every_old_form_is_known() -> None:
    requests = {' '.join(command(entry)): entry for entry in TABLE if entry.about in IN_GROUPS}
    for name, request in requests.items():
        word = name.split()[1]
        if request in CONTROLS.values() or request in UNIT_MODES.values() or request.is_manual:
            continue  # never were verbs
        old = [word] if request.about is not About.JOB else ['queue', word]
        if word == 'stop-after':
            old = ['queue', word]
        assert command_of(old).name == name


@pytest.mark.parametrize(
    'line', ['queue', 'queue --json', 'queue --node /list --json', 'queue list']
)
def test_queue_alone_lists(line: str) -> None:
    assert parsed(line.split()).verb == 'queue list'


@pytest.mark.parametrize(
    ('line', 'message'),
    [
        ('cell', 'arguments are required: ACTION'),
        ('cell puase', "found 'puase'; did you mean pause?"),
        ('job mvoe A 2', "found 'mvoe'; did you mean move?"),
        ('queue mvoe A 2', "found 'mvoe'"),
        ('component --reason x', 'arguments are required: ACTION'),
    ],
)
def test_a_wrong_action_is_told(
    line: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match='2'):
        main(line.split())
    assert message in capsys.readouterr().err


@pytest.mark.parametrize('word', ['pause', 'stop', 'abort', 'reset', 'start', 'resume'])
def test_danger_does_not_wait_for_a_reason(word: str, capsys: pytest.CaptureFixture[str]) -> None:
    (request,) = (entry for entry in TABLE if entry.about is About.CELL and entry.word == word)
    if request.why is Why.AFTERWARDS:
        assert parsed(['cell', word]).reason is None
    else:
        with pytest.raises(SystemExit):
            parsed(['cell', word])
        assert '--reason' in capsys.readouterr().err


def test_every_answer_is_in_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(['answer', '--help'])
    output = capsys.readouterr().out
    for word, request in ANSWERS.items():
        assert word in output
        assert request.effect in output
