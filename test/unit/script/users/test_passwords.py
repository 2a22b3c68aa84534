"""Passwords: what is kept of them, and what it takes to guess one."""

from __future__ import annotations

import pytest

from bt_orchestrator.script.users.passwords import NOBODYS, BadPassword, Cost, hashed

CHEAP = Cost(n=16, p=1)


def test_a_password_matches_and_others_do_not() -> None:
    kept = hashed('correct horse', CHEAP)
    assert kept.matches('correct horse')
    for other in ('correct hors', 'Correct horse', 'correct horse ', ''):
        assert not kept.matches(other)
    assert not NOBODYS.matches('')


def test_two_of_one_password_look_different() -> None:
    first, other = hashed('correct horse', CHEAP), hashed('correct horse', CHEAP)
    assert (first.salt, first.digest) != (other.salt, other.digest)


def test_password_matches_in_any_unicode_form() -> None:
    assert hashed('Gr\u00fc\u00dfe aus K\u00f6ln', CHEAP).matches(
        'Gru\u0308\u00dfe aus Ko\u0308ln'
    )


@pytest.mark.parametrize('password', ['', 'short', 'x' * 201])
def test_what_is_no_password(password: str) -> None:
    with pytest.raises(BadPassword, match=f'8 to 200 characters; found {len(password)}'):
        hashed(password)


def test_hash_cost_is_limited_to_sane_values() -> None:
    assert Cost().is_sane
    assert hashed('correct horse').matches('correct horse')
    for cost in (Cost(n=2**40), Cost(n=1000), Cost(n=1), Cost(p=0), Cost(p=17), Cost(r=0)):
        assert not cost.is_sane
