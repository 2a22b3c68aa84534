"""Journals damaged at random: the same state, or told and held, or refused; never silent.

`scripts/damage` does the same with as many cases as one likes.
"""

from __future__ import annotations

import sqlite3
from collections import Counter
from pathlib import Path

import pytest
from damage.judge import Verdict, judge
from damage.kinds import Case, draw
from damage.scene import ENDINGS, NAME, Scene, make_scenes

CASES = 80
SEED = 1


@pytest.fixture(scope='module')
def scenes(tmp_path_factory: pytest.TempPathFactory) -> list[Scene]:
    return make_scenes(tmp_path_factory.mktemp('scenes'))


def test_nothing_is_forgotten_without_a_word(scenes: list[Scene], tmp_path: Path) -> None:
    counts: Counter[Verdict] = Counter()
    for case in draw(scenes, CASES):
        judgement = judge(case, tmp_path / str(case.number), SEED)
        assert judgement.verdict not in (Verdict.SILENT, Verdict.FAULT), (case.words, judgement)
        counts[judgement.verdict] += 1
    assert all(counts[good] for good in (Verdict.SAME, Verdict.HELD, Verdict.REFUSED))


def test_line_resumes_before_any_damaged_record(
    scenes: list[Scene], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    merged = scenes[1]
    held = []
    last = merged.events[-1].seq

    def spoil(case: Case, path: Path, _: int) -> None:
        database = sqlite3.connect(path)
        text = "CAST(replace(record, 'e', 'f') AS TEXT)"
        database.execute(f'UPDATE events SET record = {text} WHERE seq = ?', (case.number,))
        database.commit()
        database.close()

    monkeypatch.setattr('damage.judge.damage', spoil)
    for seq in range(last - 60, last + 1):
        case = Case(seq, 'record', ENDINGS[0], merged)
        judgement = judge(case, tmp_path / str(seq), SEED)
        assert judgement.verdict in (Verdict.HELD, Verdict.SAME), (seq, judgement)
        if judgement.verdict is Verdict.HELD:
            held.append(seq)
            assert 'a record after event' in judgement.said
            assert (tmp_path / str(seq) / NAME).exists()
    assert held == list(range(held[0], last + 1))
    assert len(held) > 20


def test_cases_are_reproducible_and_cover_every_kind(scenes: list[Scene]) -> None:
    cases = list(draw(scenes, 400))
    assert cases == list(draw(scenes, 400))
    assert set(Counter(case.kind for case in cases).values()) == {80}
    assert {case.ending for case in cases} == set(ENDINGS)
