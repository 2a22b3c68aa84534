"""The environment of ROS 2: its domain, how far discovery reaches, and security."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, MutableMapping
from pathlib import Path

from bt_orchestrator.base.diagnosis.check import Check, Verdict, fail, ok, warn

LARGEST = 232
"""The last domain whose ports exist."""
CROWDED = 101
"""The last one without a clash with the ports that Linux hands out to others."""

RANGES: Mapping[str, str] = {
    'SUBNET': 'every computer of the network',
    'LOCALHOST': 'this computer only',
    'OFF': 'no other program, not even on this computer',
    'SYSTEM_DEFAULT': 'whatever the middleware is configured for',
}

_RANGE, _PEERS = 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_STATIC_PEERS'
_ONLY_LOCAL, _SERVER = 'ROS_LOCALHOST_ONLY', 'ROS_DISCOVERY_SERVER'
_HEARS_ALL = 'ROS_SUPER_CLIENT'

_PREFIXES = 'AMENT_PREFIX_PATH'
_INDEX_OF_RCLPY = 'share/ament_index/resource_index/packages/rclpy'

_FIRST_PORT = 7400
_PORTS = 250
_UNICAST = 10
"""Ports of the domains begin there, so many for each (DDSI-RTPS). The first of a domain is for
discovery on a network, those from the eleventh on belong to participants."""


def domain(environment: Mapping[str, str]) -> Check:
    """Look at ROS_DOMAIN_ID."""
    name = 'ROS_DOMAIN_ID'
    text = environment.get(name, '').strip()
    if not text:
        return ok(name, '0, the default; only nodes of domain 0 are found')
    if not text.isdecimal() or int(text) > LARGEST:
        return fail(name, f'{text!r} is not a domain', f'set a whole number from 0 to {LARGEST}')
    if int(text) > CROWDED:
        remedy = f'its ports may be taken by others; choose one from 0 to {CROWDED}'
        return warn(name, text, remedy)
    return ok(name, f'{int(text)}; only nodes of domain {int(text)} are found')


def domain_id(environment: Mapping[str, str]) -> int:
    """Return the domain; 0 for one that is not set, or none."""
    text = environment.get('ROS_DOMAIN_ID', '').strip()
    return int(text) if text.isdecimal() else 0


def reach(environment: Mapping[str, str]) -> Check:
    """Say what range, static peers, discovery server and ROS_LOCALHOST_ONLY mean together."""
    name = 'discovery range'
    if environment.get(_SERVER):
        return ok(name, f'whoever the discovery server at {environment[_SERVER]} knows')
    if environment.get(_ONLY_LOCAL, '') == '1':
        finding = 'ROS_LOCALHOST_ONLY=1: this computer only, whatever the other variables say'
        remedy = 'it is deprecated; unset it, and set ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST'
        return warn(name, finding, remedy)
    text = environment.get(_RANGE, '').strip() or 'SUBNET'
    if text not in RANGES:
        known = ', '.join(RANGES)
        remedy = f'set ROS_AUTOMATIC_DISCOVERY_RANGE to one of {known}; ROS 2 takes SUBNET now'
        return warn(name, f'{text!r} is not a range', remedy)
    peers = [peer for peer in environment.get(_PEERS, '').split(';') if peer]
    finding = f'{text}: {RANGES[text]}'
    if text == 'OFF':
        remedy = 'no action server can be found; set ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST'
        return fail(name, finding, remedy)
    return ok(name, f'{finding}, and {", ".join(peers)}' if peers else finding)


def name_ros_wheels(environment: MutableMapping[str, str], prefix: str) -> None:
    """Set what a distribution's setup.bash sets, where ROS 2 was installed by pip.

    :param prefix: folder of the Python environment, `sys.prefix`
    """
    if not Path(prefix, _INDEX_OF_RCLPY).exists():
        return
    known = environment.get(_PREFIXES, '').split(os.pathsep)
    if prefix not in known:  # an overlay, such as a workspace of interfaces, stays before it
        environment[_PREFIXES] = os.pathsep.join(filter(None, (*known, prefix)))
    if not environment.get('ROS_DISTRO'):
        for path in Path(prefix).glob('lib/python*/site-packages/ros_*_rclpy-*.dist-info'):
            environment['ROS_DISTRO'] = path.name.split('_')[1]


def keep_to_this_computer(environment: MutableMapping[str, str]) -> None:
    """Limit discovery to this computer if the environment sets no range.

    Any computer that discovers a node can command it, and the ROS 2 default is the whole network.
    """
    if not any(environment.get(name) for name in (_RANGE, _PEERS, _ONLY_LOCAL, _SERVER)):
        environment[_RANGE] = 'LOCALHOST'


def hear_of_all(environment: MutableMapping[str, str]) -> None:
    """Let a program that looks at the graph hear of everybody from a discovery server.

    It tells others only of those whom they have a topic or a service in common with.
    """
    if environment.get(_SERVER):
        environment.setdefault(_HEARS_ALL, 'TRUE')


def is_local(environment: Mapping[str, str], middleware: str) -> bool:
    """Tell whether a node with these variables is invisible to other computers.

    This limits discovery only and is no access control: see docs/security.md.

    :param middleware: name of the RMW implementation; Zenoh has routers in place of ranges
    """
    if 'zenoh' in middleware or environment.get(_SERVER):
        return False
    if environment.get(_ONLY_LOCAL) == '1':
        return True
    if any(environment.get(_PEERS, '').split(';')):
        return False
    return environment.get(_RANGE, '').strip() in ('LOCALHOST', 'OFF')


def domains_in_use(sockets: str) -> set[int]:
    """Return the domains with participants on this computer.

    :param sockets: what stands in /proc/net/udp
    """
    ports = re.findall(r'^ *\d+: [0-9A-F]+:([0-9A-F]{4}) ', sockets, re.MULTILINE)
    return set(_domains(int(port, 16) for port in ports))


def _domains(ports: Iterator[int]) -> Iterator[int]:
    for port in ports:
        number, offset = divmod(port - _FIRST_PORT, _PORTS)
        if 0 <= number <= CROWDED and (offset == 0 or offset >= _UNICAST):
            yield number


def other_domains(own: int, sockets: Path = Path('/proc/net/udp')) -> str:
    """Say in which other domains there are nodes on this computer; empty: none, or unknown."""
    try:
        domains = domains_in_use(sockets.read_text(encoding='ascii')) - {own}
    except OSError:
        return ''
    if not domains:
        return ''
    numbers = ', '.join(map(str, sorted(domains)))
    return f'this shell is in domain {own}, and there are nodes on this computer in {numbers}'


# Security of DDS (SROS 2), as the environment asks for it.

_ENABLE, _KEYSTORE = 'ROS_SECURITY_ENABLE', 'ROS_SECURITY_KEYSTORE'


def security(environment: Mapping[str, str]) -> Check:
    """Look whether security is asked for, and whether there are keys for it.

    rcl itself says nothing where the variable of the keystore is missing.
    """
    if environment.get(_ENABLE, '') != 'true':
        return ok('security', f'off, {_ENABLE} is not true: any participant may command the cell')
    keystore = environment.get(_KEYSTORE, '')
    where = f'{_KEYSTORE}={keystore}' if keystore else f'{_KEYSTORE} is not set'
    if keystore and (Path(keystore) / 'enclaves').is_dir():
        return ok('security', f'{_ENABLE}=true, {where}')
    finding = f'{_ENABLE}=true, and {where}: there are no keys'
    remedy = f'make a keystore with `ros2 security`, or unset {_ENABLE}'
    if environment.get('ROS_SECURITY_STRATEGY', '') == 'Enforce':
        return fail('security', finding, remedy)
    return warn('security', f'{finding}, and so there is no security', remedy)


def secured(environment: Mapping[str, str]) -> str:
    """Say that a middleware without its security libraries may be at fault; empty: it is not."""
    if environment.get(_ENABLE, '') != 'true':
        return ''
    return (
        f'; {_ENABLE} is true: this middleware may be built without security, or its keys do not '
        f'fit; unset {_ENABLE} to go on without'
    )


# Why ROS 2 cannot be used, in a sentence.


def ros_says(error: Exception, environment: Mapping[str, str]) -> str:
    """Say what is wrong with the environment, else what ROS 2 says in its own words."""
    for look in (domain, reach, security):
        check = look(environment)
        if check.verdict is Verdict.FAIL:
            return f'{check.name}: {check.found}; {check.remedy}'
    # It ends with the place in the sources of rcl.
    words = str(error).splitlines()[0].partition(', at /')[0] if str(error) else repr(error)
    return f'ROS 2 says: {words}{secured(environment)}'
