"""Two computers on one machine, with a switch or a router between: Linux network namespaces."""

from __future__ import annotations

import os
import shutil
import subprocess

ADDRESSES = ('10.213.77.1', '10.213.77.2')
"""Of the two computers; nobody else is on their cable."""

ROUTED_ADDRESSES = ('10.213.78.2', '10.213.79.2')
"""Of two computers in subnets of their own."""

_NAMES = ('btc_a', 'btc_b', 'btc_switch')


class Network:
    """States: connected, cut. Needs root; `close` leaves nothing behind."""

    def __init__(self) -> None:
        names = [f'{name}_{os.getpid()}' for name in _NAMES]
        for name in names:
            _ip('netns', 'add', name)
        *self._computers, self._switch = names
        self._connect()

    def within(self, computer: int) -> list[str]:
        """Return the command that starts a program on one of the computers, 0 or 1."""
        discovery = 'ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET'
        return ['ip', 'netns', 'exec', self._computers[computer], 'env', discovery]

    def cut(self) -> None:
        """Pull the second computer's plug out of the switch."""
        _ip('-n', self._switch, 'link', 'set', 'port1', 'down')

    def mend(self) -> None:
        """Put it in again."""
        _ip('-n', self._switch, 'link', 'set', 'port1', 'up')

    def close(self) -> None:
        """Take the computers away, and the cable with them."""
        for name in (*self._computers, self._switch):
            subprocess.run(['ip', 'netns', 'del', name], check=False, capture_output=True)

    def _connect(self) -> None:
        _ip('-n', self._switch, 'link', 'add', 'bridge', 'type', 'bridge')
        _ip('-n', self._switch, 'link', 'set', 'bridge', 'up')
        for number, computer in enumerate(self._computers):
            port = self._lay_cable(number, ADDRESSES[number])
            _ip('-n', self._switch, 'link', 'set', port, 'master', 'bridge', 'up')
            _ip('-n', computer, 'route', 'add', '224.0.0.0/4', 'dev', 'eth0')

    def _lay_cable(self, number: int, address: str) -> str:
        """Connect a computer, and return the port of the switch at the other end."""
        computer, port = self._computers[number], f'port{number}'
        ends = ['eth0', 'netns', computer, 'type', 'veth', 'peer', port, 'netns', self._switch]
        _ip('link', 'add', *ends)
        _ip('-n', computer, 'link', 'set', 'lo', 'up')
        _ip('-n', computer, 'address', 'add', f'{address}/24', 'dev', 'eth0')
        _ip('-n', computer, 'link', 'set', 'eth0', 'up')
        return port


class RoutedNetwork(Network):
    """A router in place of the switch: each computer is in its own subnet, without multicast."""

    def _connect(self) -> None:
        for number, address in enumerate(ROUTED_ADDRESSES):
            port, router = self._lay_cable(number, address), address.rpartition('.')[0] + '.1'
            computer = self._computers[number]
            _ip('-n', self._switch, 'address', 'add', f'{router}/24', 'dev', port)
            _ip('-n', self._switch, 'link', 'set', port, 'multicast', 'off', 'up')
            _ip('-n', computer, 'link', 'set', 'eth0', 'multicast', 'off')
            _ip('-n', computer, 'route', 'add', 'default', 'via', router)
        forwards = ('sh', '-c', 'echo 1 > /proc/sys/net/ipv4/ip_forward')
        _ip('netns', 'exec', self._switch, *forwards)


def why_not() -> str | None:
    """Say why this machine cannot have such a network; None: it can."""
    if shutil.which('ip') is None:
        return 'the program `ip` (package iproute2) is not installed'
    if os.geteuid() != 0:
        return 'network namespaces need root'
    name = f'btc_probe_{os.getpid()}'
    made = subprocess.run(
        ['ip', 'netns', 'add', name], check=False, capture_output=True, text=True
    )
    if made.returncode:
        return f'this machine makes no network namespaces: {made.stderr.strip()}'
    _ip('netns', 'del', name)
    return None


def _ip(*words: str) -> None:
    subprocess.run(['ip', *words], check=True, capture_output=True)
