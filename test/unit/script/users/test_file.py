"""The file of users: real files, other processes, damage."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from fakes.quick_users import QUICK

from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users import file, passwords
from bt_orchestrator.script.users.file import NoHome, UsersFile, UsersUnusable, default_file
from bt_orchestrator.script.users.panels import NoSuchChange
from bt_orchestrator.script.users.passwords import NOBODYS

PASSWORD = 'correct horse'


@pytest.fixture(autouse=True)
def quick_passwords(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passwords, 'Cost', lambda: QUICK)
    monkeypatch.setattr(file, 'NOBODYS', replace(NOBODYS, cost=QUICK))


@pytest.fixture
def users(tmp_path: Path) -> UsersFile:
    return UsersFile(tmp_path / 'config' / 'users.yaml')


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'config' / 'users.yaml'


def test_nobody_is_there_before_somebody_is_added(users: UsersFile, path: Path) -> None:
    assert users.read() == {}
    assert users.verify('ann', PASSWORD) is None
    assert not path.exists()


def test_added_user_logs_in_with_role(users: UsersFile, path: Path) -> None:
    users.add('ann', Role.OPERATE, PASSWORD)
    users.add('mes', Role.MES, 'another one')
    assert users.verify('ann', PASSWORD) is Role.OPERATE
    assert users.verify('mes', 'another one') is Role.MES
    assert users.verify('ann', 'another one') is None
    assert users.verify('Ann', PASSWORD) is None
    users.change_role('ann', Role.ENGINEER)
    assert users.verify('ann', PASSWORD) is Role.ENGINEER
    users.remove('ann')
    assert users.verify('ann', PASSWORD) is None
    assert list(users.read()) == ['mes']
    assert PASSWORD not in path.read_text()


def test_a_deeply_nested_file_is_refused(users: UsersFile, path: Path) -> None:
    users.add('ann', Role.OPERATE, PASSWORD)
    path.write_text('[' * 100_000)
    with pytest.raises(UsersUnusable, match='this is not a file of users'):
        users.read()


def test_users_file_is_private_under_any_umask(users: UsersFile, path: Path) -> None:
    before = os.umask(0)
    try:
        users.add('ann', Role.OPERATE, PASSWORD)
    finally:
        os.umask(before)
    assert path.stat().st_mode & 0o777 == 0o600
    assert sorted(file.name for file in path.parent.iterdir()) == [
        '.users.yaml.lock',
        'users.yaml',
    ]


@pytest.mark.parametrize('mode', [0o640, 0o604, 0o620, 0o660, 0o644])
def test_one_that_others_may_open_lets_nobody_in(users: UsersFile, path: Path, mode: int) -> None:
    users.add('ann', Role.OPERATE, PASSWORD)
    path.chmod(mode)
    for attempt in (
        users.read,
        lambda: users.verify('ann', PASSWORD),
        lambda: users.remove('ann'),
    ):
        with pytest.raises(UsersUnusable, match=f'mode {mode:o}.*chmod 600'):
            attempt()
    path.chmod(0o600)
    assert users.verify('ann', PASSWORD) is Role.OPERATE


@pytest.mark.parametrize(
    'text',
    [
        '',
        'format: 1',
        'format: 2\nusers: {}',
        'users: [',
        '- ann',
        'format: 1\nusers: {ann: {role: operate}}',
        'format: 1\nusers: {1: {role: operate}}',
        '\x00\x01',
    ],
)
def test_a_damaged_one_is_told_and_left_alone(users: UsersFile, path: Path, text: str) -> None:
    path.parent.mkdir()
    path.write_text(text)
    path.chmod(0o600)
    for attempt in (users.read, lambda: users.add('ann', Role.OPERATE, PASSWORD)):
        with pytest.raises(UsersUnusable, match='not a file of users, or it is damaged'):
            attempt()
    assert path.read_text() == text


def test_pipe_device_and_endless_file_are_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'pipe', 0o600)
    os.truncate(os.open(tmp_path / 'huge', os.O_CREAT | os.O_WRONLY, 0o600), 10_000_000)
    for name in (tmp_path / 'pipe', Path('/dev/zero')):
        with pytest.raises(
            UsersUnusable, match='this is a pipe or a device, and no ordinary file'
        ):
            UsersFile(name).read()
    with pytest.raises(UsersUnusable, match='huge: the file is larger than 4 MB'):
        UsersFile(tmp_path / 'huge').read()


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('role', 'root'),
        ('scrypt', {'n': 2**40, 'r': 8, 'p': 1}),
        ('scrypt', {'n': 16, 'r': 8, 'q': 1}),
        ('salt', 'no base64!'),
    ],
)
def test_a_user_that_cannot_be_is_damage(
    users: UsersFile, path: Path, field: str, value: object
) -> None:
    users.add('ann', Role.OPERATE, PASSWORD)
    plain = yaml.safe_load(path.read_text())
    ann = plain['users']['ann']
    (ann if field == 'role' else ann['password'])[field] = value
    path.write_text(yaml.safe_dump(plain))
    with pytest.raises(UsersUnusable, match='damaged'):
        users.verify('ann', PASSWORD)


def test_names_that_are_none_or_taken_are_refused(users: UsersFile) -> None:
    users.add('ann', Role.OPERATE, PASSWORD)
    for name in ('', ' ann', 'a\nb', 'x' * 201):
        with pytest.raises(NoSuchChange, match='is not a name'):
            users.add(name, Role.VIEW, PASSWORD)
    with pytest.raises(NoSuchChange, match='ann is there already'):
        users.add('ann', Role.ENGINEER, PASSWORD)
    with pytest.raises(NoSuchChange, match='there is no user bob; there are: ann'):
        users.remove('bob')
    with pytest.raises(NoSuchChange, match='there is no user bob'):
        users.change_role('bob', Role.VIEW)
    assert users.verify('ann', PASSWORD) is Role.OPERATE


ADD = """
import sys
from pathlib import Path
from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import UsersFile

for number in range(2):
    UsersFile(Path(sys.argv[1])).add(f'{sys.argv[2]}{number}', Role.VIEW, 'correct horse')
"""


def test_concurrent_programs_lose_no_added_user(users: UsersFile, path: Path) -> None:
    programs = [subprocess.Popen([sys.executable, '-c', ADD, str(path), name]) for name in 'abc']
    assert [program.wait() for program in programs] == [0, 0, 0]
    assert sorted(users.read()) == [f'{name}{number}' for name in 'abc' for number in range(2)]


def test_where_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    set_ = {'XDG_CONFIG_HOME': str(tmp_path)}
    assert default_file(set_) == tmp_path / 'bt_orchestrator' / 'users.yaml'
    monkeypatch.setenv('HOME', '/home/ann')
    assert default_file({}) == Path('/home/ann/.config/bt_orchestrator/users.yaml')


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    for folder in (Path(), Path('/'), tmp_path):
        with pytest.raises(UsersUnusable, match='Is a directory'):
            UsersFile(folder).remove('ann')


def test_user_without_home_gets_instructions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Containers run programs under user ids that nobody has."""
    monkeypatch.delenv('HOME', raising=False)
    monkeypatch.setattr(Path, 'home', nobodys_home)
    with pytest.raises(NoHome, match=r'no home folder for user id \d+, .* set HOME or XDG_CONFIG'):
        default_file({})
    assert default_file({'XDG_CONFIG_HOME': '/x'}) == Path('/x/bt_orchestrator/users.yaml')


def nobodys_home() -> Path:
    raise RuntimeError('Could not determine home directory.')


def test_panels_are_kept_beside_the_users(users: UsersFile, path: Path) -> None:
    users.add('ann', Role.OPERATE, PASSWORD)
    users.change_panel('user', 'ann', named=True)
    users.change_panel('address', '::FFFF:192.168.3.20', named=True)
    users.change_panel('certificate', THUMBPRINT.upper(), named=True)
    users.add('bob', Role.MES, PASSWORD)
    panels = UsersFile(path).content().panels
    assert list(panels) == [
        ('user', 'ann'),
        ('address', '192.168.3.20'),
        ('certificate', THUMBPRINT),
    ]
    assert panels.have('ann', '10.0.0.1')
    assert panels.have('bob', '192.168.3.20')
    assert panels.have('bob', '', THUMBPRINT)
    assert not panels.have('bob', '192.168.3.2', THUMBPRINT[:-1])
    assert not panels.have('bob')
    users.remove('ann')
    assert 'ann' not in UsersFile(path).content().panels.users


THUMBPRINT = '5d362cc2a1b0c9d8e7f6a5b4c3d2e1f00a1b2c3d'


@pytest.mark.parametrize(
    ('kind', 'name', 'named', 'message'),
    [
        ('user', 'eve', True, 'there is no user eve; there are: ann'),
        ('address', 'panel.plant', True, "'panel.plant' is no IP address"),
        ('certificate', '5d36', True, "'5d36' is no thumbprint of 40 hexadecimal digits"),
        ('address', '10.0.0.1', False, 'the address 10.0.0.1 is no panel; there are: none'),
    ],
)
def test_a_panel_that_cannot_be_is_refused(
    users: UsersFile, kind: str, name: str, named: bool, message: str
) -> None:
    users.add('ann', Role.OPERATE, PASSWORD)
    with pytest.raises(NoSuchChange) as refused:
        users.change_panel(kind, name, named=named)
    assert message in str(refused.value)


def test_panels_that_somebody_damaged_let_nobody_in(users: UsersFile, path: Path) -> None:
    users.add('ann', Role.OPERATE, PASSWORD)
    path.write_text(f'{path.read_text()}panels: {{addresses: [here]}}\n')
    with pytest.raises(UsersUnusable, match='this is not a file of users'):
        users.content()
