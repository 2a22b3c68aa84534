"""A certificate for this computer, made by openssl."""

from __future__ import annotations

import subprocess
from pathlib import Path


def make_certificate(folder: Path) -> tuple[Path, Path]:
    """Make a certificate that signs itself, and its key."""
    certificate, key = folder / 'certificate.pem', folder / 'key.pem'
    made = ['req', '-x509', '-newkey', 'rsa:2048', '-noenc', '-days', '2']
    about = ['-subj', '/CN=localhost', '-addext', 'subjectAltName=DNS:localhost,IP:127.0.0.1']
    files = ['-keyout', str(key), '-out', str(certificate)]
    subprocess.run(['openssl', *made, *about, *files], check=True, capture_output=True)
    return certificate, key
