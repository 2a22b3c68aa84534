"""Options of the verb `page` about who reaches it, and how people are known there."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_orchestrator.base.extending import PAGE
from bt_orchestrator.cli.numbers import seconds
from bt_orchestrator.cli.server_options import add_server_options, users_of
from bt_orchestrator.cli.user_name import user_name
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.extensions.page.web.access import IDLE_S, Access, AccessRefused


def add_access_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_server_options(
        parser, Access.host, PAGE.port, '; elsewhere it needs users, and TLS or a proxy'
    )
    parser.add_argument('--certificate', type=Path, metavar='FILE', help='TLS: PEM, whole chain')
    parser.add_argument('--key', type=Path, metavar='FILE', help='TLS: its key, PEM, no password')
    parser.add_argument(
        '--allow-host',
        action='append',
        default=[],
        metavar='NAME',
        help='name by which browsers call the page, besides ADDRESS and localhost; may be given '
        'several times',
    )
    parser.add_argument(
        '--trust-this-computer',
        action='store_true',
        help='whoever sits at this computer may give every command without a login: for demos',
    )
    parser.add_argument(
        '--behind-proxy',
        default='',
        metavar='HEADER',
        help='a proxy logs people in, and names them in this header; their roles are in the file '
        'of users',
    )
    parser.add_argument(
        '--proxy-address',
        action='append',
        default=[],
        metavar='IP',
        help='where the proxy is, if it is not on this computer; may be given several times',
    )
    parser.add_argument(
        '--lock-after',
        type=seconds,
        default=IDLE_S,
        metavar='SECONDS',
        help=f'a session that is not used for so long is locked (default {IDLE_S:.0f})',
    )


def access_of(args: argparse.Namespace) -> Access:
    """Return what the options say together.

    :raises WrongUse: they would let in anybody, or do not fit each other
    """
    access = Access(
        users=users_of(args),
        host=args.host,
        port=args.port,
        certificate=args.certificate,
        key=args.key,
        allowed_hosts=tuple(args.allow_host),
        local_user=user_name() if args.trust_this_computer else '',
        proxy_header=args.behind_proxy,
        proxy_addresses=tuple(args.proxy_address),
        idle_s=args.lock_after,
    )
    try:
        access.check()
    except AccessRefused as error:
        raise WrongUse(f'page: {error}') from error
    return access
