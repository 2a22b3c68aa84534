"""Options of the page that go together, and those that would let in anybody."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from fakes.certificates import make_certificate
from fakes.quick_users import write_users

from bt_orchestrator.extensions.page.web.access import Access, AccessRefused
from bt_orchestrator.model.by import Role
from bt_orchestrator.ports.doors.listening import is_loopback


@pytest.fixture
def users(tmp_path: Path) -> Path:
    return write_users(tmp_path / 'users.yaml', {'ann': Role.OPERATE})


@pytest.fixture(scope='module')
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp('tls')
    return make_certificate(folder)


def refusal(**options: Any) -> str:
    with pytest.raises(AccessRefused) as refused:
        Access(**options).check()
    return str(refused.value)


def test_on_this_computer_nothing_is_needed_for_looking(tmp_path: Path) -> None:
    access = Access(tmp_path / 'no users.yaml')
    access.check()
    assert access.looks_freely


def test_damaged_users_file_is_reported_at_start(tmp_path: Path) -> None:
    damaged = tmp_path / 'users.yaml'
    damaged.write_text('users: [ann')
    damaged.chmod(0o600)
    assert 'not a file of users, or it is damaged' in refusal(users=damaged)


@pytest.mark.parametrize('host', ['0.0.0.0', '192.168.1.5', '::', 'line-1.example.org', ''])
def test_elsewhere_it_needs_users_and_tls(
    host: str, users: Path, tmp_path: Path, certificate: tuple[Path, Path]
) -> None:
    assert 'passwords would cross the network in the clear' in refusal(users=users, host=host)
    tls: Any = {'certificate': certificate[0], 'key': certificate[1]}
    nobody = tmp_path / 'none.yaml'
    assert 'no users in' in refusal(users=nobody, host=host, **tls)
    access = Access(users, host, **tls)
    access.check()
    assert not access.looks_freely


def test_a_proxy_in_place_of_tls(users: Path, tmp_path: Path) -> None:
    access = Access(users, '0.0.0.0', proxy_header='X-User', proxy_addresses=('10.0.0.2',))
    access.check()
    assert 'no users in' in refusal(users=tmp_path / 'none.yaml', proxy_header='X-User')


def test_proxy_header_disables_free_local_view(users: Path) -> None:
    assert not Access(users, proxy_header='X-User').looks_freely


def test_who_is_trusted_must_be_at_this_computer(
    users: Path, certificate: tuple[Path, Path]
) -> None:
    tls: Any = {'certificate': certificate[0], 'key': certificate[1]}
    assert '--trust-this-computer makes everybody who reaches the page an engineer' in refusal(
        users=users, host='0.0.0.0', local_user='pat', **tls
    )
    assert 'leave it out, or --behind-proxy' in refusal(
        users=users, local_user='pat', proxy_header='X-User'
    )
    Access(users, local_user='pat').check()


def test_options_in_pairs(users: Path) -> None:
    assert 'belong together' in refusal(users=users, key=users)
    assert 'give --behind-proxy too' in refusal(users=users, proxy_addresses=('10.0.0.2',))
    assert "an IP address; found 'proxy'" in refusal(
        users=users, proxy_header='X', proxy_addresses=('proxy',)
    )


def test_certificates_that_cannot_be_used(
    users: Path, tmp_path: Path, certificate: tuple[Path, Path]
) -> None:
    missing = tmp_path / 'none.pem'
    assert 'none.pem: there is no such file' in refusal(
        users=users, certificate=missing, key=certificate[1]
    )
    assert 'are no certificate and its key' in refusal(
        users=users, certificate=certificate[0], key=users
    )
    (tmp_path / 'other').mkdir()
    other = make_certificate(tmp_path / 'other')
    assert 'KEY_VALUES_MISMATCH' in refusal(users=users, certificate=certificate[0], key=other[1])


def test_users_that_others_may_read_are_no_users(
    users: Path, certificate: tuple[Path, Path]
) -> None:
    users.chmod(0o644)
    assert 'chmod 600' in refusal(
        users=users, host='0.0.0.0', certificate=certificate[0], key=certificate[1]
    )


@pytest.mark.parametrize(
    ('address', 'is_here'),
    [
        ('127.0.0.1', True),
        ('127.8.8.8', True),
        ('::1', True),
        ('::ffff:127.0.0.1', True),
        ('localhost', True),
        ('0.0.0.0', False),
        ('::', False),
        ('10.0.0.1', False),
        ('localhost.example.org', False),
        ('', False),
    ],
)
def test_this_computer(address: str, is_here: bool) -> None:
    assert is_loopback(address) is is_here


@pytest.mark.parametrize(
    ('host', 'name', 'is_allowed'),
    [
        ('127.0.0.1', '127.0.0.1', True),
        ('127.0.0.1', 'localhost', True),
        ('127.0.0.1', 'LOCALHOST.', True),
        ('127.0.0.1', '::1', True),
        ('127.0.0.1', 'line-1', False),
        ('127.0.0.1', '10.0.0.1', False),
        ('127.0.0.1', 'evil.example.org', False),
        ('127.0.0.1', '', False),
        ('10.0.0.1', '10.0.0.1', True),
        ('0.0.0.0', '10.0.0.1', True),
        ('0.0.0.0', 'evil.example.org', False),
        ('0.0.0.0', 'Page.Example.org', True),
    ],
)
def test_names_of_the_page(host: str, name: str, is_allowed: bool, users: Path) -> None:
    access = Access(users, host, allowed_hosts=('page.example.org',))
    assert access.is_allowed_host(name) is is_allowed


def test_addresses_of_the_proxy(users: Path) -> None:
    access = Access(users, proxy_header='X-User', proxy_addresses=('10.0.0.2',))
    assert access.is_proxy('127.0.0.1')
    assert access.is_proxy('::ffff:10.0.0.2')
    assert not access.is_proxy('10.0.0.3')
    assert not access.is_proxy('')
    assert not Access(users).is_proxy('127.0.0.1')
