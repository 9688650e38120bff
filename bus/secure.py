"""Profiles: those of this machine alone, and those with certificates.

The table `acromovi` of a profile is this product's. With `loopback`, sessions meet on this machine by `bus.loopback`.
With `keys` it configures certificates: their folder, and the rules for what they allow. `{keys}` is
a folder with `ca.pem`, `cert.pem` and `key.pem`, as `acromovi keys` makes them; a router's has a list `admitted`
besides. A certificate's common name is ROLE.NAME.
"""

import datetime
import errno
import json
import socket
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import zenoh

from bus.errors import BusUnavailable, NotAllowed
from bus.loopback import LocalBus
from configs.extras import require
from configs.loader import ConfigError, find, read

WARNING = "bus profile "
"""How the line begins that warns of a profile; a program that starts others prints it once for all of them."""
OURS = "acromovi"  # the table of a profile that is this product's
ADMITTED = "admitted"
CA, CERTIFICATE, PRIVATE_KEY = "ca.pem", "cert.pem", "key.pem"
PROBE_TIMEOUT = 2.0  # s for a router to refuse

# Meanings of a router's alerts, by their OpenSSL names.
ALERTS = {
    "TLSV1_ALERT_UNKNOWN_CA": "it has another authority than this certificate; ask for a key of its authority",
    "TLSV1_ALERT_DECRYPT_ERROR": "it has another authority than this certificate; ask for a key of its authority",
    "SSLV3_ALERT_CERTIFICATE_EXPIRED": "by its clock this certificate is not valid; compare the clocks, or renew it",
    "TLSV13_ALERT_CERTIFICATE_REQUIRED": "it asks for a certificate and got none",
    "SSLV3_ALERT_BAD_CERTIFICATE": "it does not take this certificate",
}


@dataclass(frozen=True, slots=True)
class Profile:
    """A profile, and the text behind its name: the folder of its keys, or the name of a bus on this machine.

    path: the file.
    table: the contents of the file.
    folder: the folder of the keys; None for a profile without.
    local: the bus of this machine; None for a profile of the network.
    warning: printed by a program that joins this bus; empty for none.
    """

    path: Path
    table: Mapping[str, Any]
    folder: Path | None
    local: LocalBus | None = None
    warning: str = ""

    @classmethod
    def find(cls, name: str) -> "Profile":
        """Find a profile by a name or a file.

        Args:
            name: With `:FOLDER` behind it for another folder of keys, or `:NAME` for another bus on this machine.
        Raises:
            ConfigError: There is no such profile, or it takes no such text behind its name.
        """
        if not isinstance(name, str):
            raise ConfigError(f"a bus profile is a text, such as 'local', not {name!r}")
        given, _, folder = (name, "", "") if Path(name).is_file() else name.partition(":")
        path = find("bus", given)
        table = {} if path.suffix in (".json5", ".json") else read(path)
        ours = table.get(OURS, {})
        if ours.get("loopback") is True:
            return cls(path, table, None, LocalBus.named(folder))
        warning = f"{WARNING}{given}: {ours['warning']}" if "warning" in ours else ""
        if not ours.keys() - {"warning"}:
            if folder:
                raise ConfigError(
                    f"{path} takes nothing behind its name, but got {folder!r}; secure and secure-router take a folder "
                    "of keys, local takes the name of a bus"
                )
            return cls(path, table, None, warning=warning)
        keys = Path(folder) if folder else path.parent / Path(_setting(table, "keys")).expanduser()
        return cls(path, table, keys, warning=warning)

    def for_zenoh(self) -> dict[str, Any]:
        """Return Zenoh's configuration: with paths in place of `{keys}`, and a subject for each admitted name.

        Raises:
            ConfigError: Keys are missing, or a router's list of names.
        """
        table = {key: value for key, value in self.table.items() if key != OURS}
        if self.folder is None:
            return table
        for name in (CA, CERTIFICATE, PRIVATE_KEY):
            _present(self.folder / name)
        if "access_control" in table:
            table["access_control"] = admitting(table["access_control"], _admitted(self.folder / ADMITTED))
        return dict(_filled(table, keys=str(self.folder.absolute())))

    def why_not_let_in(self, endpoints: Iterable[str]) -> str:
        """Connect again to the endpoints at which Zenoh failed, and return the reasons, a sentence for each with TLS.

        Args:
            endpoints: Zenoh's, such as `tls/127.0.0.1:7447`.
        """
        dialled = (endpoint for endpoint in endpoints if endpoint.startswith("tls/"))
        return "; ".join(f"{endpoint}: {_knock(self.folder or Path(), endpoint)}" for endpoint in dialled)


def admitting(access: Mapping[str, Any], common_names: Iterable[str]) -> dict[str, Any]:
    """Return access control for these common names: each is a subject with the policies of its role.

    Zenoh compares whole common names, so `viewer.*` is written out; `{name}` in a rule is the member's own name.
    """
    patterns = {subject["id"]: subject["cert_common_names"] for subject in access["subjects"]}
    rules: dict[str, Any] = {}
    subjects, policies = [], []
    for common_name in common_names:
        own = []
        for policy in access["policies"]:
            wanted = [pattern for subject in policy["subjects"] for pattern in patterns[subject]]
            if any(fnmatchcase(common_name, pattern) for pattern in wanted):
                own += [_own(rule, common_name) for rule in access["rules"] if rule["id"] in policy["rules"]]
        if own:
            rules |= {rule["id"]: rule for rule in own}
            subjects.append({"id": common_name, "cert_common_names": [common_name]})
            policies.append({"rules": [rule["id"] for rule in own], "subjects": [common_name]})
    return {**access, "rules": list(rules.values()), "subjects": subjects, "policies": policies}


class Permit:
    """The permissions of one certificate, by the router's own rules.

    common_name: ROLE.NAME.
    own_name: the only name that its owner may use; None if it may use any.
    """

    def __init__(self, common_name: str, rules: Sequence[Mapping[str, Any]], sentence: str) -> None:
        self.common_name = common_name
        self._sentence = sentence
        self._rules = [
            (set(rule["messages"]), [zenoh.KeyExpr(key) for key in rule["key_exprs"]])
            for rule in rules
            if "ingress" in rule["flows"]
        ]
        self.own_name = None if self.allows("put", "**") else common_name.partition(".")[2]

    @classmethod
    def of(cls, profile: Profile) -> "Permit | None":
        """Return what the certificate of a profile allows; None for a profile without certificate or rules.

        Raises:
            ConfigError: Keys or rules are missing or cannot be read.
            BusUnavailable: The certificate is not valid now.
        """
        if profile.folder is None or "rules" not in profile.table[OURS]:
            return None
        common_name = valid_name(profile.folder / CERTIFICATE)
        path = find("bus", _setting(profile.table, "rules"))
        table = read(path)
        role, _, name = common_name.partition(".")
        sentence = table[OURS].get("roles", {}).get(role, f"the rules of {path.stem} do not allow it to {common_name}")
        rules = admitting(table["access_control"], [common_name])["rules"]
        return cls(common_name, rules, sentence.replace("{name}", name))

    def require(self, message: str, key: str) -> None:
        """Raise for what the router would drop silently.

        Raises:
            NotAllowed: The rules do not allow this message, in Zenoh's terms (`put`, `query`), on this key.
        """
        if not self.allows(message, key):
            raise NotAllowed(f"{self._sentence} ({message.replace('_', ' ')} on {key})")

    def allows(self, message: str, key: str) -> bool:
        """Return whether the rules allow this message, in Zenoh's terms, on this key."""
        wanted = zenoh.KeyExpr(key)
        return any(message in messages and any(k.includes(wanted) for k in keys) for messages, keys in self._rules)


def valid_name(certificate: Path) -> str:
    """Return the common name of a certificate that is valid now.

    Raises:
        ConfigError: It cannot be read.
        BusUnavailable: It is not valid yet, or no longer.
    """
    require("a secure bus", "security")
    from cryptography import x509

    try:
        found = x509.load_pem_x509_certificate(_present(certificate).read_bytes())
        (attribute,) = found.subject.get_attributes_for_oid(x509.NameOID.COMMON_NAME)
    except OSError as err:
        raise ConfigError(f"{certificate} cannot be read: {err.strerror}") from err
    except ValueError as err:
        raise ConfigError(f"{certificate} is no certificate with a name") from err
    name, now = str(attribute.value), datetime.datetime.now(datetime.UTC)
    if now >= found.not_valid_after_utc:
        ended = f"the certificate of {name} has expired on {found.not_valid_after_utc:%Y-%m-%d}"
        raise BusUnavailable(f"{ended}; whoever made it renews it with: acromovi keys renew {name}")
    if now < found.not_valid_before_utc:
        start = f"the certificate of {name} is valid from {found.not_valid_before_utc:%Y-%m-%d %H:%M} UTC on"
        raise BusUnavailable(f"{start}, which has not come yet; is this machine's clock right?")
    return name


def _knock(folder: Path, endpoint: str) -> str:
    """Do the TLS handshake as Zenoh would, and return the reason of a failure."""
    import ssl  # here and not at the top: only a program that was not let in needs it

    address = urlsplit(f"//{endpoint.removeprefix('tls/')}")
    host, port = address.hostname or "", address.port or 0
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    try:
        context.load_verify_locations(folder / CA)
        context.load_cert_chain(folder / CERTIFICATE, folder / PRIVATE_KEY)
    except ssl.SSLError as err:
        return f"the files in {folder} do not belong together ({err.reason or err})"
    try:
        with (
            socket.create_connection((host, port), PROBE_TIMEOUT) as plain,
            context.wrap_socket(plain, server_hostname=host) as link,
        ):
            link.recv(1)  # a router that accepts waits for the first message of Zenoh's
    except ssl.SSLCertVerificationError as err:
        return f"the router's certificate does not pass: {err.verify_message}; is {folder / CA} of its authority?"
    except ssl.SSLError as err:
        return f"the router lets this key not in: {ALERTS.get(err.reason, err.reason)}"
    except TimeoutError:
        return "the router takes this certificate, and says no more"
    except OSError as err:
        nobody = err.errno == errno.ECONNREFUSED
        return "no router listens there; start it, or correct the address" if nobody else str(err.strerror or err)
    return "whoever listens there hangs up; is it a router with the profile secure-router?"


def _setting(table: Mapping[str, Any], name: str) -> str:
    """Return one of the product's own settings, a text."""
    value = table[OURS].get(name)
    if not isinstance(value, str):
        raise ConfigError(f"{OURS}.{name} of a bus profile must be a text, not {json.dumps(value)}")
    return value


def _present(path: Path) -> Path:
    """Return the path of a file after checking that it exists."""
    if not path.is_file():
        how = "make keys with `acromovi keys make`, and give their folder: --bus secure:FOLDER"
        if all_keys := sorted(each.parent for each in path.parent.glob(f"*.*/{CERTIFICATE}")):
            names = ", ".join(each.name for each in all_keys)
            how = f"it has the keys of several; say whose you use, as in --bus secure:{all_keys[-1]}; there are {names}"
        raise ConfigError(f"there is no {path.name} in {path.parent}; {how}")
    return path


def _admitted(path: Path) -> list[str]:
    """Return the names in a router's list: one in each line, and comments after a #."""
    lines = [line.partition("#")[0].strip() for line in _present(path).read_text(encoding="utf-8").splitlines()]
    return [line for line in lines if line]


def _own(rule: Mapping[str, Any], common_name: str) -> dict[str, Any]:
    """Return a rule for one member: `{name}` is replaced, and the rule is the member's alone."""
    filled = _filled(rule, name=common_name.partition(".")[2])
    return dict(filled) if filled == rule else {**filled, "id": f"{rule['id']} {common_name}"}


def _filled(value: Any, **places: str) -> Any:
    """Return a table with texts in place of `{keys}` or `{name}`."""
    if isinstance(value, str):
        for place, text in places.items():
            value = value.replace(f"{{{place}}}", text)
        return value
    if isinstance(value, Mapping):
        return {key: _filled(each, **places) for key, each in value.items()}
    if isinstance(value, list):
        return [_filled(each, **places) for each in value]
    return value
