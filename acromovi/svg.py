"""Parts shared by all SVG drawings: self-contained files in one style."""

from collections.abc import Iterable
from xml.sax.saxutils import escape

LETTER = 6.4  # px, the width of a letter of 11 px, rather wide
COLOURS = ("#1f77b4", "#2a9d4a", "#9467bd", "#d9730d", "#0f9aa8", "#c2409a", "#8c6239", "#5b6abf", "#7a8a1f", "#d4487a")
STYLE = (
    "text{font:11px system-ui,'Segoe UI','DejaVu Sans',sans-serif;fill:#1f2937}"
    ".name{font-weight:600}.title{font-size:13px;font-weight:600}"
    ".label{paint-order:stroke;stroke:#fff;stroke-width:4px;stroke-linejoin:round}"
)


def document(width: float, height: float, title: str, style: str, parts: Iterable[str]) -> str:
    """A drawing of so many px, with its title at the top."""
    lines = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}">',
        f"<title>{written(title)}</title>",
        f"<style>{style}</style>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        f'<text class="title" x="16" y="24">{written(title)}</text>',
        *parts,
        "</svg>",
    )
    return "\n".join(lines) + "\n"


def head(name: str, colour: str) -> str:
    """The head of an arrow, for `marker-end="url(#name)"`; its tip is 7 px beyond the end of the line."""
    return (
        f'<marker id="{name}" viewBox="0 0 8 8" refX="2" refY="4" markerWidth="9" markerHeight="9" '
        f'markerUnits="userSpaceOnUse" orient="auto"><path d="M0 0 L8 4 L0 8 z" fill="{colour}"/></marker>'
    )


def width_of(text: str) -> float:
    """px of a text in letters of 11 px, rather more than less."""
    return LETTER * sum(2 if ord(letter) > 0x2E80 else 1 for letter in text)  # 0x2E80: where the wide scripts begin


def written(text: str) -> str:
    """A text for XML, without what XML cannot carry."""
    return escape("".join(each if each.isprintable() or each == "\n" else " " for each in text))
