"""Pictures that applications write at their end."""

from pathlib import Path
from typing import TYPE_CHECKING

from agents import RobotError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def check_picture(picture: str) -> None:
    """Check the name of a file for a picture, before anything moves; none is right as well.

    Raises:
        RobotError: It is of another kind, or its folder does not exist.
    """
    file = Path(picture)
    if picture and (file.suffix not in (".svg", ".png") or not file.parent.is_dir()):
        raise RobotError(f"the picture {picture} cannot be written; name an .svg or .png file in a folder that exists")


def save_picture(page: "Figure", file: Path) -> None:
    """Write a drawing as SVG or PNG; the same drawing gives the same bytes.

    Raises:
        OSError: The file cannot be written.
    """
    import matplotlib  # slow to import, and only needed here

    with matplotlib.rc_context({"svg.hashsalt": "acromovi", "svg.fonttype": "none", "path.simplify": True}):
        page.savefig(file, metadata={"Date": None} if file.suffix == ".svg" else None)
