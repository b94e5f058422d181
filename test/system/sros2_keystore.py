# SPDX-License-Identifier: Apache-2.0
"""A keystore as ROS 2's own tool makes it: by Python's `cryptography`, in the words that its files have.

Source: layout, names and forms of sros2 (jazzy), keystore/ and _utilities.py; not its code.
"""
import datetime
import os

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import pkcs7

YEARS_10 = datetime.timedelta(days=3650)
PEM = serialization.Encoding.PEM


def name(text):
    return x509.Name([x509.NameAttribute(x509.oid.NameOID.COMMON_NAME, text)])


def certificate(subject, issuer=None, issuer_key=None):
    """Key and certificate; without an issuer those of an authority."""
    key = ec.generate_private_key(ec.SECP256R1())
    now = datetime.datetime.utcnow()
    is_authority = issuer is None
    builder = x509.CertificateBuilder().subject_name(name(subject)).issuer_name(name(subject) if is_authority else issuer.subject)
    builder = builder.serial_number(x509.random_serial_number()).not_valid_before(now).not_valid_after(now + YEARS_10)
    limits = x509.BasicConstraints(ca=is_authority, path_length=1 if is_authority else None)
    builder = builder.public_key(key.public_key()).add_extension(limits, critical=is_authority)
    return key, builder.sign(issuer_key or key, hashes.SHA256())


def write(path, made):
    """Keys are left to the umask, as ROS 2's tool does."""
    if isinstance(made, bytes):
        path.write_bytes(made)
    elif hasattr(made, "private_bytes"):
        path.write_bytes(made.private_bytes(PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()))
    else:
        path.write_bytes(made.public_bytes(PEM))


def signed(text, key, by):
    builder = pkcs7.PKCS7SignatureBuilder().set_data(text.encode()).add_signer(by, key, hashes.SHA256())
    return builder.sign(serialization.Encoding.SMIME, [pkcs7.PKCS7Options.Text, pkcs7.PKCS7Options.DetachedSignature])


def make(root, enclave, governance, permissions):
    """Both texts are documents; `permissions` may name {begins} and {ends}."""
    folder = root / "enclaves" / enclave.strip("/")
    for one in (root / "public", root / "private", folder):
        one.mkdir(parents=True)
    authority_key, authority = certificate("sros2CA")
    write(root / "public/ca.cert.pem", authority)
    write(root / "private/ca.key.pem", authority_key)
    for role in ("identity_ca", "permissions_ca"):
        os.symlink("ca.cert.pem", root / f"public/{role}.cert.pem")
        os.symlink("ca.key.pem", root / f"private/{role}.key.pem")
        os.symlink(os.path.relpath(root / f"public/{role}.cert.pem", folder), folder / f"{role}.cert.pem")
    (root / "enclaves/governance.xml").write_text(governance)
    write(root / "enclaves/governance.p7s", signed(governance, authority_key, authority))
    os.symlink(os.path.relpath(root / "enclaves/governance.p7s", folder), folder / "governance.p7s")
    key, own = certificate(enclave, authority, authority_key)
    write(folder / "key.pem", key)
    write(folder / "cert.pem", own)
    text = permissions.format(begins=own.not_valid_before.isoformat(), ends=own.not_valid_after.isoformat())
    (folder / "permissions.xml").write_text(text)
    write(folder / "permissions.p7s", signed(text, authority_key, authority))
