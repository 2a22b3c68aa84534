"""Who logs in at the OPC UA server, and who calls."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.quick_users import PASSWORD, write_users

from bt_orchestrator.extensions.opcua.server import calls
from bt_orchestrator.extensions.opcua.server.calls import CALLER, Caller, calling, client_of
from bt_orchestrator.extensions.opcua.server.overrides.security import People
from bt_orchestrator.model.by import Known, Role, ticket_in, without_ticket
from bt_orchestrator.model.limits import ORIGIN
from bt_orchestrator.script.users.file import UsersUnusable
from bt_orchestrator.script.users.logins import FREE_ATTEMPTS, LoginRefused, MustWait


@pytest.fixture
def users(tmp_path: Path) -> Path:
    return write_users(tmp_path / 'users.yaml', {'mes': Role.MES, 'vic': Role.VIEW})


@pytest.fixture
def people(users: Path) -> Iterator[People]:
    made = People(users)
    yield made
    made.close()


def test_user_logs_in_with_role_from_file(people: People) -> None:
    person = asyncio.run(people.log_in('mes', PASSWORD, '10.0.0.1'))
    assert people.role_of(person) is Role.MES


@pytest.mark.parametrize('name', ['mes', 'nobody', ''])
def test_wrong_password_and_unknown_name_look_alike(people: People, name: str) -> None:
    with pytest.raises(LoginRefused, match='no user with this name and password'):
        asyncio.run(people.log_in(name, 'another one', '10.0.0.1'))


def test_guesses_have_to_wait(people: People) -> None:
    for _ in range(FREE_ATTEMPTS):
        with pytest.raises(LoginRefused):
            asyncio.run(people.log_in('mes', 'a guess', '10.0.0.1'))
    with pytest.raises(MustWait):
        asyncio.run(people.log_in('mes', PASSWORD, '10.0.0.1'))
    asyncio.run(people.log_in('mes', PASSWORD, '10.0.0.2'))


def test_wrong_passwords_do_not_lock_out_others(
    users: Path,
) -> None:
    now = 0.0
    people = People(users, lambda: now)
    for _ in range(30):
        now += 60.0  # after the longest wait
        with pytest.raises(LoginRefused):
            asyncio.run(people.log_in('mes', 'the one of last year', '10.0.0.1'))
    assert asyncio.run(people.log_in('vic', PASSWORD, '10.0.0.1')).name == 'vic'
    people.close()


def test_user_and_role_changes_apply_at_once(people: People, users: Path) -> None:
    mes = asyncio.run(people.log_in('mes', PASSWORD, '10.0.0.1'))
    vic = asyncio.run(people.log_in('vic', PASSWORD, '10.0.0.1'))
    write_users(users, {'mes': Role.MES})
    assert people.role_of(vic) is None
    assert people.role_of(mes) is None  # a password that is hashed anew is another one


def test_users_file_open_to_others_denies_login(people: People, users: Path) -> None:
    mes = asyncio.run(people.log_in('mes', PASSWORD, '10.0.0.1'))
    users.chmod(0o644)
    assert people.role_of(mes) is None
    with pytest.raises(UsersUnusable, match='chmod 600'):
        asyncio.run(people.log_in('mes', PASSWORD, '10.0.0.1'))


def test_password_check_does_not_block_loop(
    people: People, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def turns_meanwhile() -> int:
        turns, check = 0, asyncio.create_task(people.log_in('mes', 'a guess', '10.0.0.1'))
        while not check.done():
            await asyncio.sleep(0)
            turns += 1
        with pytest.raises(LoginRefused):
            await check
        return turns

    is_checked = people._users.verify

    def slow(name: str, password: str) -> object:
        time.sleep(0.05)
        return is_checked(name, password)

    monkeypatch.setattr(people._users, 'verify', slow)
    assert asyncio.run(turns_meanwhile()) > 10


# --- who calls ----------------------------------------------------------------------------------


def test_who_calls_is_known_while_they_call() -> None:
    caller = Caller('mes', Role.MES, 'UaExpert at 10.0.0.1')
    with calling(caller):
        assert CALLER.get() is caller
    with pytest.raises(LookupError):
        CALLER.get()


def test_command_sender_is_user_and_names_client() -> None:
    with calling(Caller('mes', Role.MES, 'UaExpert at 10.0.0.1')):
        by = calls.by_caller('why', '0123456789abcdef')
    assert (by.who, by.role, by.reason) == ('mes', Role.MES, 'why')
    assert by.known is Known.OPC_UA_USER
    assert ticket_in(by.origin) == '0123456789abcdef'
    assert without_ticket(by.origin) == 'opcua, UaExpert at 10.0.0.1'


@pytest.mark.parametrize('name', ['x' * 5000, 'a\nb\x1b[31m', '', None])
def test_client_name_is_made_harmless(name: str | None) -> None:
    client = client_of(name, '[fe80::1234:5678:9abc:def0%eth0]:54321')
    assert client.isprintable()
    with calling(Caller('mes', Role.MES, client)):
        assert len(calls.by_caller('', '0123456789abcdef').origin) <= ORIGIN
