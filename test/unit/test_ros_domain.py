"""Tests do not meet in a ROS domain."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from ros_domain import OwnDomain


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let there be three domains, which no other test run uses."""
    monkeypatch.setattr('ros_domain.DOMAINS', range(1001, 1004))
    monkeypatch.setenv('ROS_DOMAIN_ID', '')


def places(*domains: OwnDomain) -> list[str]:
    """Let each move in turn, and return where they are then."""
    numbers = []
    for domain in domains:
        domain.move()
        numbers.append(os.environ['ROS_DOMAIN_ID'])
    return numbers


def test_nobody_else_is_in_it() -> None:
    with OwnDomain() as domain, OwnDomain() as other:
        for _ in range(4):
            assert len(set(places(domain, other))) == 2


def test_kept_domain_stays_reserved_until_released() -> None:
    with OwnDomain() as domain, OwnDomain() as other:
        [kept] = places(domain)
        with domain.keep():
            places(domain)
            with pytest.raises(pytest.UsageError, match='all ROS domains'):
                places(other)
        assert places(other) == [kept]


def test_nor_is_anybody_who_takes_no_lock(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    port_of_42 = '356: 0100007F:45F6 00000000:0000 07 0:0 0:0 0 0 0 1 2 0 0'
    (tmp_path / 'udp').write_text(f'sl  local_address rem_address\n  {port_of_42}\n')
    monkeypatch.setattr('ros_domain.SOCKETS', tmp_path / 'udp')
    monkeypatch.setattr('ros_domain.DOMAINS', range(41, 44))
    monkeypatch.setattr('ros_domain.LOCKS', tmp_path)  # others may be in these domains
    with OwnDomain() as domain:
        assert set(places(domain, domain, domain)) == {'41', '43'}
