"""The password in a user's token, which is taken from an encrypted one or channel only."""

from __future__ import annotations

import hmac
from collections.abc import Callable

from asyncua import ua
from asyncua.crypto import uacrypto
from cryptography.hazmat.primitives.asymmetric.rsa import RSAPrivateKey

from bt_orchestrator.script.users.passwords import LONGEST

_DECRYPT: dict[str, Callable[[RSAPrivateKey, bytes], bytes]] = {
    'http://www.w3.org/2001/04/xmlenc#rsa-oaep': uacrypto.decrypt_rsa_oaep,
    'http://opcfoundation.org/UA/security/rsa-oaep-sha2-256': uacrypto.decrypt_rsa_oaep_sha256,
}
"""Not RSA 1.5, which asyncua takes as well: who can ask often enough decrypts what others sent."""

_LONGEST_BYTES = 4 * LONGEST


class BadToken(ValueError):
    """It is not encrypted, or not as it has to be."""


def password_of(
    token: ua.UserNameIdentityToken, key: RSAPrivateKey, nonce: bytes, is_channel_encrypted: bool
) -> str:
    """Return the password of a token.

    :param nonce: the server's, of this session: asyncua does not look whether it is in the token,
        so a token could be sent again later
    :raises BadToken: it has none that may be believed
    """
    sent = bytes(token.Password or b'')
    if not token.EncryptionAlgorithm:
        if not is_channel_encrypted:
            raise BadToken('a password came unencrypted')
        return _text(sent)
    decrypt = _DECRYPT.get(token.EncryptionAlgorithm)
    if decrypt is None:
        raise BadToken(f'a password was encrypted by {token.EncryptionAlgorithm!r:.100}')
    try:
        plain = _in_blocks(decrypt, key, sent)
    except ValueError as error:
        raise BadToken('a password cannot be decrypted') from error
    length = int.from_bytes(plain[:4], 'little')
    secret = plain[4 : 4 + length]
    password, own_nonce = secret[: -len(nonce)], secret[-len(nonce) :]
    if len(secret) != length or not hmac.compare_digest(own_nonce, nonce):
        raise BadToken('a password was encrypted for another session')
    return _text(password)


def _in_blocks(
    decrypt: Callable[[RSAPrivateKey, bytes], bytes], key: RSAPrivateKey, sent: bytes
) -> bytes:
    size = key.key_size // 8
    if not sent or len(sent) % size or len(sent) > 8 * size:
        raise ValueError('no whole number of blocks')
    return b''.join(decrypt(key, sent[at : at + size]) for at in range(0, len(sent), size))


def _text(password: bytes) -> str:
    if len(password) > _LONGEST_BYTES:
        raise BadToken('a password is too long')
    try:
        return password.decode()
    except UnicodeDecodeError as error:
        raise BadToken('a password is no text in UTF-8') from error
