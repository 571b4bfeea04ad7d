"""Certificates for tests, each made once: of three hosts, and of an authority that signs two."""

import datetime
import functools
import ipaddress
import os
import shutil
import tempfile
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import rsa

from achse.transport.secure.own_certificate import OwnCertificate

__all__ = ["authority", "authority_without", "identity", "remove", "signed", "signed_for"]


@functools.cache
def _folder_of(process: int) -> Path:
    return Path(tempfile.mkdtemp(prefix=f"achse-certificates-{process}-"))


def _folder() -> Path:
    """Return the folder of this process: workers forked from one process make keys of their own."""
    return _folder_of(os.getpid())


def remove() -> None:
    """Remove the files of this process."""
    shutil.rmtree(_folder(), ignore_errors=True)


@functools.cache
def identity(name: str) -> OwnCertificate:
    """A self-signed one."""
    return OwnCertificate.ensure(_folder() / name, name)


@functools.cache
def _key(name: str) -> rsa.RSAPrivateKey:
    return rsa.generate_private_key(public_exponent=65537, key_size=2048)


def _certificate(
    name: str, addresses: tuple[str, ...], by: str, days: tuple[int, int] = (-1, 1)
) -> x509.Certificate:
    def called(who: str) -> x509.Name:
        return x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, who)])

    now = datetime.datetime.now(datetime.UTC)
    others = [x509.IPAddress(ipaddress.ip_address(each)) for each in addresses]
    builder = (
        x509.CertificateBuilder()
        .subject_name(called(name))
        .issuer_name(called(by))
        .public_key(_key(name).public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now + datetime.timedelta(days=days[0]))
        .not_valid_after(now + datetime.timedelta(days=days[1]))
        .add_extension(x509.BasicConstraints(ca=name == by, path_length=None), critical=True)
    )
    if others:
        builder = builder.add_extension(x509.SubjectAlternativeName(others), critical=False)
    return builder.sign(_key(by), hashes.SHA256())


@functools.cache
def authority(name: str = "authority") -> Path:
    """The certificate of an authority, PEM."""
    file = _folder() / f"{name}.pem"
    pem = serialization.Encoding.PEM
    file.write_bytes(_certificate(name, (), name).public_bytes(pem))
    return file


@functools.cache
def signed(name: str, *addresses: str, by: str = "authority") -> OwnCertificate:
    """Certificate and key of `name`, signed by an authority."""
    certificate, key = _folder() / f"{name}.crt", _folder() / f"{name}.key"
    pem = serialization.Encoding.PEM
    certificate.write_bytes(_certificate(name, addresses, by).public_bytes(pem))
    plain, form = serialization.NoEncryption(), serialization.PrivateFormat.PKCS8
    key.write_bytes(_key(name).private_bytes(pem, form, plain))
    return OwnCertificate.load(certificate, key)


def signed_for(name: str, first: int, last: int) -> OwnCertificate:
    """One that is valid from so many days from now to so many days from now."""
    certificate = signed(name)
    file = _folder() / f"{name}-{first}-{last}.crt"
    pem = serialization.Encoding.PEM
    file.write_bytes(_certificate(name, (), "authority", (first, last)).public_bytes(pem))
    return OwnCertificate.load(file, certificate.key)


def authority_without(*revoked: OwnCertificate) -> bytes:
    """The authority and its list of revoked certificates, PEM."""
    now = datetime.datetime.now(datetime.UTC)
    issuer = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "authority")])
    builder = (
        x509.CertificateRevocationListBuilder()
        .issuer_name(issuer)
        .last_update(now - datetime.timedelta(days=1))
        .next_update(now + datetime.timedelta(days=1))
    )
    for each in revoked:
        number = x509.load_pem_x509_certificate(each.certificate.read_bytes()).serial_number
        builder = builder.add_revoked_certificate(
            x509.RevokedCertificateBuilder()
            .serial_number(number)
            .revocation_date(now - datetime.timedelta(hours=1))
            .build()
        )
    signed_list = builder.sign(_key("authority"), hashes.SHA256())
    return authority().read_bytes() + signed_list.public_bytes(serialization.Encoding.PEM)
