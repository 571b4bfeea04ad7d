"""Certificates for tests, each made once: of three hosts, and of an authority that signs two."""

import datetime
import functools
import ipaddress
import tempfile
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import rsa

from achse.transport.own_certificate import OwnCertificate

__all__ = ["authority", "identity", "signed"]


@functools.cache
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="achse-certificates-"))


@functools.cache
def identity(name: str) -> OwnCertificate:
    """A self-signed one."""
    return OwnCertificate.made(_folder() / name, name)


@functools.cache
def _key(name: str) -> rsa.RSAPrivateKey:
    return rsa.generate_private_key(public_exponent=65537, key_size=2048)


def _certificate(name: str, addresses: tuple[str, ...], by: str) -> x509.Certificate:
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
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=1))
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
