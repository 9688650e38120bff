"""Beams that have measured nothing, which is not the same as beams that have met nothing."""

import numpy as np

from apps.indoor_navigation.data import Floats


def filled(ranges: Floats) -> Floats | None:
    """Ranges in m with NaN, for no measurement, replaced by the shorter of the nearest measured ones on either side.

    A wall may be too dark to be measured; that it is free is never concluded from that. None where no beam measured.
    """
    missing = np.isnan(ranges)
    if missing.all():
        return None
    if not missing.any():
        return ranges
    places = np.flatnonzero(~missing)
    after = np.minimum(np.searchsorted(places, np.arange(len(ranges))), len(places) - 1)
    before = np.maximum(np.searchsorted(places, np.arange(len(ranges)), side="right") - 1, 0)
    nearer = np.minimum(ranges[places[before]], ranges[places[after]])
    return np.where(missing, nearer, ranges)
