"""The wire that the tests cut: that it does what they rely on."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator

import pytest
from page.proxy import LoseOneEvent, Proxy
from patience import PATIENCE_S


class Echo:
    """A server that sends back what it gets."""

    def __init__(self) -> None:
        self._socket = socket.create_server(('127.0.0.1', 0))
        self.port: int = self._socket.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _accept(self) -> None:
        try:
            while True:
                wire, _ = self._socket.accept()
                threading.Thread(target=self._answer, args=(wire,), daemon=True).start()
        except OSError:
            pass  # closed

    def _answer(self, wire: socket.socket) -> None:
        with wire:
            try:
                while piece := wire.recv(4096):
                    wire.sendall(piece)
            except OSError:
                pass  # cut


@pytest.fixture
def proxy() -> Iterator[Proxy]:
    """Give a wire to a server that sends back what it gets."""
    echo = Echo()
    proxy = Proxy(echo.port)
    yield proxy
    proxy.close()
    echo.close()


def connect(proxy: Proxy) -> socket.socket:
    return socket.create_connection(('127.0.0.1', proxy.port), timeout=PATIENCE_S)


def test_it_passes_what_it_gets(proxy: Proxy) -> None:
    with connect(proxy) as wire:
        wire.sendall(b'one')
        assert wire.recv(10) == b'one'
        assert proxy.connections == 1


def test_cut_ends_old_and_new_connections(proxy: Proxy) -> None:
    with connect(proxy) as wire:
        wire.sendall(b'one')
        wire.recv(10)
        proxy.cut()
        with pytest.raises(ConnectionResetError):
            wire.recv(10)
    with pytest.raises(ConnectionResetError), connect(proxy) as wire:
        wire.recv(10)
    proxy.mend()
    test_it_passes_what_it_gets(proxy)


def test_silent_wire_holds_data_until_mended(proxy: Proxy) -> None:
    with connect(proxy) as old:
        old.sendall(b'one')
        old.recv(10)
        proxy.go_silent()
        with connect(proxy) as new:
            for wire in (old, new):
                wire.sendall(b'two')
                wire.settimeout(0.2)
                with pytest.raises(TimeoutError):
                    wire.recv(10)
            proxy.mend()
            for wire in (old, new):
                wire.settimeout(PATIENCE_S)
                assert wire.recv(10) == b'two'


def bundle(*numbers: int) -> bytes:
    data = {'history': 'a', 'records': [{'seq': n, 'event': 'Stück', 'of': [n]} for n in numbers]}
    text = json.dumps(data, ensure_ascii=False)
    return f'event: happened\nid: a:{numbers[-1]}\ndata: {text}\n\n'.encode()


@pytest.mark.parametrize('numbers', [(5,), (5, 6), (5, 6, 7)])
def test_one_event_is_lost_and_nothing_else(numbers: tuple[int, ...]) -> None:
    lose = LoseOneEvent()
    beat = b'event: beat\ndata: {"silent_s": 0.1}\n\n'
    whole = beat + bundle(*numbers) + beat
    left = lose(whole)
    assert (len(left), lose.lost) == (len(whole), 5)
    assert left.startswith(beat)
    assert left.endswith(beat)
    [data] = [line for line in left.splitlines() if b'records' in line]
    records = json.loads(data.removeprefix(b'data: '))['records']
    assert [record['seq'] for record in records] == list(numbers[1:])
    assert lose(whole) == whole
