"""Texts from outside are cut to what may be kept of them."""

from __future__ import annotations

from bt_orchestrator.model.limits import MESSAGE, cut


def test_a_text_that_is_not_too_long_stays_whole() -> None:
    assert cut('x' * MESSAGE, MESSAGE) == 'x' * MESSAGE


def test_a_cut_text_begins_as_it_did_and_says_how_long_it_was() -> None:
    kept = cut('abc' * 10_000, MESSAGE)
    assert len(kept) == MESSAGE
    assert kept.startswith('abcabc')
    assert kept.endswith('c … (30000 characters, the rest is cut)')
