"""Verbs that ask something of a cell take their words and their help from the table."""

from __future__ import annotations

import pytest

from bt_orchestrator.cli.main import VERBS, help_line, main, parsed
from bt_orchestrator.model.requests import ANSWERS, TABLE, About, Why

ASKING = [verb for verb, (_, line) in VERBS.items() if not line]


SUBJECTS = (About.CELL, About.ITEM, About.COMPONENT, About.SCRIPT)


def test_every_request_to_cell_items_components_and_scripts_has_its_verb() -> None:
    words = {request.word.replace('_', '-') for request in TABLE if request.about in SUBJECTS}
    assert {word for word in words if not word.startswith('stop-after')} == set(ASKING)


@pytest.mark.parametrize('verb', ASKING)
def test_the_help_of_a_verb_says_what_it_does_and_who_may(
    verb: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (request,) = (
        one for one in TABLE if one.about in SUBJECTS and one.word == verb.replace('-', '_')
    )
    assert request.effect in help_line(verb)
    with pytest.raises(SystemExit):
        main([verb, '--help'])
    told = ' '.join(capsys.readouterr().out.split())
    assert request.effect[1:] in told
    assert f'For: {", ".join(sorted_roles(request.roles))}.' in told


def sorted_roles(roles: frozenset[object]) -> list[str]:
    return [name for name in ('view', 'mes', 'operate', 'engineer') if name in map(_value, roles)]


def _value(role: object) -> str:
    return str(getattr(role, 'value', ''))


@pytest.mark.parametrize('verb', ['pause', 'stop', 'abort', 'reset', 'start', 'resume'])
def test_danger_does_not_wait_for_a_reason(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    (request,) = (one for one in TABLE if one.about is About.CELL and one.word == verb)
    if request.why is Why.AFTERWARDS:
        assert parsed([verb]).reason is None
    else:
        with pytest.raises(SystemExit):
            parsed([verb])
        assert '--reason' in capsys.readouterr().err


def test_every_word_is_in_the_help_of_queue_and_answer(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for verb in ('queue', 'answer'):
        with pytest.raises(SystemExit):
            main([verb, '--help'])
    told = capsys.readouterr().out
    for request in TABLE:
        if request.about in (About.JOB, About.QUEUE):
            assert f'queue {request.word} ' in told
    for word, request in ANSWERS.items():
        assert word in told
        assert request.effect in told
