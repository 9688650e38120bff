"""Pure maths of the plane: poses, twists, angles and segments, and the reader of ARIA `.map` files.

Metres, seconds and radians; x forward, y left, headings counter-clockwise from +x in (-pi, pi].
"""

from geometry.map_file import Cairn, MapError, MapFile, parse_map, read_map
from geometry.pose import Pose2D, Twist2D, integrate, wrap_angle
from geometry.segments import Point, Polygon, Segment, polygon_edges, polygons_overlap

__all__ = [
    "Cairn",
    "MapError",
    "MapFile",
    "Point",
    "Polygon",
    "Pose2D",
    "Segment",
    "Twist2D",
    "integrate",
    "parse_map",
    "polygon_edges",
    "polygons_overlap",
    "read_map",
    "wrap_angle",
]
