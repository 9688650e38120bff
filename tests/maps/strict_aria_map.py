"""A strict reader of the ARIA map format, by itself: it shares no code with what it judges."""

import re

HEADER = re.compile(r"(MinPos|MaxPos|LineMinPos|LineMaxPos|NumPoints|NumLines|Resolution|PointsAreSorted): (.+)")
CAIRN = re.compile(r'Cairn: [A-Za-z.]+ -?\d+ -?\d+ -?\d+(\.\d+)? "[^"]*" ICON "[^"]*"( -?\d+ -?\d+ -?\d+ -?\d+)?')


def check(text: str) -> dict[str, list[tuple[int, ...]]]:
    """Assert that a text is a map to the letter; return the rows of its header, of LINES and of DATA as numbers."""
    assert text.endswith("\n")
    rows = text.split("\n")[:-1]
    assert rows[0] == "2D-Map"
    lines, data = rows.index("LINES"), rows.index("DATA")
    assert lines < data
    found: dict[str, list[tuple[int, ...]]] = {}
    for row in rows[1:lines]:
        if match := HEADER.fullmatch(row):
            assert match[1] not in found
            found[match[1]] = [tuple(int(word) for word in match[2].split() if word != "true")]
        else:
            assert row.startswith("MapInfo: ") or CAIRN.fullmatch(row), row
    for name, first, end, columns in (("LINES", lines + 1, data, 4), ("DATA", data + 1, len(rows), 2)):
        found[name] = [tuple(map(int, row.split(" "))) for row in rows[first:end]]
        assert all(len(row) == columns for row in found[name])
    assert found["NumLines"] == [(len(found["LINES"]),)]
    assert found["NumPoints"] == [(len(found["DATA"]),)]
    ends = [end for row in found["LINES"] for end in (row[:2], row[2:])]
    for prefix, points in (("", found["DATA"]), ("Line", ends)):
        for name, limit in (("MinPos", min), ("MaxPos", max)):
            corner = (limit(x for x, _ in points), limit(y for _, y in points)) if points else (0, 0)
            assert found[prefix + name] == [corner]
    assert found["DATA"] == sorted(found["DATA"])
    return found
