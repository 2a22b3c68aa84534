"""Keys in files: made, read, refused; numbers that rise; the keys in the file of users."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import KnownUsers, UsersFile, UsersUnusable
from bt_orchestrator.script.users.keys import Key, KeyUnusable, SigningKey
from bt_orchestrator.script.users.panels import NoSuchChange


@pytest.fixture
def users(tmp_path: Path) -> UsersFile:
    return UsersFile(tmp_path / 'users.yaml')


def made(folder: Path, name: str = 'ann') -> SigningKey:
    return SigningKey.made(folder / 'keys' / f'{name}.pem')


def test_key_is_private_and_reads_back(tmp_path: Path) -> None:
    key = made(tmp_path)
    path = tmp_path / 'keys' / 'ann.pem'
    assert path.stat().st_mode & 0o777 == 0o600
    again = SigningKey(path)
    assert (again.public, again.sign('x')) == (key.public, key.sign('x'))


def test_a_key_is_never_overwritten(tmp_path: Path) -> None:
    made(tmp_path)
    with pytest.raises(KeyUnusable, match='is there already'):
        made(tmp_path)


def test_what_is_no_key_is_refused_in_words(tmp_path: Path) -> None:
    path = tmp_path / 'key.pem'
    with pytest.raises(KeyUnusable, match='make one with: bt-orchestrator user key'):
        SigningKey(path)
    path.touch(0o600)
    for text in ('', 'no key', '-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n'):
        path.write_text(text)
        with pytest.raises(KeyUnusable, match='expected a private ed25519 key'):
            SigningKey(path)
    with pytest.raises(KeyUnusable, match=r'Is a directory|no ordinary file'):
        SigningKey(tmp_path)


def test_key_readable_by_others_is_refused(tmp_path: Path) -> None:
    made(tmp_path)
    path = tmp_path / 'keys' / 'ann.pem'
    path.chmod(0o640)
    with pytest.raises(KeyUnusable, match=r'\(mode 640\)'):
        SigningKey(path)


def test_a_key_of_another_kind_is_refused(tmp_path: Path) -> None:
    from cryptography.hazmat.primitives import serialization as form
    from cryptography.hazmat.primitives.asymmetric import ec

    path = tmp_path / 'ec.pem'
    path.touch(0o600)
    key = ec.generate_private_key(ec.SECP256R1())
    pem = (form.Encoding.PEM, form.PrivateFormat.PKCS8, form.NoEncryption())
    path.write_bytes(key.private_bytes(*pem))
    with pytest.raises(KeyUnusable, match='expected a private ed25519 key'):
        SigningKey(path)


def test_numbers_rise_after_clock_is_set_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    key = made(tmp_path)
    first = key.next_number()
    monkeypatch.setattr('time.time_ns', lambda: 5_000)
    second = key.next_number()
    third = SigningKey(tmp_path / 'keys' / 'ann.pem').next_number()
    assert first < second < third


def test_numbers_of_two_programs_with_one_key_differ(tmp_path: Path) -> None:
    made(tmp_path)
    path = tmp_path / 'keys' / 'ann.pem'
    code = (
        'import sys; from pathlib import Path; '
        'from bt_orchestrator.script.users.keys import SigningKey; '
        'key = SigningKey(Path(sys.argv[1])); '
        'print(*[key.next_number() for _ in range(300)])'
    )
    command = [sys.executable, '-c', code, str(path)]
    programs = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    outputs = [program.communicate(timeout=60)[0].split() for program in programs]
    numbers = [int(number) for output in outputs for number in output]
    assert len(set(numbers)) == 600


def test_clock_supplies_numbers_that_cannot_be_stored(tmp_path: Path) -> None:
    key = made(tmp_path)
    beside = tmp_path / 'keys' / 'ann.pem.number'
    beside.mkdir()
    assert key.next_number() < key.next_number()
    beside.rmdir()
    beside.write_text('no number')
    assert key.next_number() > 1e15


def test_missing_library_error_names_install_commands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / 'keys' / 'ann.pem'
    made(tmp_path)
    monkeypatch.setitem(sys.modules, 'cryptography.hazmat.primitives.asymmetric.ed25519', None)
    with pytest.raises(KeyUnusable, match='apt install python3-cryptography'):
        SigningKey(path)
    with pytest.raises(KeyUnusable, match=r"pip install 'bt_orchestrator\[signed\]'"):
        SigningKey.made(tmp_path / 'other.pem')


def test_keys_in_users_file_take_effect_at_once(tmp_path: Path, users: UsersFile) -> None:
    key = Key(Role.OPERATE, made(tmp_path).public)
    known = KnownUsers(tmp_path / 'users.yaml')
    assert known.keys() == {}
    users.add_key('ann', key)
    page = Key(Role.ENGINEER, made(tmp_path, 'page').public, 'page')
    users.add_key('page_1', page)
    assert known.keys() == {'ann': key, 'page_1': page}
    users.change_role('ann', Role.VIEW)
    assert known.keys()['ann'].role is Role.VIEW
    users.remove_key('ann')
    assert known.keys() == {'page_1': page}
    with pytest.raises(NoSuchChange, match='there is no key ann; there are: page_1'):
        users.remove_key('ann')


def test_removed_user_loses_key_and_panel(tmp_path: Path, users: UsersFile) -> None:
    users.add('ann', Role.OPERATE, 'long enough')
    users.add_key('ann', Key(Role.OPERATE, made(tmp_path).public))
    users.change_panel('key', 'ann', named=True)
    users.change_panel('user', 'ann', named=True)
    users.remove('ann')
    content = users.content()
    assert (dict(content.users), dict(content.keys), bool(content.panels)) == ({}, {}, False)


def test_second_name_or_second_key_is_refused(tmp_path: Path, users: UsersFile) -> None:
    key = Key(Role.OPERATE, made(tmp_path).public)
    users.add_key('ann', key)
    with pytest.raises(NoSuchChange, match='a key of ann is there already'):
        users.add_key('ann', Key(Role.OPERATE, made(tmp_path, 'bob').public))
    with pytest.raises(NoSuchChange, match='the key ann is there already'):
        users.add_key('bob', key)


def test_a_panel_is_a_key_of_a_person(tmp_path: Path, users: UsersFile) -> None:
    users.add_key('page_1', Key(Role.OPERATE, made(tmp_path).public, 'page'))
    with pytest.raises(NoSuchChange, match='there is no key ann; there are: page_1'):
        users.change_panel('key', 'ann', named=True)
    with pytest.raises(NoSuchChange, match='of a page, which says itself'):
        users.change_panel('key', 'page_1', named=True)


@pytest.mark.parametrize(
    'fields',
    [
        'no mapping',
        {'role': 'king', 'ed25519': 'A' * 43 + '='},
        {'role': 'view', 'ed25519': 'AAAA'},
        {'role': 'view', 'ed25519': 'A' * 43 + '=', 'door': 'window'},
        {'role': 'view'},
    ],
)
def test_a_damaged_key_lets_nobody_in(tmp_path: Path, users: UsersFile, fields: object) -> None:
    users.add('ann', Role.OPERATE, 'long enough')
    path = tmp_path / 'users.yaml'
    plain = yaml.safe_load(path.read_text())
    path.write_text(yaml.safe_dump({**plain, 'keys': {'bob': fields}}))
    with pytest.raises(UsersUnusable, match='not a file of users, or it is damaged'):
        users.content()
