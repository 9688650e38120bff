"""The way that the robot came, to go back along it: what it came through backward it surely fits through."""

from math import hypot

from apps.indoor_navigation.data import Place

STEP = 0.1  # m between two
AT_ONCE = 4  # of them, to the next one to go back to, so that the way is smooth
RECENT, BESIDE = 6, 0.3  # how many may be taken up at once, and m beside them
MOST = 100


class Breadcrumbs:
    """Places in odom, the last one where the robot is; going back takes up those that it comes past."""

    def __init__(self) -> None:
        self._places: list[Place] = []

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, number: int) -> Place:
        return self._places[number]

    def drop(self, place: Place) -> None:
        """The robot is here now."""
        places = self._places
        recent = places[-RECENT:]
        apart = [_apart(place, crumb) for crumb in recent]
        if recent and min(apart) < BESIDE:
            del places[len(places) - len(recent) + apart.index(min(apart)) + 1 :]
        if not places or _apart(place, places[-1]) >= STEP:
            places.append(place)
        del places[:-MOST]

    def forget(self) -> None:
        """The robot's pose was set anew."""
        self._places.clear()

    def towards(self, number: int) -> Place:
        """Where to go next, on the way back to one of them."""
        return self._places[max(number, len(self._places) - 1 - AT_ONCE)]


def _apart(one: Place, other: Place) -> float:
    return hypot(other[0] - one[0], other[1] - one[1])
