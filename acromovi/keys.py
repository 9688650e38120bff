"""`acromovi keys`: make certificates for robots, people and routers of a secure bus."""

import argparse
import json
import secrets
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

from acromovi.options import count
from acromovi.subcommand import Subcommand
from configs.extras import require

ROLES = {
    "viewer": "reads everything, moves nothing",
    "operator": "moves robots, asks agents, has agents under its own name",
    "robot": "speaks and obeys under its own name, asks agents",
    "admin": "may do all; a team's services have the key admin.TEAM",
    "router": "lets the others in; --host gives the names and addresses by which they reach it",
}
DAYS = 365
EPILOG = """\
examples:
  acromovi keys make --role router --name lab --host lab.example.org
      a router's key, and with the first key the authority that signs them all
  acromovi router --config secure-router:keys/router.lab
      run the router; it reads keys and the list of names, keys/router.lab/admitted, when it starts
  acromovi keys make --role operator --name anna
      the folder keys/operator.anna; Anna copies it to ~/.config/acromovi/keys and adds --bus secure to any command
  acromovi keys make --role robot --name happy
      for the gateway of the robot happy: p2os-gateway PORT --name happy --bus secure:keys/robot.happy
  acromovi up dwarfs --bus secure:keys
      a team whose processes find their keys in this folder: robot.NAME for each robot, and admin.dwarfs
  acromovi keys export operator.anna
      a file for a browser, which `acromovi console --certificate` lets in; it prints the password of the file
  acromovi keys list
  acromovi keys renew operator.anna

roles:
{roles}

Whoever has the folder `authority` can make keys: keep it where nobody else reads. To shut someone out, strike the name
from the router's list and start the router again.

Exit codes: 0 done, 1 not done (the reason is on stderr), 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", metavar="make|renew|list|export", required=True)
    make = actions.add_parser("make", help="make a key; with the first, the authority too", allow_abbrev=False)
    make.add_argument("--role", choices=ROLES, required=True, help="set the rights of the owner")
    make.add_argument("--name", required=True, help="set the owner; that of a robot is its name on the bus")
    make.add_argument(
        "--host", action="append", default=[], help="add a name or address of a router besides localhost; repeatable"
    )
    renew = actions.add_parser("renew", help="extend the validity of a key", allow_abbrev=False)
    renew.add_argument("owner", metavar="ROLE.NAME", help="owner, as the list shows it")
    listing = actions.add_parser("list", help="list the keys, and until when they are valid", allow_abbrev=False)
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    export = actions.add_parser("export", help="write a key as a file for a browser", allow_abbrev=False)
    export.add_argument("owner", metavar="ROLE.NAME", help="owner, as the list shows it")
    for action in (make, renew):
        action.add_argument("--days", type=count, default=DAYS, metavar="N", help="set the validity [%(default)d days]")
    for action in (make, renew, listing, export):
        action.add_argument(
            "--out", type=Path, default=Path("keys"), metavar="DIR", help="set the folder of keys [%(default)s]"
        )


def _run(arguments: argparse.Namespace) -> int:
    """Make, renew or list keys."""
    require("making keys", "security")
    from acromovi.authority import AUTHORITY, Authority, KeysError

    now = datetime.now(UTC)
    try:
        if arguments.action == "list":
            _show(arguments.out, now, arguments.json)
            return 0
        if arguments.action == "export":
            return _export(arguments.out, arguments.owner)
        life = timedelta(days=arguments.days)
        if arguments.action == "renew":
            folder = Authority(arguments.out, now).renew(arguments.owner, now, life)
            print(f"renewed {folder} for {arguments.days} days; copy it to its owner again")
            return 0
        if arguments.host and arguments.role != "router":
            print("acromovi keys: --host is for a router; nobody dials the others", file=sys.stderr)
            return 2
        if not (arguments.out / AUTHORITY).exists():
            Authority.begin(arguments.out, now)
            print(f"made {arguments.out / AUTHORITY}, which signs all keys; let nobody else read it")
        folder = Authority(arguments.out, now).make(arguments.role, arguments.name, now, life, arguments.host)
    except OSError as err:
        raise KeysError(f"{err.filename or arguments.out}: {err.strerror}") from err
    print(f"made {folder}, valid for {arguments.days} days; {_advice(arguments.role, folder)}")
    return 0


def _export(folder: Path, owner: str) -> int:
    """Write the key of an owner as PKCS #12, which browsers import."""
    from acromovi.authority import exported

    file = folder / owner / f"{owner}.p12"
    password = secrets.token_urlsafe(12)
    exported(folder, owner, file, password.encode())
    print(f"made {file}; import it into the browser with the password {password}, which is stored nowhere")
    return 0


def _show(folder: Path, now: datetime, as_json: bool) -> None:
    """Print the keys in a folder."""
    from acromovi.authority import issued

    found = issued(folder)
    if as_json:
        rows = [{"name": each.owner, "expires": each.expires.isoformat(), "hosts": each.hosts} for each in found]
        print(json.dumps({"keys": rows}))
        return
    width = max((len(each.owner) for each in found), default=0)
    for each in found:
        left = "expired" if now >= each.expires else f"{(each.expires - now).days} days left"
        print(f"{each.owner:<{width}}  {each.expires:%Y-%m-%d}  {left}  {' '.join(each.hosts)}".rstrip())
    if not found:
        print("none yet, only the authority")


def _advice(role: str, folder: Path) -> str:
    """Return what to do with a new key."""
    if role == "router":
        return f"run it with: acromovi router --config secure-router:{folder}"
    return f"use it with: --bus secure:{folder}; start the router again, that it admits {folder.name}"


COMMAND = Subcommand(
    EPILOG.format(roles="\n".join(f"  {role:<10}{meaning}" for role, meaning in ROLES.items())), _add_arguments, _run
)
