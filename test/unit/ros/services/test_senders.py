"""Who asks over ROS: what counts, and what is only claimed."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.limits import NAME
from bt_orchestrator.ros.node_parameters import NodeParameters
from bt_orchestrator.ros.services.services import Senders
from bt_orchestrator.script.users.file import UsersFile
from bt_orchestrator.script.users.keys import Key, KeyUnusable

HERE = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
EVERYWHERE = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}


def asked(environment: dict[str, str], role: str = '', known: str = '', **parameters: Any) -> By:
    senders = Senders(NodeParameters(**parameters), environment, 'rmw_fastrtps_cpp')
    request = SimpleNamespace(who='Ann', origin='', reason='why', role=role, known=known)
    return senders.by(request)


@pytest.mark.parametrize(
    ('environment', 'parameter', 'role'),
    [
        (HERE, 'auto', Role.ENGINEER),
        (EVERYWHERE, 'auto', Role.VIEW),
        (HERE, 'mes', Role.MES),
        (EVERYWHERE, 'operate', Role.OPERATE),
    ],
)
def test_the_role_of_everybody(environment: dict[str, str], parameter: str, role: Role) -> None:
    by = asked(environment, unauthenticated_role=parameter)
    assert by == By('Ann', 'service', 'why', role, Known.ROS)


def test_what_a_door_asserts_is_a_claim() -> None:
    by = asked(EVERYWHERE, 'engineer', 'page login', trust_local_doors=True)
    assert (by.role, by.known, by.claims) == (Role.VIEW, Known.ROS, 'engineer (page login)')
    by = asked(HERE, 'operate', 'page login')
    assert (by.role, by.known, by.claims) == (Role.ENGINEER, Known.ROS, 'operate (page login)')


def test_local_door_is_trusted_where_node_allows_it() -> None:
    by = asked(HERE, 'operate', 'page login', trust_local_doors=True)
    assert (by.role, by.known, by.claims) == (Role.OPERATE, Known.PAGE_LOGIN, '')
    by = asked(HERE, 'mes', 'opc ua user', trust_local_doors=True)
    assert (by.role, by.known) == (Role.MES, Known.OPC_UA_USER)


def test_only_trusted_local_door_can_name_panel() -> None:
    by = asked(HERE, 'operate', 'page panel', trust_local_doors=True)
    assert (by.role, by.known, by.known.is_panel) == (Role.OPERATE, Known.PAGE_PANEL, True)
    assert asked(HERE, 'operate', 'opc ua panel', trust_local_doors=True).known.is_panel
    assert not asked(HERE, 'operate', 'page panel').known.is_panel
    assert not asked(EVERYWHERE, 'operate', 'page panel', trust_local_doors=True).known.is_panel
    assert not asked(HERE, 'operate', 'local user', trust_local_doors=True).known.is_panel


def test_7_8_4_node_explains_why_no_panel_is_possible(tmp_path: Path) -> None:
    path = tmp_path / 'users.yaml'

    def why(**parameters: Any) -> str:
        given = NodeParameters(users=path, **parameters)
        return Senders(given, HERE, 'rmw_fastrtps_cpp').why_no_panel()

    assert f'there is no panel in {path}' in why()
    UsersFile(path).change_panel('address', '10.0.0.9', named=True)
    assert 'or start the node with --trust-local-doors' in why()
    assert why(trust_local_doors=True) == ''
    path.chmod(0o644)
    assert 'chmod 600' in why(trust_local_doors=True)


def test_7_12_8_where_signatures_are_required_unsigned_requests_only_look() -> None:
    required: dict[str, Any] = {'signed_commands': 'required', 'unauthenticated_role': 'engineer'}
    by = asked(HERE, **required)
    assert (by.role, by.known) == (Role.VIEW, Known.ROS)
    by = asked(HERE, 'operate', 'page panel', trust_local_doors=True, **required)
    assert (by.role, by.known, by.claims) == (Role.VIEW, Known.ROS, 'operate (page panel)')


def test_7_12_8_missing_crypto_package_is_reported_when_required(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, 'cryptography.hazmat.primitives.asymmetric.ed25519', None)
    with pytest.raises(KeyUnusable, match='apt install python3-cryptography'):
        asked(HERE, signed_commands='required')
    assert asked(HERE).role is Role.ENGINEER


def test_7_8_4_panel_may_be_key_or_signing_door(tmp_path: Path) -> None:
    path = tmp_path / 'users.yaml'
    users = UsersFile(path)

    def why() -> str:
        given = NodeParameters(users=path, signed_commands='required', trust_local_doors=True)
        return Senders(given, HERE, 'rmw_fastrtps_cpp').why_no_panel()

    users.change_panel('address', '10.0.0.9', named=True)
    assert 'give them keys (bt-orchestrator user key NAME --door page)' in why()
    users.add_key('page_1', Key(Role.ENGINEER, 'A' * 43 + '=', 'page'))
    assert why() == ''
    users.remove_key('page_1')
    users.add_key('panel_3', Key(Role.OPERATE, 'A' * 43 + '='))
    assert 'give them keys' in why()
    users.change_panel('key', 'panel_3', named=True)
    assert why() == ''


def test_unknown_role_may_only_view() -> None:
    assert asked(HERE, 'root', 'page login', trust_local_doors=True).role is Role.VIEW


@pytest.mark.parametrize('known', ['', 'local user', 'ros unauthenticated', 'trust me'])
def test_what_is_no_door_asserts_nothing(known: str) -> None:
    by = asked(HERE, 'engineer', known, trust_local_doors=True, unauthenticated_role='view')
    assert (by.role, by.known) == (Role.VIEW, Known.ROS)


def test_a_claim_is_cut() -> None:
    assert len(asked(HERE, 'x' * 10_000).claims) <= NAME


def test_another_user_may_cancel_goal() -> None:
    senders = Senders(NodeParameters(unauthenticated_role='mes'), HERE, '')
    given = By('Ann', 'page', 'why', Role.ENGINEER, Known.PAGE_LOGIN)
    by = senders.of_cancel(given)
    assert (by.who, by.role, by.known) == ('Ann', Role.MES, Known.ROS)
