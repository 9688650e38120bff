"""A small certificate authority: members of a secure bus and their roles.

A folder holds one folder for each: `authority`, which signs, and ROLE.NAME with `ca.pem`, `cert.pem` and `key.pem`,
which is what its owner takes along. A router's has the list `admitted` besides. A
certificate's common name is ROLE.NAME.
"""

import ipaddress
import os
import secrets
import shutil
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Self

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import (
    BestAvailableEncryption,
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_pem_private_key,
)
from cryptography.hazmat.primitives.serialization.pkcs12 import serialize_key_and_certificates
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from bus.errors import BusError
from bus.keys import robot_name
from bus.secure import ADMITTED, CA, CERTIFICATE, PRIVATE_KEY

AUTHORITY = "authority"
ROUTER = "router"
LOCAL_HOSTS = ("localhost", "127.0.0.1")
AUTHORITY_LIFE = timedelta(days=3650)
CLOCK_SKEW = timedelta(days=1)  # a robot's clock may be behind; it shall know a new certificate all the same


class KeysError(BusError):
    """Keys cannot be made, renewed or read; the message says why."""


@dataclass(frozen=True, slots=True)
class _Issued:
    """A certificate that was made.

    owner: ROLE.NAME.
    expires: UTC.
    hosts: by which names a router may be reached.
    """

    owner: str
    expires: datetime
    hosts: tuple[str, ...]


class Authority:
    """Signs certificates. Time is an argument, in UTC."""

    def __init__(self, folder: Path, now: datetime) -> None:
        """Open the authority of a folder of keys.

        Raises:
            KeysError: There is none, its files are damaged, or it has expired.
            OSError: Its files cannot be read.
        """
        own = _authority(folder)
        self.folder = folder
        self._certificate = _certificate(own / CA)
        self._key = _private_key(own / PRIVATE_KEY)
        if now >= self._certificate.not_valid_after_utc:
            ended = f"{self._certificate.not_valid_after_utc:%Y-%m-%d}"
            raise KeysError(f"the authority in {own} has expired on {ended}; make keys anew in another --out DIR")

    @classmethod
    def begin(cls, folder: Path, now: datetime) -> Self:
        """Make an authority in a folder that has none.

        Raises:
            OSError: The folder cannot be written, or has one.
        """
        key = ec.generate_private_key(ec.SECP256R1())
        _write_folder(folder / AUTHORITY, {CA: _pem(_root(key, now)), PRIVATE_KEY: _pem_of_key(key)})
        return cls(folder, now)

    def make(self, role: str, name: str, now: datetime, life: timedelta, hosts: Sequence[str] = ()) -> Path:
        """Make a key and its certificate, and have the routers admit it.

        Args:
            role: What its owner may do.
            name: The owner; a robot's is its name on the bus.
            now: The time.
            life: How long it is valid, at most as long as the authority.
            hosts: What a router is called, besides `localhost`.
        Returns:
            The folder to give to its owner.
        Raises:
            KeyNotValid: The name does not serve.
            KeysError: There is such a key already, or another role has the name.
            OSError: The folder cannot be written.
        """
        owner = f"{role}.{robot_name(name)}"
        for there in _owners(self.folder):
            if there == owner:
                raise KeysError(f"{self.folder / owner} is there already; renew it, or choose another name")
            if there.partition(".")[2] == name:
                raise KeysError(f"{there} has this name already, and nobody may speak for another; choose another name")
        key = ec.generate_private_key(ec.SECP256R1())
        signed = self._sign(owner, key.public_key(), now, life, (*LOCAL_HOSTS, *hosts) if role == ROUTER else ())
        files = {CA: _pem(self._certificate), CERTIFICATE: _pem(signed), PRIVATE_KEY: _pem_of_key(key)}
        if role == ROUTER:
            files[ADMITTED] = "".join(f"{each}\n" for each in _owners(self.folder)).encode()
        _write_folder(self.folder / owner, files)
        for router in self.folder.glob(f"{ROUTER}.*"):
            if router.name != owner:
                with (router / ADMITTED).open("a", encoding="utf-8") as admitted:
                    admitted.write(f"{owner}\n")
        return self.folder / owner

    def renew(self, owner: str, now: datetime, life: timedelta) -> Path:
        """Sign an owner's key again.

        Raises:
            KeysError: There is no such key, or its files are damaged.
            OSError: The folder cannot be written.
        """
        folder = self.folder / owner
        if owner not in _owners(self.folder):
            there = ", ".join(_owners(self.folder)) or "none"
            raise KeysError(f"there is no key {owner} in {self.folder}; there are: {there}")
        before = _certificate(folder / CERTIFICATE)
        signed = self._sign(owner, _private_key(folder / PRIVATE_KEY).public_key(), now, life, _hosts(before))
        fresh = folder / f".{CERTIFICATE}.{secrets.token_hex(4)}"
        _write(fresh, _pem(signed))
        fresh.replace(folder / CERTIFICATE)
        return folder

    def _sign(
        self, owner: str, key: ec.EllipticCurvePublicKey, now: datetime, life: timedelta, hosts: Iterable[str]
    ) -> x509.Certificate:
        """Return a certificate; only a router's allows incoming connections, so that no other owner can pose as one."""
        ends = min(now + life, self._certificate.not_valid_after_utc)
        names = [_host(host) for host in hosts]
        usages = [ExtendedKeyUsageOID.CLIENT_AUTH] + [ExtendedKeyUsageOID.SERVER_AUTH] * bool(names)
        builder = (
            _builder(owner, self._certificate.subject, key, now, ends)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(x509.ExtendedKeyUsage(usages), critical=False)
            .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key()), critical=False)
        )
        if names:
            builder = builder.add_extension(x509.SubjectAlternativeName(names), critical=False)
        return builder.sign(self._key, hashes.SHA256())


def _owners(folder: Path) -> list[str]:
    """Return the owners of the keys in a folder, sorted."""
    return sorted(path.parent.name for path in folder.glob(f"*.*/{CERTIFICATE}"))


def issued(folder: Path) -> list[_Issued]:
    """The certificates in a folder, by owner.

    Raises:
        KeysError: There are none, or one is damaged.
    """
    _authority(folder)
    found = [(owner, _certificate(folder / owner / CERTIFICATE)) for owner in _owners(folder)]
    return [_Issued(owner, each.not_valid_after_utc, _hosts(each)) for owner, each in found]


def exported(folder: Path, owner: str, file: Path, password: bytes) -> None:
    """Write the key of an owner and its certificates to a new PKCS #12 file, which its owner alone can read.

    Raises:
        KeysError: There is no such key, it is damaged, or the file is there already.
        OSError: The files cannot be read or written.
    """
    if owner not in _owners(folder):
        raise KeysError(f"there is no key {owner} in {folder}; there are: {', '.join(_owners(folder)) or 'none'}")
    own = folder / owner
    if file.exists():
        raise KeysError(f"{file} is there already, and its password is stored nowhere; remove it to make it anew")
    authority = [_certificate(own / CA)]
    key, certificate = _private_key(own / PRIVATE_KEY), _certificate(own / CERTIFICATE)
    _write(
        file,
        serialize_key_and_certificates(owner.encode(), key, certificate, authority, BestAvailableEncryption(password)),
    )


def _authority(folder: Path) -> Path:
    """Return the folder of an existing authority."""
    if not (folder / AUTHORITY).is_dir():
        raise KeysError(f"there are no keys in {folder}; make the first with: acromovi keys make")
    return folder / AUTHORITY


def _root(key: ec.EllipticCurvePrivateKey, now: datetime) -> x509.Certificate:
    """The authority's own certificate."""
    name = f"Acromovi authority {secrets.token_hex(4)}"  # two authorities must not be taken for one
    return (
        _builder(name, _name(name), key.public_key(), now, now + AUTHORITY_LIFE)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(
            x509.KeyUsage(
                digital_signature=False,
                content_commitment=False,
                key_encipherment=False,
                data_encipherment=False,
                key_agreement=False,
                key_cert_sign=True,
                crl_sign=True,
                encipher_only=False,
                decipher_only=False,
            ),
            critical=True,
        )
        .sign(key, hashes.SHA256())
    )


def _builder(
    name: str, issuer: x509.Name, key: ec.EllipticCurvePublicKey, now: datetime, ends: datetime
) -> x509.CertificateBuilder:
    """Return a builder with the fields of every certificate."""
    return (
        x509.CertificateBuilder()
        .subject_name(_name(name))
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - CLOCK_SKEW)
        .not_valid_after(ends)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key), critical=False)
    )


def _name(common_name: str) -> x509.Name:
    try:
        return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])
    except ValueError as err:
        raise KeysError(f"{common_name!r} is too long for a certificate, which carries 64 characters") from err


def _host(text: str) -> x509.GeneralName:
    """A router's name, or its address."""
    try:
        return x509.IPAddress(ipaddress.ip_address(text))
    except ValueError:
        pass  # not an address, so it is a name
    try:
        return x509.DNSName(text)
    except ValueError as err:
        raise KeysError(f"{text!r} is no name of a host: write it with ASCII letters") from err


def _hosts(certificate: x509.Certificate) -> tuple[str, ...]:
    """Return the host names of a certificate."""
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return ()
    return tuple(str(name.value) for name in names)


def _certificate(path: Path) -> x509.Certificate:
    try:
        return x509.load_pem_x509_certificate(path.read_bytes())
    except ValueError as err:
        raise KeysError(f"{path} is no certificate") from err


def _private_key(path: Path) -> ec.EllipticCurvePrivateKey:
    try:
        key = load_pem_private_key(path.read_bytes(), None)
    except (ValueError, TypeError) as err:
        raise KeysError(f"{path} is no private key without a password") from err
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise KeysError(f"{path} is not a key as `acromovi keys` makes them")
    return key


def _pem(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(Encoding.PEM)


def _pem_of_key(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())


def _write_folder(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write a folder completely or not at all; never overwrite an existing one."""
    folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    fresh = Path(tempfile.mkdtemp(prefix=".new-", dir=folder.parent))
    try:
        for name, data in files.items():
            _write(fresh / name, data)
        fresh.rename(folder)
    except OSError:
        shutil.rmtree(fresh)
        raise


def _write(path: Path, data: bytes) -> None:
    """Write a new file that only its owner may read."""
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(data)
