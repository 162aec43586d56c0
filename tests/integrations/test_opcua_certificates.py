"""Folders of certificates that an OPC UA server cannot use: one line, whose remedy works."""

import asyncio

import pytest

from axistwin.core.errors import UsageError

asyncua = pytest.importorskip("asyncua", reason="the extra [opcua] is not installed")


def secured(folder):
    from axistwin.real.integrations.opcua import security

    asyncio.run(security.secure(asyncua.Server(), users=False, folder=folder, host="127.0.0.1"))


def test_an_empty_folder_of_trusted_clients(tmp_path):
    (tmp_path / "trusted").mkdir()
    (tmp_path / "trusted" / "readme.txt").touch()
    with pytest.raises(UsageError, match=r"trusted contains no certificate, and no client could connect: expected "):
        secured(tmp_path)
    (tmp_path / "trusted" / "client.der").write_bytes((tmp_path / "certificate.der").read_bytes())
    secured(tmp_path)


@pytest.mark.parametrize(("name", "contents"), [
    ("key.pem", b"garbage"), ("key.pem", None), ("certificate.der", b""), ("trusted/a.pem", b""),
    ("trusted/a.der", b"garbage")])  # fmt: skip
def test_files_that_are_no_certificates(tmp_path, name, contents):
    """The remedy of the message is to delete both files of the server, and what is wrong in `trusted`."""
    secured(tmp_path)
    (tmp_path / "trusted").mkdir()
    (tmp_path / "trusted" / "client.der").write_bytes((tmp_path / "certificate.der").read_bytes())
    file = tmp_path / name
    file.unlink(missing_ok=True)
    if contents is None:
        file.mkdir()
    else:
        file.write_bytes(contents)
    with pytest.raises(UsageError, match=r"cannot use the certificates in .*: delete key\.pem") as told:
        secured(tmp_path)
    assert str(told.value).isprintable()
    for wrong in {file, tmp_path / "key.pem", tmp_path / "certificate.der"}:
        wrong.rmdir() if wrong.is_dir() else wrong.unlink()
    secured(tmp_path)
