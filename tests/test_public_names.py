"""What a package offers is what its `__all__` lists, no more and no less."""

import ast
import importlib
from pathlib import Path

import pytest

from tools.structure import PACKAGES as TOP_PACKAGES

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = sorted(
    ".".join(init.parent.relative_to(ROOT).parts) for top in TOP_PACKAGES for init in (ROOT / top).rglob("__init__.py")
)


def names_bound(package: str) -> set[str]:
    """Public names that the package's `__init__` imports or defines."""
    bound: set[str] = set()
    body = ast.parse((ROOT / Path(*package.split(".")) / "__init__.py").read_text(encoding="utf-8")).body
    while body:
        match body.pop():
            case ast.If(test=ast.Name(id="TYPE_CHECKING"), body=names_for_editors):
                body += names_for_editors  # what is loaded when it is asked for
            case ast.ImportFrom(module="typing"):
                pass
            case ast.Import(names=names) | ast.ImportFrom(names=names):
                bound |= {alias.asname or alias.name for alias in names}
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                bound.add(name)
            case ast.Assign(targets=targets):
                bound |= {target.id for target in targets if isinstance(target, ast.Name)}
            case ast.AnnAssign(target=ast.Name(id=name)):
                bound.add(name)
    return {name for name in bound if not name.startswith("_")}


@pytest.mark.parametrize("package", PACKAGES)
def test_all_lists_exactly_the_public_names(package: str) -> None:
    listed = getattr(importlib.import_module(package), "__all__", [])
    assert len(listed) == len(set(listed)), "a name is listed twice"
    assert set(listed) == names_bound(package)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_listed_name_is_there(package: str) -> None:
    module = importlib.import_module(package)
    missing = [name for name in getattr(module, "__all__", []) if not hasattr(module, name)]
    assert not missing
