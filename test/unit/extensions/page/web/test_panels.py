"""Panels of the line at the page: by user, by address, and never where nothing is proven."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fakes.browser import Browser
from fakes.page_bench import ROLES, CellBench, PeopleBench
from fakes.who_may import differences

from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import UsersFile
from bt_orchestrator.sim.virtual_link import VirtualNode

PANEL = '10.0.0.9'
NAMES = {role: name for name, role in ROLES.items()}


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[CellBench]:
    made = CellBench(tmp_path)
    made.node.running.handler.why_no_panel = lambda: ''
    UsersFile(made.users).change_panel('address', f'::ffff:{PANEL}', named=True)
    yield made
    made.close()


def lose(node: VirtualNode) -> None:
    node._gateway.say_of_safety('its value is False')
    node.running.engine.settle()


def posted(browser: Browser, name: str, **given: Any) -> Any:
    return browser.post(f'/api/requests/{name}', {'reason': 'why', **given})


def test_7_8_1_every_request_is_as_the_hand_written_table(bench: CellBench) -> None:
    browsers = {
        (role, is_panel): bench.logged_in(name, **({'address': PANEL} if is_panel else {}))
        for role, name in NAMES.items()
        for is_panel in (False, True)
    }

    def asked(name: str, given: Any, role: Role, is_panel: bool) -> str:
        answer = posted(browsers[role, is_panel], name, **given)
        assert answer.status in (200, 403, 409, 422), answer.body
        message: str = answer.json['message']
        return message

    def hand_over(control: str) -> None:
        if bench.node.running.engine.state.control.value != control:
            assert posted(browsers[Role.ENGINEER, True], f'cell.{control}').status == 200

    assert list(differences(asked, hand_over, lambda: lose(bench.node))) == []


def test_7_11_7_sign_of_life_needs_panel_but_no_ticket(
    bench: CellBench,
) -> None:
    panel, here = bench.logged_in('eve', address=PANEL), bench.logged_in('eve')
    assert posted(panel, 'cell.local').status == 200
    assert posted(panel, 'cell.manual').status == 200
    before = len(bench.commands)
    answer = panel.post('/api/at_panel', {})
    assert (answer.status, answer.json['accepted'], answer.message) == (200, True, 'heard')
    assert len(bench.commands) == before
    refused = here.post('/api/at_panel', {})
    assert (refused.status, 'which is in local' in refused.message) == (409, True)
    viewer = bench.logged_in('vic', address=PANEL)
    assert viewer.post('/api/at_panel', {}).status == 403


def test_7_8_3_panel_naming_applies_at_once(bench: CellBench) -> None:
    here, there = bench.logged_in('ann'), bench.logged_in('ann', address=PANEL)
    assert posted(here, 'cell.local').status == 200
    assert [browser.get('/api/me').json['is_panel'] for browser in (here, there)] == [False, True]
    refused = posted(here, 'cell.remote')
    assert (refused.status, 'which is in local' in refused.message) == (409, True)
    UsersFile(bench.users).change_panel('user', 'ann', named=True)
    assert here.get('/api/me').json['is_panel'] is True
    assert posted(here, 'cell.remote').status == 200
    assert bench.commands[-1].known == 'page panel'
    UsersFile(bench.users).change_panel('user', 'ann', named=False)
    assert posted(there, 'cell.local').status == 200
    assert posted(here, 'cell.remote').status == 409


def test_7_8_3_a_trusted_computer_is_no_panel(tmp_path: Path) -> None:
    bench = PeopleBench(tmp_path, local_user='op')
    UsersFile(bench.users).change_panel('address', '127.0.0.1', named=True)
    assert bench.browser().get('/api/me').json['how'] == 'this computer'
    assert bench.browser().get('/api/me').json['is_panel'] is False
    assert bench.logged_in('ann').get('/api/me').json['is_panel'] is True
    bench.close()


def test_7_8_3_proxy_address_makes_users_no_panel(tmp_path: Path) -> None:
    bench = PeopleBench(tmp_path, proxy_header='X-User', proxy_addresses=('127.0.0.1',))
    users = UsersFile(bench.users)
    users.change_panel('address', '127.0.0.1', named=True)
    users.change_panel('user', 'eve', named=True)
    shown = {name: bench.browser().get('/api/me', X_User=name).json for name in ('ann', 'eve')}
    assert {name: me['is_panel'] for name, me in shown.items()} == {'ann': False, 'eve': True}
    bench.close()
