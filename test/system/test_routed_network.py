"""Node and controllers in subnets of their own, with a router that passes no multicast on.

docs/network.md describes these ways to find each other.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path

import pytest
from cell_processes import SMALL_CELL, SPEED, small_script
from chaos.network import ROUTED_ADDRESSES, RoutedNetwork, why_not
from patience import until
from program_process import ProgramProcess
from ros_domain import PROFILES

pytestmark = pytest.mark.skipif(why_not() is not None, reason=str(why_not()))

NODE, CONTROLLERS = ROUTED_ADDRESSES

SERVER = 'ROS_DISCOVERY_SERVER'
PORT = 11811

OF_A_SERVER = '42'
"""What its program does in Fast DDS 3, by number: `command_to_int` of its tool."""

PLACES = 4
"""Fast DDS asks a static peer at so many places, one a process."""


Variables = Mapping[str, str]


def static_peer(address: str = '') -> Variables:
    return {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET', 'ROS_STATIC_PEERS': address}


BY_SERVER = {SERVER: f'{NODE}:{PORT}'}

WAYS: Mapping[str, tuple[Variables, Variables]] = {
    'peers_on_both_sides': (static_peer(CONTROLLERS), static_peer(NODE)),
    'peers_on_the_node': (static_peer(CONTROLLERS), static_peer()),
    'discovery_server': (BY_SERVER, BY_SERVER),
}
"""Variables of the node's computer, and of that of the controllers."""


class Deck:
    """A node on one computer, controllers on the other, with the variables of one way."""

    def __init__(
        self, network: RoutedNetwork, folder: Path, way: tuple[Variables, Variables]
    ) -> None:
        self._network, self._folder, self._way = network, folder, way
        self._running = ExitStack()
        self._goals = folder / 'goals.jsonl'
        (folder / 'cell.yaml').write_text(SMALL_CELL)
        (folder / 'small.yaml').write_text(small_script())
        (folder / 'order.yaml').write_text('order: WO-1\nscript: small\nquantity: 1\n')

    def start(self, *, programs_before: int = 0) -> None:
        """Start controllers and node.

        :param programs_before: programs on the computer of the controllers that are there first
        """
        if SERVER in self._way[0]:
            self._serve_discovery()
        for number in range(programs_before):
            self._program(1, f'other_{number}', 'sim-cell', '--namespace', f'other_{number}')
        self._program(1, 'sim', 'sim-cell', '--log', str(self._goals), '--speed', str(SPEED))
        # Whoever is on a network may not command a node by itself.
        roles = ['--unauthenticated-role', 'mes']
        self._program(0, 'node', 'run', '--trees', str(self._folder), *roles)

    def first_goal(self) -> None:
        """Give an order, and wait until its first goal has reached its controller."""
        assert self.verb('submit', 'order.yaml')[0] == 0
        until(lambda: bool(self.goals('started')), 'a goal at the controllers')

    def goals(self, event: str) -> list[dict[str, object]]:
        """Return what the controllers say of goals."""
        lines = self._goals.read_text().splitlines() if self._goals.exists() else []
        return [r for line in lines if (r := json.loads(line))['event'] == event]

    def verb(self, *words: str) -> tuple[int, str]:
        """Carry out a verb on the computer of the node."""
        verb = ProgramProcess(words, self._folder, 'verb', within=self._within(0))
        return verb.wait(), verb.output + verb.errors

    def close(self) -> None:
        self._running.close()

    def _program(self, computer: int, name: str, verb: str, *words: str) -> None:
        given = [verb, '--cell', 'cell.yaml', *words]
        process = ProgramProcess(given, self._folder, name, within=self._within(computer))
        self._running.callback(process.kill)
        process.wait_ready()

    def _within(self, computer: int) -> list[str]:
        profiles = [word for name in PROFILES for word in ('-u', name)]  # those of tests
        variables = [f'{name}={value}' for name, value in self._way[computer].items()]
        return [*self._network.within(computer), 'env', *profiles, *variables]

    def _serve_discovery(self) -> None:
        program = Path(sys.prefix, 'bin', 'fast-discovery-server')
        libraries = [Path(sys.prefix, 'lib')]
        libraries += Path(sys.prefix).glob('lib/python*/site-packages/ros_fast*.libs')
        is_newer = libraries[-1].name == 'ros_fastdds.libs'
        words = [
            *self._within(0),
            f'LD_LIBRARY_PATH={os.pathsep.join(map(str, libraries))}',
            str(program),
            *([OF_A_SERVER] if is_newer else []),
        ]
        output = self._folder / 'discovery_server'
        with output.open('wb') as file:
            server = subprocess.Popen(
                [*words, '-i', '0', '-l', NODE, '-p', str(PORT)], stdout=file, stderr=file
            )
        self._running.callback(server.wait)
        self._running.callback(server.kill)
        ready = b'Server started' if is_newer else b'Server is running'
        until(lambda: ready in output.read_bytes(), 'the discovery server')


MakeDeck = Callable[[tuple[Variables, Variables]], Deck]


@pytest.fixture
def make_deck(tmp_path: Path) -> Iterator[MakeDeck]:
    with ExitStack() as left:
        network = RoutedNetwork()
        left.callback(network.close)

        def make(way: tuple[Variables, Variables]) -> Deck:
            deck = Deck(network, tmp_path, way)
            left.callback(deck.close)
            return deck

        yield make


@pytest.mark.parametrize('way', WAYS)
def test_the_first_goal_reaches_its_controller(make_deck: MakeDeck, way: str) -> None:
    deck = make_deck(WAYS[way])
    deck.start()
    deck.first_goal()


def test_doctor_sees_controllers_by_a_discovery_server(make_deck: MakeDeck) -> None:
    deck = make_deck(WAYS['discovery_server'])
    deck.start()
    status, words = deck.verb('doctor', '--cell', 'cell.yaml')
    assert 'feeder: action server: /feeder/task (/sim_cell)' in words
    assert f'whoever the discovery server at {NODE}:{PORT} knows' in words
    assert status == 0, words


def test_no_controller_is_found_behind_router_by_default(
    make_deck: MakeDeck,
) -> None:
    deck = make_deck((static_peer(), static_peer()))
    deck.start()
    assert_not_found(deck)


def test_node_static_peers_find_limited_number_of_programs(make_deck: MakeDeck) -> None:
    deck = make_deck(WAYS['peers_on_the_node'])
    deck.start(programs_before=PLACES)
    assert_not_found(deck)


def assert_not_found(deck: Deck) -> None:
    assert deck.verb('submit', 'order.yaml')[0] == 0
    until(lambda: 'server_unavailable' in deck.verb('status')[1], 'a hold')
    assert 'feeder: no action server at feeder/task' in deck.verb('status')[1]
    assert not deck.goals('started')
