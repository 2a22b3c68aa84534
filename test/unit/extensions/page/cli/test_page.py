"""The options of the verb `page`, what it refuses, and what it writes."""

from __future__ import annotations

import argparse
import getpass
import logging
import socket
import sys
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.quick_users import write_users
from fakes.shipped import REFERENCE_CELL

from bt_orchestrator.base.extending import PAGE
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.serving import server_log
from bt_orchestrator.extensions.page import verb
from bt_orchestrator.extensions.page.verb import ROOM, access_of, plant_of
from bt_orchestrator.extensions.page.web.access import IDLE_S, Access
from bt_orchestrator.extensions.page.web.seams import Plant
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.plant.shifts import Hours, Shift, Shifts
from bt_orchestrator.script.cell_file import read_cell


def access(*words: str) -> Access:
    parser = argparse.ArgumentParser()
    verb.add_arguments(parser)
    return access_of(parser.parse_args(words))


def test_default_access_is_local_view_only(tmp_path: Path) -> None:
    defaults = access('--users', str(tmp_path / 'none.yaml'))
    assert defaults == Access(tmp_path / 'none.yaml', port=PAGE.port)
    assert defaults.idle_s == IDLE_S


def test_trusted_computer_acts_as_program_user(tmp_path: Path) -> None:
    assert access('--trust-this-computer').local_user == getpass.getuser()


def test_every_option_arrives(tmp_path: Path) -> None:
    users = write_users(tmp_path / 'users.yaml', {'ann': Role.OPERATE})
    words = ('--users', users, '--host', '0.0.0.0', '--port', 0, '--lock-after', 60)
    proxy = ('--behind-proxy', 'X-User', '--proxy-address', '10.0.0.2', '--proxy-address', '::5')
    hosts = ('--allow-host', 'a.example.org', '--allow-host', 'b.example.org')
    assert access(*map(str, (*words, *proxy, *hosts))) == Access(
        users,
        '0.0.0.0',
        0,
        allowed_hosts=('a.example.org', 'b.example.org'),
        proxy_header='X-User',
        proxy_addresses=('10.0.0.2', '::5'),
        idle_s=60.0,
    )


def plant(*words: object) -> Plant | None:
    parser = argparse.ArgumentParser()
    verb.add_arguments(parser)
    return plant_of(parser.parse_args([*map(str, words)]))


def test_shift_has_hours_and_pace_from_cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bootstrap, 'installed_types', FakeActionTypes)
    shifts = tmp_path / 'shifts.yaml'
    shifts.write_text('shifts: {early: {from: 06:00, to: 14:00}}')
    assert plant() is None
    assert plant('--cell', REFERENCE_CELL) is None
    hours = Plant(Shifts({'early': Shift('early', Hours(360, 840))}), None)
    assert plant('--shifts', shifts) == hours
    paced = plant('--shifts', shifts, '--cell', REFERENCE_CELL)
    assert paced is not None
    assert paced.cell == read_cell(REFERENCE_CELL, FakeActionTypes())


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (['--shifts', 'none.yaml'], 'none.yaml:1:1: the file does not exist'),
        (['--host', '0.0.0.0'], 'passwords would cross the network in the clear'),
        (['--host', '0.0.0.0', '--trust-this-computer'], 'leave one of the two out'),
        (['--certificate', 'c.pem'], '--certificate and --key belong together'),
        (['--port', '70000'], 'expected a port'),
    ],
)
def test_unsafe_or_empty_options_do_not_start(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status_of('page', *words) in (1, 2)
    assert message in capsys.readouterr().err


def status_of(*words: str) -> object:
    try:
        return main(list(words))
    except SystemExit as end:
        return end.code


def test_packages_that_are_missing_are_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, 'uvicorn', None)
    assert main(['page']) == 2
    how = "install what the operator page needs with: pip install 'starlette"
    assert f'uvicorn cannot be imported; {how}' in capsys.readouterr().err


def test_foreign_text_stays_in_one_log_line(capsys: pytest.CaptureFixture[str]) -> None:
    with server_log(ROOM):
        logging.getLogger(f'{ROOM}.people').info('%s', 'eve\n2026 INFO ann logged in\x1b[2J')
    logging.getLogger(f'{ROOM}.people').info('later')
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(r'INFO eve\n2026 INFO ann logged in\x1b[2J')


def test_a_port_in_use_is_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(('127.0.0.1', 0)) as other:
        port = other.getsockname()[1]
        assert main(['page', '--port', str(port)]) == 1
    error = capsys.readouterr().err
    assert error == (
        f'bt-orchestrator page: error: port {port} of 127.0.0.1 is in use by another program; '
        'name another --port\n'
    )
