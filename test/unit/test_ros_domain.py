"""Tests do not meet in a ROS domain."""

from __future__ import annotations

import os

import pytest
from ros_domain import OwnDomain


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let there be three domains, which no other test run uses."""
    monkeypatch.setattr('ros_domain.DOMAINS', range(1001, 1004))
    monkeypatch.setenv('ROS_DOMAIN_ID', '')


def places(*domains: OwnDomain) -> list[str]:
    """Let each move in turn, and return where they are then."""
    found = []
    for domain in domains:
        domain.move()
        found.append(os.environ['ROS_DOMAIN_ID'])
    return found


def test_nobody_else_is_in_it() -> None:
    with OwnDomain() as one, OwnDomain() as other:
        for _ in range(4):
            assert len(set(places(one, other))) == 2


def test_a_kept_one_stays_free_of_others_until_it_is_let_go() -> None:
    with OwnDomain() as one, OwnDomain() as other:
        [kept] = places(one)
        with one.keep():
            places(one)
            with pytest.raises(pytest.UsageError, match='all ROS domains'):
                places(other)
        assert places(other) == [kept]
