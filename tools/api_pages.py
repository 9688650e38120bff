"""Write the reference pages of the public API: `python -m tools.api_pages`. Standard library only.

The pages are made from the sources, without importing them: signature and docstring of each name that the packages in
`PUBLIC` export, and of the public methods of each class. `make docs` calls it; a test fails when a page is out of date.
"""

import ast
import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from tools.structure import Module, modules

ROOT = Path(__file__).resolve().parents[1]

INDEX = Path("docs/api.md")
PAGES = Path("docs/api")
PUBLIC = (
    "agents",
    "agents.platform",
    "bus",
    "bus.keys",
    "bus.messages",
    "cameras",
    "configs",
    "gateway",
    "geometry",
    "p2os",
    "p2os_emu",
    "p2os_emu.pytest_plugin",
)
"""Packages and modules for use from outside; a name that two of them export is described by the first."""
INTRODUCTION = """\
# Python API

These pages list everything that may be used from other projects: the names that the packages below export. Everything
else is internal and may change in any release without notice, even where its name has no underscore. Import a name
from its package, as in `from agents import Team`; the modules inside are internal too.

Numbers are in SI units and radians unless a description names another unit. All packages have types (`py.typed`).
These pages are generated from the docstrings; `make docs` writes them.
"""
SECTIONS = {"Args": "Arguments", "Raises": "Raises", "Returns": "Returns", "Yields": "Yields", "Source": "Source"}
COMMENT = re.compile(r"  #.*")
SELF = re.compile(r"^ *(self|cls)((, /)?, |(?=\)))")
SECTION = re.compile(r"({}): *(.*)".format("|".join(SECTIONS)))

Function = ast.FunctionDef | ast.AsyncFunctionDef
Definition = Function | ast.ClassDef | ast.Assign | ast.AnnAssign | ast.Module


@dataclass(frozen=True)
class Entry:
    """A name on a page. module: the one that defines it. doc: its docstring, empty without one."""

    name: str
    module: Module
    node: Definition
    doc: str

    @property
    def summary(self) -> str:
        """The first sentence of the docstring, or the first paragraph where it has no full stop."""
        paragraph = " ".join(self.doc.split("\n\n")[0].split())
        return re.split(r"(?<=\.)\s(?=[A-Z`])", paragraph)[0].rstrip(":")


def pages() -> dict[Path, str]:
    """Return the text of each page, by its path below the root."""
    known = modules()
    public = {
        package: [look_up(known, known[package], name) for name in exported(known[package])] for package in PUBLIC
    }
    homes: dict[int, str] = {}
    for package, entries in public.items():
        for entry in entries:
            homes.setdefault(id(entry.node), package)
    texts, index = {}, [INTRODUCTION]
    for package, entries in public.items():
        tree = known[package].tree
        head = Entry(package, known[package], tree, doc_of(tree))
        page = [f"# `{package}`", markdown(head.doc)]
        index += [f"## [`{package}`](api/{package}.md)", head.summary, ""]
        for entry in entries:
            is_module = isinstance(entry.node, ast.Module)
            file = f"{entry.module.name if is_module else homes[id(entry.node)]}.md"
            link = file if is_module else f"{file}#{entry.name.lower()}"
            index[-1] += f"- [`{entry.name}`](api/{link}): {entry.summary}\n"
            is_here = file == f"{package}.md"
            page.append(describe(known, homes, entry) if is_here else f"## {entry.name}\n\nSee [{file[:-3]}]({link}).")
        texts[PAGES / f"{package}.md"] = "\n\n".join(page) + "\n"
    texts[INDEX] = "\n\n".join(part.strip() for part in index) + "\n"
    return texts


def exported(module: Module) -> list[str]:
    """Names that a package or module lists in `__all__`, or else defines without an underscore; sorted."""
    names = module.exported() or [name for name in names_of(module) if not name.startswith("_")]
    return sorted(names, key=lambda name: (not name[0].isupper() or name.isupper(), name.lower()))


def names_of(module: Module) -> Iterator[str]:
    """Names that a module defines itself."""
    for node in module.tree.body:
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                yield name
            case ast.Assign(targets=[ast.Name(id=name)]) | ast.AnnAssign(target=ast.Name(id=name)):
                yield name


def look_up(known: Mapping[str, Module], module: Module, name: str, shown: str = "") -> Entry:
    """Return the definition of a name, wherever the module has it from; shown: the name in the module that exports it.

    Raises:
        LookupError: There is none in the product.
    """
    shown = shown or name
    if own := definition(module, name, shown):
        return own
    for each in ast.walk(module.tree):
        if isinstance(each, ast.ImportFrom) and each.module and each.module in known:
            for alias in each.names:
                if (alias.asname or alias.name) == name:
                    inner = known.get(f"{each.module}.{alias.name}")
                    if inner is not None:
                        return Entry(shown, inner, inner.tree, doc_of(inner.tree))
                    return look_up(known, known[each.module], alias.name, shown)
    raise LookupError(f"{module.name}.{name} is defined nowhere")


def definition(module: Module, name: str, shown: str) -> Entry | None:
    """Return the definition of a name that a module defines itself."""
    body = module.tree.body
    for node, after in zip(body, [*body[1:], None], strict=True):
        match node:
            case ast.ClassDef() | ast.FunctionDef() | ast.AsyncFunctionDef():
                if node.name == name:
                    return Entry(shown, module, node, doc_of(node))
            case ast.Assign(targets=[ast.Name(id=found)]) | ast.AnnAssign(target=ast.Name(id=found)):
                if found == name:
                    return Entry(shown, module, node, text_of(after))
    return None


def doc_of(node: Function | ast.ClassDef | ast.Module) -> str:
    """Return a docstring, empty where there is none."""
    return ast.get_docstring(node) or ""


def text_of(node: ast.stmt | None) -> str:
    """Return the text that follows a constant as its description."""
    match node:
        case ast.Expr(value=ast.Constant(value=str(text))):
            return text
    return ""


def describe(known: Mapping[str, Module], homes: Container[int], entry: Entry) -> str:
    """Return the part of a page that describes a class, a function or a constant."""
    node = entry.node
    if isinstance(node, ast.ClassDef):
        parts = [fence("\n".join(class_lines(entry.module, entry.name, node))), markdown(entry.doc)]
        for owner, method in methods(known, homes, entry):
            kind = "async " if isinstance(method, ast.AsyncFunctionDef) else ""
            parts += [f"### `{kind}{entry.name}.{heading(owner, method)}`", markdown(doc_of(method))]
    elif isinstance(node, Function):
        parts = [fence(signature(entry.module, node)), markdown(entry.doc)]
    else:
        assert isinstance(node, ast.Assign | ast.AnnAssign)
        parts = [fence(source(entry.module, node)), markdown(entry.doc)]
    return "\n\n".join(part for part in (f"## {entry.name}", *parts) if part)


def class_lines(module: Module, name: str, node: ast.ClassDef) -> Iterator[str]:
    """Decorators, head, constructor and fields of a class."""
    yield from (f"@{ast.unparse(each)}" for each in node.decorator_list)
    bases = [ast.unparse(base) for base in (*node.bases, *node.keywords)]
    yield f"class {name}({', '.join(bases)})" if bases else f"class {name}"
    for item in node.body:
        match item:
            case ast.AnnAssign(target=ast.Name(id=field)) | ast.Assign(targets=[ast.Name(id=field)]):
                if not field.startswith("_"):
                    yield f"    {source(module, item)}"
            case ast.FunctionDef(name="__init__"):
                yield f"    def {heading(module, item)}"


def methods(known: Mapping[str, Module], homes: Container[int], entry: Entry) -> Iterator[tuple[Module, Function]]:
    """Public methods and properties of a class, then those of its bases that no page describes; constructor first."""
    seen: set[str] = set()
    for each in family(known, homes, entry):
        assert isinstance(each.node, ast.ClassDef)
        for item in each.node.body:
            if isinstance(item, Function) and item.name not in seen and doc_of(item):
                seen.add(item.name)
                if item.name == "__init__" or not item.name.startswith("_"):
                    yield each.module, item


def family(known: Mapping[str, Module], homes: Container[int], entry: Entry) -> Iterator[Entry]:
    """A class and its bases, the latter as far as they are not exported."""
    assert isinstance(entry.node, ast.ClassDef)
    yield entry
    for base in entry.node.bases:
        match base:
            case ast.Name(id=name) | ast.Subscript(value=ast.Name(id=name)):
                try:
                    found = look_up(known, entry.module, name)
                except LookupError:
                    continue  # of another project
                if isinstance(found.node, ast.ClassDef) and id(found.node) not in homes:
                    yield from family(known, homes, found)


def signature(module: Module, node: Function) -> str:
    """Return the lines that define a function at module level, as written."""
    first = min([node.lineno, *(each.lineno for each in node.decorator_list)])
    lines = module.text.splitlines()[first - 1 : node.body[0].lineno - 1]
    return "\n".join(lines).removesuffix(":")


def heading(module: Module, node: Function) -> str:
    """Return name, parameters without `self`, and return type in one line; a property is shown as an attribute."""
    decorators = [ast.unparse(each) for each in node.decorator_list]
    if node.returns and ("property" in decorators or "cached_property" in decorators):
        return f"{node.name}: {source(module, node.returns)}"
    lines = module.text.splitlines()[node.lineno - 1 : node.body[0].lineno - 1]
    head = " ".join(COMMENT.sub("", line).strip() for line in lines).partition(f"def {node.name}(")[2]
    head = SELF.sub("", re.sub(r"[, ]*\) ->", ") ->", head)).removesuffix(":")
    return f"{node.name}({head.removesuffix(' -> None') if node.name == '__init__' else head}"


def source(module: Module, node: ast.AST) -> str:
    """Return a part of a module as written, or its beginning where it takes more than a few lines."""
    lines = (ast.get_source_segment(module.text, node) or "").splitlines()
    return "\n".join(lines) if len(lines) <= 5 else f"{lines[0]}..."


def markdown(doc: str) -> str:
    """Return a docstring as Markdown: its sections become lists."""
    lines: list[str] = []
    is_section = False
    for line in doc.splitlines():
        if found := SECTION.fullmatch(line):
            is_section = True
            lines += ["", f"{SECTIONS[found[1]]}: {found[2]}".rstrip(), ""]
        elif is_section and line.startswith("    ") and not line.startswith("     "):
            name, colon, text = line.strip().partition(": ")
            is_named = colon and re.fullmatch(r"[\w*, .]+", name)
            lines.append(f"- `{name}`: {text}" if is_named else f"- {line.strip()}")
        elif is_section and line.startswith("     "):
            lines.append(f"  {line.strip()}")
        else:
            is_section = is_section and not line
            lines.append(line)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip()


def fence(code: str) -> str:
    """Return a block of code."""
    return f"```python\n{code}\n```"


def write(texts: Mapping[Path, str], root: Path = ROOT) -> None:
    """Write the pages, and remove those of packages that are no longer public."""
    (root / PAGES).mkdir(parents=True, exist_ok=True)
    for path in (root / PAGES).glob("*.md"):
        if path.relative_to(root) not in texts:
            path.unlink()
    for path, text in texts.items():
        (root / path).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(pages())
