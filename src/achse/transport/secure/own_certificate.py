"""Own certificate of a station or client: a key and a self-signed certificate, created once.

Needs the extra `secure`, to make one and to read names out of one.
"""

import contextlib
import datetime
import os
from dataclasses import dataclass
from pathlib import Path

from achse.ams.secure import fingerprint_of
from achse.extras import needs_extra

_KEY_BITS = 2048
_YEARS = 20
_LONGEST_NAME = 64
"""Of a common name (X.520)."""

CERTIFICATE_FILE, KEY_FILE = "achse.crt", "achse.key"


class CertificateError(ValueError):
    """A certificate or key that cannot be used: the file, what was expected and what came."""


@dataclass(frozen=True, slots=True)
class OwnCertificate:
    """The files of a certificate and its key (PEM), and the fingerprint of the certificate."""

    certificate: Path
    key: Path
    fingerprint: str

    @classmethod
    def load(cls, certificate: Path, key: Path) -> "OwnCertificate":
        """Read both files. Raises CertificateError, OSError."""
        need_secure()
        from cryptography.hazmat.primitives import serialization
        from cryptography.x509 import load_pem_x509_certificate

        try:
            parsed = load_pem_x509_certificate(certificate.read_bytes())
        except ValueError as fault:
            raise CertificateError(
                f"{certificate}: a certificate in PEM expected: {fault}"
            ) from None
        try:
            private = serialization.load_pem_private_key(key.read_bytes(), password=None)
        except (ValueError, TypeError) as fault:
            raise CertificateError(
                f"{key}: a key in PEM without password expected: {fault}"
            ) from None
        kind = serialization.PublicFormat.SubjectPublicKeyInfo
        form = serialization.Encoding.DER
        if private.public_key().public_bytes(form, kind) != parsed.public_key().public_bytes(
            form, kind
        ):
            raise CertificateError(f"{key} is not the key of {certificate}")
        return cls(certificate, key, fingerprint_of(parsed.public_bytes(form)))

    @classmethod
    def ensure(cls, folder: Path, name: str) -> "OwnCertificate":
        """Return the one in `folder`, which is made if it is not there: RSA 2048, self-signed, CN
        `name`.

        Only its owner may read the key. Raises CertificateError, OSError.
        """
        certificate, key = folder / CERTIFICATE_FILE, folder / KEY_FILE
        if certificate.exists() or key.exists():
            return cls.load(certificate, key)
        need_secure()
        folder.mkdir(parents=True, exist_ok=True)
        certificate_pem, key_pem = _self_signed(name)
        _write(key, key_pem, 0o600)
        _write(certificate, certificate_pem, 0o644)
        return cls.load(certificate, key)


def need_secure() -> None:
    """Raise CertificateError if the extra `secure` is not installed."""
    try:
        import cryptography  # noqa: F401
    except ImportError:
        raise CertificateError(needs_extra("Secure ADS", "secure")) from None


def _self_signed(name: str) -> tuple[bytes, bytes]:
    """Certificate and key, both PEM."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import rsa

    private = rsa.generate_private_key(public_exponent=65537, key_size=_KEY_BITS)
    subject = x509.Name(
        [x509.NameAttribute(x509.NameOID.COMMON_NAME, name[:_LONGEST_NAME] or "achse")]
    )
    now = datetime.datetime.now(datetime.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(private.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))  # clocks differ
        .not_valid_after(now + datetime.timedelta(days=365 * _YEARS))
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .sign(private, hashes.SHA256())
    )
    return (
        certificate.public_bytes(serialization.Encoding.PEM),
        private.private_bytes(
            serialization.Encoding.PEM,
            serialization.PrivateFormat.PKCS8,
            serialization.NoEncryption(),
        ),
    )


def _write(path: Path, data: bytes, mode: int) -> None:
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(data)


def names_of(certificate: bytes) -> frozenset[str]:
    """Return names and addresses that a certificate (DER) is for: its CN and alternative names.

    Those that cannot be read are left out.
    """
    from cryptography import x509

    names: set[str] = set()
    with contextlib.suppress(ValueError):
        parsed = x509.load_der_x509_certificate(certificate)
        names |= {
            str(each.value).casefold()
            for each in parsed.subject.get_attributes_for_oid(x509.NameOID.COMMON_NAME)
        }
        with contextlib.suppress(x509.ExtensionNotFound):
            others = parsed.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
            names |= {name.casefold() for name in others.get_values_for_type(x509.DNSName)}
            names |= {str(address) for address in others.get_values_for_type(x509.IPAddress)}
    return frozenset(names)
