"""The file of reasons: its content, and every mistake with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.cli.main import main
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.script.shifts.shifts_file import parse_reasons


def test_reasons_have_words_and_groups() -> None:
    text = 'reasons: {JAM: {words: {en: jam, de: Stau}, group: belt}, X: {words: {fr: panne}}}'
    reasons = parse_reasons(text, 'r.yaml')
    assert list(reasons.values()) == [
        PlantReason('JAM', {'en': 'jam', 'de': 'Stau'}, 'belt'),
        PlantReason('X', {'fr': 'panne'}),
    ]
    assert [reasons['JAM'].said(name) for name in ('de', 'en', 'fr')] == ['Stau', 'jam', 'jam']
    assert reasons['X'].said('de') == 'panne'


@pytest.mark.parametrize(
    ('text', 'finding'),
    [
        ('reasons: {}', '1:10: no reason is named'),
        ('reasons: {A B: {words: {en: x}}}', '1:11: `A B` cannot be a code of a reason'),
        ('reasons: {A: {group: g}}', '1:14: a reason needs the key `words`'),
        ('reasons: {A: {words: {}}}', '1:22: the reason has no words'),
        ('reasons: {A: {words: {english: x}}}', '1:23: `english` is no code of a language'),
        ('reasons: {A: {words: {en: [x]}}}', '1:27: the words in `en` must be a text, not a list'),
        ('reasons: {A: {words: {en: x}, grup: y}}', 'a reason has no key `grup`; did you mean'),
        (f'reasons: {{A: {{words: {{en: {"x" * 81}}}}}}}', 'has 81 characters; use at most 80'),
        ('shifts: {}', 'this is a file of shifts, and a file of reasons is expected'),
    ],
)
def test_a_mistake_has_its_place(text: str, finding: str) -> None:
    with pytest.raises(Refused) as refused:
        parse_reasons(text, 'r.yaml')
    assert finding in '\n'.join(map(str, refused.value.findings))


def test_check_of_plant_files_needs_no_cell(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / 'reasons.yaml'
    file.write_text('reasons: {JAM: {words: {en: jam}}}')
    assert main(['check', '--reasons', str(file)]) == 0
    assert capsys.readouterr().out == f'{file}: 1 reason\n'
    file.write_text('reasons: {JAM: {wort: x}}')
    assert main(['check', '--reasons', str(file)]) == 1
    assert f'{file}:1:17: a reason has no key `wort`' in capsys.readouterr().err
    assert main(['check']) == 2
