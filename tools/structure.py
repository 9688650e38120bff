"""Prints figures about the structure of the product: `python tools/structure.py [--list]`.

Names with more than one meaning, the public API, modules that are too small, import circles and lines.
"""

import argparse
import ast
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = (
    "p2os",
    "geometry",
    "configs",
    "cameras",
    "vision",
    "maps",
    "bus",
    "p2os_emu",
    "gateway",
    "agents",
    "recorder",
    "apps",
    "acromovi",
)
SMALL = 60
"""Lines. A module below this that only one other imports may belong inside that one."""
FAMILIES = (
    "p2os_emu.world.floors",  # a family of generated floors each
    "agents.platform.conversations",  # a protocol of FIPA each, or one end of it
    "apps.console.panels",  # the controls of an element each
    "apps",  # an application in a single module each
)
"""Modules in these are a concept of their own, however small: one of several of a kind, which all have a module."""


@dataclass(frozen=True)
class Module:
    """A Python file of the product. name: dotted, that of the package for an `__init__`."""

    path: Path
    name: str

    @cached_property
    def text(self) -> str:
        """The source."""
        return self.path.read_text(encoding="utf-8")

    @cached_property
    def tree(self) -> ast.Module:
        """The syntax tree."""
        return ast.parse(self.text)

    @cached_property
    def lines(self) -> int:
        """How many lines."""
        return self.text.count("\n")

    @cached_property
    def imports(self) -> list[ast.Import | ast.ImportFrom]:
        """Its imports, anywhere and for type checkers too."""
        return [node for node in statements(self.tree) if isinstance(node, ast.Import | ast.ImportFrom)]

    @property
    def is_package(self) -> bool:
        """Whether it is an `__init__`."""
        return self.path.name == "__init__.py"

    def classes(self) -> Iterator[str]:
        """Names of the classes at module level."""
        return (node.name for node in self.tree.body if isinstance(node, ast.ClassDef))

    def public(self) -> Iterator[str]:
        """Names of the functions and classes at module level that do not begin with an underscore."""
        kinds = ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
        return (node.name for node in self.tree.body if isinstance(node, kinds) and not node.name.startswith("_"))

    def exported(self) -> list[str]:
        """What a package lists in `__all__`."""
        for node in self.tree.body:
            match node:
                case ast.Assign(targets=[ast.Name(id="__all__")], value=ast.List(elts=items)):
                    return [str(item.value) for item in items if isinstance(item, ast.Constant)]
        return []


def modules(root: Path = ROOT, packages: tuple[str, ...] = PACKAGES) -> dict[str, Module]:
    """All modules of the product, by name."""
    found = {}
    for package in packages:
        for path in sorted((root / package).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            found[name] = Module(path, name)
    return found


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """All statements below a node, those in functions and branches too; a tenth of what `ast.walk` goes through."""
    for part in "body", "orelse", "finalbody", "handlers", "cases":
        for each in getattr(node, part, ()):
            yield each
            yield from statements(each)


def imports(module: Module, known: Mapping[str, Module]) -> set[str]:
    """Names of the product's modules that a module imports, anywhere and for type checkers too."""
    found = set()
    for node in module.imports:
        match node:
            case ast.Import(names=names):
                found |= {alias.name for alias in names}
            case ast.ImportFrom(module=str(source), level=0, names=names):
                found |= {f"{source}.{alias.name}" if f"{source}.{alias.name}" in known else source for alias in names}
    return {name for name in found if name in known and name != module.name}


def repeated_classes(known: Mapping[str, Module]) -> dict[str, list[str]]:
    """Class names that more than one module defines, private ones too, with those modules."""
    places = defaultdict(list)
    for module in known.values():
        for name in module.classes():
            places[name].append(module.name)
    return {name: where for name, where in sorted(places.items()) if len(where) > 1}


def small_modules(known: Mapping[str, Module]) -> dict[str, str]:
    """Modules of few lines that a single other imports, with that one, without those of `FAMILIES`."""
    importers = defaultdict(set)
    for module in known.values():
        for name in imports(module, known):
            importers[name].add(module.name)
    return {
        module.name: next(iter(importers[module.name]))
        for module in known.values()
        if not module.is_package
        and module.lines < SMALL
        and len(importers[module.name]) == 1
        and not _is_of_family(module.name)
    }


def _is_of_family(name: str) -> bool:
    return name.rpartition(".")[0] in FAMILIES


def circles(known: Mapping[str, Module]) -> list[list[str]]:
    """Groups of modules that import each other (strongly connected components, after Tarjan)."""
    graph = {name: imports(module, known) for name, module in known.items()}
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(name: str) -> None:
        index[name] = low[name] = len(index)
        stack.append(name)
        for other in sorted(graph[name]):
            if other not in index:
                visit(other)
                low[name] = min(low[name], low[other])
            elif other in stack:
                low[name] = min(low[name], index[other])
        if low[name] == index[name]:
            at = stack.index(name)
            group = stack[at:]
            del stack[at:]
            if len(group) > 1:
                found.append(sorted(group))

    for name in graph:
        if name not in index:
            visit(name)
    return found


def main() -> None:
    """Print the figures, and with --list what they are made of."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="print names and modules too")
    options = parser.parse_args()
    known = modules()
    repeated, small, circular = repeated_classes(known), small_modules(known), circles(known)
    exported = sum(len(module.exported()) for module in known.values() if module.is_package)
    public = sum(len(list(module.public())) for module in known.values())
    figures = {
        "class names with more than one meaning": len(repeated),
        "names exported by packages": exported,
        "public functions and classes at module level": public,
        f"modules below {SMALL} lines with one importer": len(small),
        "import circles": len(circular),
        "lines of product code": sum(module.lines for module in known.values()),
        "modules": len(known),
    }
    for what, figure in figures.items():
        print(f"{what:<48}{figure:>8}")
    if options.list:
        for name, where in repeated.items():
            print(f"class {name}: {', '.join(where)}")
        for name, importer in small.items():
            print(f"small {name} ({known[name].lines} lines): {importer}")
        for group in circular:
            print(f"circle: {', '.join(group)}")


if __name__ == "__main__":
    main()
