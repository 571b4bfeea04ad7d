"""Certificates: made once, kept, read; what cannot be used is told by its file."""

import datetime
import subprocess
import sys
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.hazmat.primitives.serialization import load_pem_private_key

from achse.extras import needs_extra
from achse.transport.secure.own_certificate import (
    CERTIFICATE_FILE,
    KEY_FILE,
    CertificateError,
    OwnCertificate,
    _self_signed,
    _write,
    names_of,
)
from tests.transport.certificates import authority, identity, signed


def test_it_is_made_once_and_kept(tmp_path: Path) -> None:
    certificate = OwnCertificate.ensure(tmp_path / "new" / "folder", "panel")
    assert certificate == OwnCertificate.ensure(tmp_path / "new" / "folder", "another")
    assert len(certificate.fingerprint) == 64
    parsed = x509.load_pem_x509_certificate(certificate.certificate.read_bytes())
    from cryptography.hazmat.primitives.serialization import Encoding

    assert names_of(parsed.public_bytes(Encoding.DER)) == {"panel"}


@pytest.mark.skipif(sys.platform == "win32", reason="no such modes")
def test_only_its_owner_reads_the_key() -> None:
    assert identity("panel").key.stat().st_mode & 0o077 == 0
    assert identity("panel").certificate.stat().st_mode & 0o111 == 0


@pytest.mark.parametrize(("name", "common_name"), [("x" * 65, "x" * 64), ("", "achse")])
def test_certificate_that_is_made(name: str, common_name: str) -> None:
    """RSA 2048, for 20 years, of itself, from a day ago since clocks differ."""
    certificate, key = _self_signed(name)
    parsed = x509.load_pem_x509_certificate(certificate)
    assert parsed.subject == parsed.issuer
    [attribute] = parsed.subject.get_attributes_for_oid(x509.NameOID.COMMON_NAME)
    assert attribute.value == common_name
    days = (parsed.not_valid_after_utc - parsed.not_valid_before_utc).days
    assert days == 365 * 20 + 1
    begin = parsed.not_valid_before_utc + datetime.timedelta(days=1)
    assert abs((datetime.datetime.now(datetime.UTC) - begin).total_seconds()) < 3600
    constraints = parsed.extensions.get_extension_for_class(x509.BasicConstraints)
    assert (constraints.critical, constraints.value.ca) == (True, True)
    assert constraints.value.path_length == 0
    private = load_pem_private_key(key, None)
    assert isinstance(private, rsa.RSAPrivateKey)
    assert (private.key_size, private.public_key().public_numbers().e) == (2048, 65537)


def test_what_is_there_is_not_written_over(tmp_path: Path) -> None:
    for name in (CERTIFICATE_FILE, KEY_FILE):
        folder = tmp_path / name
        folder.mkdir()
        (folder / name).write_bytes(b"mine")
        with pytest.raises((CertificateError, FileNotFoundError)):
            OwnCertificate.ensure(folder, "x")
        assert [each.name for each in folder.iterdir()] == [name]
        with pytest.raises(FileExistsError):
            _write(folder / name, b"other", 0o600)
        assert (folder / name).read_bytes() == b"mine"


def test_names_of_what_is_no_certificate_are_none() -> None:
    assert names_of(b"") == names_of(b"\x30\x03\2\1\0") == frozenset()


def test_names_and_addresses() -> None:
    from cryptography.hazmat.primitives.serialization import Encoding

    file = signed("Press", "192.0.2.7", "::1").certificate
    parsed = x509.load_pem_x509_certificate(file.read_bytes())
    assert names_of(parsed.public_bytes(Encoding.DER)) == {"press", "192.0.2.7", "::1"}


def test_what_cannot_be_used_is_reported(tmp_path: Path) -> None:
    ours, others = identity("panel"), identity("other")
    with pytest.raises(CertificateError, match=r"other.*achse\.key is not the key of .*panel"):
        OwnCertificate.load(ours.certificate, others.key)
    broken = tmp_path / "broken"
    broken.write_bytes(b"certificate")
    with pytest.raises(CertificateError, match="broken: a certificate in PEM"):
        OwnCertificate.load(broken, ours.key)
    with pytest.raises(CertificateError, match="broken: a key in PEM"):
        OwnCertificate.load(ours.certificate, broken)
    (tmp_path / KEY_FILE).write_bytes(ours.key.read_bytes())
    with pytest.raises(FileNotFoundError, match=CERTIFICATE_FILE):
        OwnCertificate.ensure(tmp_path, "half")  # nothing is written over a key
    assert authority().exists()


def test_without_the_extra_it_says_so(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['cryptography'] = None\n"
        "from pathlib import Path\n"
        "from achse.transport.secure.own_certificate import OwnCertificate, CertificateError\n"
        "try:\n"
        "    OwnCertificate.ensure(Path(sys.argv[1]), 'x')\n"
        "except CertificateError as fault:\n"
        "    print(fault)\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert result.stdout == needs_extra("Secure ADS", "secure") + "\n"
