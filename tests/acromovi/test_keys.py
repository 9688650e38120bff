"""Keys as `acromovi keys` makes, renews and lists them."""

import json
import stat
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding, pkcs12
from cryptography.x509.oid import ExtendedKeyUsageOID

from acromovi.__main__ import main
from acromovi.authority import Authority, KeysError, issued
from acromovi.keys import ROLES
from bus.secure import valid_name

NOW = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)
DAY = timedelta(days=1)


def make(out: Path, role: str, name: str, *more: str) -> int:
    return main(["keys", "make", "--role", role, "--name", name, "--out", str(out), *more])


def certificate(folder: Path) -> x509.Certificate:
    return x509.load_pem_x509_certificate((folder / "cert.pem").read_bytes())


@pytest.mark.parametrize("role", ROLES)
def test_a_key_is_a_folder_that_nobody_else_reads(tmp_path: Path, role: str) -> None:
    out = tmp_path / "keys"
    assert make(out, role, "anna") == 0
    for path in out.rglob("*"):
        assert stat.S_IMODE(path.stat().st_mode) == (0o700 if path.is_dir() else 0o600), path
    assert {path.name for path in out.iterdir()} == {"authority", f"{role}.anna"}
    assert valid_name(out / f"{role}.anna" / "cert.pem") == f"{role}.anna"


def test_the_authority_signs_and_its_key_stays_with_it(tmp_path: Path) -> None:
    authority = Authority.begin(tmp_path, NOW)
    folder = authority.make("operator", "anna", NOW, 30 * DAY)
    root = x509.load_pem_x509_certificate((folder / "ca.pem").read_bytes())
    signed = certificate(folder)
    signed.verify_directly_issued_by(root)
    assert signed.not_valid_after_utc == NOW + 30 * DAY
    assert signed.not_valid_before_utc < NOW, "a clock that is behind takes it all the same"
    assert not signed.extensions.get_extension_for_class(x509.BasicConstraints).value.ca
    assert (folder / "ca.pem").read_bytes() == (tmp_path / "authority" / "ca.pem").read_bytes()
    assert (folder / "key.pem").read_bytes() != (tmp_path / "authority" / "key.pem").read_bytes()


def test_only_a_router_can_be_dialled_and_by_its_names_only(tmp_path: Path) -> None:
    authority = Authority.begin(tmp_path, NOW)
    authority.make("router", "lab", NOW, DAY, ["lab.example.org", "10.0.0.7"])
    authority.make("robot", "happy", NOW, DAY)
    found = {each.owner: each for each in issued(tmp_path)}
    assert found["router.lab"].hosts == ("localhost", "127.0.0.1", "lab.example.org", "10.0.0.7")
    assert found["robot.happy"].hosts == ()
    for owner, is_server in ("router.lab", True), ("robot.happy", False):
        usages = certificate(tmp_path / owner).extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
        assert (ExtendedKeyUsageOID.SERVER_AUTH in usages) == is_server


def test_routers_admit_whoever_has_a_key_before_or_after_them(tmp_path: Path) -> None:
    authority = Authority.begin(tmp_path, NOW)
    authority.make("viewer", "vera", NOW, DAY)
    authority.make("router", "lab", NOW, DAY)
    authority.make("router", "hall", NOW, DAY)
    authority.make("robot", "happy", NOW, DAY)
    assert (tmp_path / "router.lab" / "admitted").read_text() == "viewer.vera\nrouter.hall\nrobot.happy\n"
    assert (tmp_path / "router.hall" / "admitted").read_text() == "router.lab\nviewer.vera\nrobot.happy\n"


def test_nothing_is_overwritten_and_nobody_gets_anothers_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert make(tmp_path, "operator", "anna") == 0
    before = (tmp_path / "operator.anna" / "key.pem").read_bytes()
    capsys.readouterr()
    assert make(tmp_path, "operator", "anna") == 1
    assert capsys.readouterr().err == (
        f"acromovi keys: {tmp_path}/operator.anna is there already; renew it, or choose another name\n"
    )
    assert make(tmp_path, "robot", "anna") == 1
    assert "operator.anna has this name already" in capsys.readouterr().err
    assert (tmp_path / "operator.anna" / "key.pem").read_bytes() == before


def test_renewing_keeps_key_names_and_mode(tmp_path: Path) -> None:
    authority = Authority.begin(tmp_path, NOW)
    folder = authority.make("router", "lab", NOW, DAY, ["lab.example.org"])
    private = (folder / "key.pem").read_bytes()
    authority.renew("router.lab", NOW + 5 * DAY, 10 * DAY)
    assert (folder / "key.pem").read_bytes() == private
    (renewed,) = issued(tmp_path)
    assert renewed.expires == NOW + 15 * DAY
    assert renewed.hosts == ("localhost", "127.0.0.1", "lab.example.org")
    assert {path.name for path in folder.iterdir()} == {"admitted", "ca.pem", "cert.pem", "key.pem"}
    assert stat.S_IMODE((folder / "cert.pem").stat().st_mode) == 0o600


@pytest.mark.parametrize("owner", ["operator.ana", "authority", "../keys", ""])
def test_only_a_key_that_is_there_is_renewed(tmp_path: Path, owner: str) -> None:
    authority = Authority.begin(tmp_path, NOW)
    authority.make("operator", "anna", NOW, DAY)
    with pytest.raises(KeysError, match=r"there are: operator\.anna$"):
        authority.renew(owner, NOW, DAY)


def test_no_key_outlives_the_authority(tmp_path: Path) -> None:
    authority = Authority.begin(tmp_path, NOW)
    authority.make("viewer", "vera", NOW + 3640 * DAY, 365 * DAY)
    assert issued(tmp_path)[0].expires == NOW + 3650 * DAY
    with pytest.raises(KeysError, match="has expired on 2036-02-27"):
        Authority(tmp_path, NOW + 3650 * DAY)


def test_the_list_says_until_when(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    now = datetime.now(UTC)
    Authority.begin(tmp_path, now - 9 * DAY).make("robot", "old", now - 9 * DAY, DAY)
    assert make(tmp_path, "router", "lab", "--days", "9") == 0
    capsys.readouterr()
    assert main(["keys", "list", "--out", str(tmp_path)]) == 0
    old, lab = capsys.readouterr().out.splitlines()
    assert old.startswith("robot.old   ")
    assert old.endswith("expired")
    assert lab.endswith("8 days left  localhost 127.0.0.1")
    assert main(["keys", "list", "--json", "--out", str(tmp_path)]) == 0
    assert [row["name"] for row in json.loads(capsys.readouterr().out)["keys"]] == ["robot.old", "router.lab"]


@pytest.mark.parametrize(
    ("arguments", "code", "why"),
    [
        (["make", "--role", "viewer", "--name", "a/b"], 1, "'a/b' cannot name"),
        (["make", "--role", "viewer", "--name", "x" * 70], 1, "64 characters"),
        (["make", "--role", "router", "--name", "lab", "--host", "läb"], 1, "is no name of a host"),
        (["make", "--role", "viewer", "--name", "vera", "--host", "lab"], 2, "--host is for a router"),
        (["renew", "operator.anna"], 1, "there are no keys in"),
        (["list"], 1, "there are no keys in"),
    ],
)
def test_what_cannot_be_done_is_told_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], code: int, why: str
) -> None:
    assert main(["keys", *arguments, "--out", str(tmp_path / "keys")]) == code
    error = capsys.readouterr().err
    assert why in error
    assert error.count("\n") == 1
    assert not list(tmp_path.glob("keys/*.*"))


def test_a_key_is_exported_for_a_browser_with_a_password_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make(tmp_path, "operator", "anna")
    capsys.readouterr()
    command = ["keys", "export", "operator.anna", "--out", str(tmp_path)]
    assert main(command) == 0
    file = tmp_path / "operator.anna" / "operator.anna.p12"
    password = capsys.readouterr().out.partition("with the password ")[2].partition(",")[0]
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    _, found, authority = pkcs12.load_key_and_certificates(file.read_bytes(), password.encode())
    assert found == certificate(tmp_path / "operator.anna")
    assert [each.public_bytes(Encoding.PEM) for each in authority] == [(tmp_path / "operator.anna/ca.pem").read_bytes()]
    with pytest.raises(ValueError, match="password"):
        pkcs12.load_key_and_certificates(file.read_bytes(), b"another")
    assert main(command) == 1
    assert "is there already" in capsys.readouterr().err
    assert main(["keys", "export", "viewer.vera", "--out", str(tmp_path)]) == 1
    assert "there is no key viewer.vera" in capsys.readouterr().err


@pytest.mark.parametrize("file", ["ca.pem", "key.pem"])
def test_a_damaged_authority_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str], file: str) -> None:
    make(tmp_path, "viewer", "vera")
    (tmp_path / "authority" / file).write_text("nonsense")
    assert make(tmp_path, "viewer", "otto") == 1
    assert f"{tmp_path}/authority/{file} is no " in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert make(tmp_path / "file" / "keys", "viewer", "vera") == 1
    assert "Not a directory" in capsys.readouterr().err


def test_a_machine_without_cryptography_is_told_what_to_install(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert make(tmp_path, "viewer", "vera") == 0
    monkeypatch.setitem(sys.modules, "cryptography", None)
    monkeypatch.delitem(sys.modules, "acromovi.authority")
    assert make(tmp_path, "viewer", "otto") == 1
    assert "making keys needs the extra security, not installed here; install with: " in capsys.readouterr().err
    assert main(["topics", "--bus", f"secure:{tmp_path / 'viewer.vera'}"]) == 1
    assert "a secure bus needs the extra security, not installed here; install with: " in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["make"], ["make", "--role", "king", "--name", "a"], ["lst"]])
def test_wrong_usage_is_exit_code_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["keys", *arguments])
    assert "usage: acromovi keys" in capsys.readouterr().err


def test_help_shows_examples_roles_and_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["keys", "--help"])
    shown = capsys.readouterr().out
    assert all(f"  {role} " in shown for role in ROLES)
    assert "acromovi keys make --role operator --name anna" in shown
    assert "Exit codes: " in shown
