"""Texts from outside are cut to what may be kept of them."""

from __future__ import annotations

from bt_orchestrator.model.limits import MESSAGE, cut, listed, without_longest


def test_short_text_stays_whole() -> None:
    assert cut('x' * MESSAGE, MESSAGE) == 'x' * MESSAGE


def test_cut_text_keeps_beginning_and_names_length() -> None:
    kept = cut('abc' * 10_000, MESSAGE)
    assert len(kept) == MESSAGE
    assert kept.startswith('abcabc')
    assert kept.endswith('c … (30000 characters, the rest is cut)')


def test_few_names_are_listed_and_many_counted() -> None:
    assert listed(['a', 'b'], 'none') == 'a, b'
    assert listed([], 'none') == 'none'
    names = [f'J{number}' for number in range(10_000)]
    assert listed(names, 'none') == f'{", ".join(names[:20])} and 9980 more'


def test_longest_fields_are_dropped_until_rest_fits() -> None:
    image, text = [0] * 1000, 'x' * 900
    assert without_longest({'a': 1, 'image': image, 'text': text}, 1000) == {'a': 1, 'text': text}
    assert without_longest({'a': 1, 'text': text}, 1000) == {'a': 1, 'text': text}
