"""What the flow agent says of one image: time to contact and flow by columns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FlowColumns:
    """Columns of one image from left to right, each an array of shape (n,).

    stamp: of the exposure, s. interval: s between the two images that were compared.
    bearings: rad, left positive. rates: 1 / time to contact, 1/s; 0 where nothing comes nearer, NaN where it is not
    known. deviations: standard deviations of the rates, 1/s. motion: length of the flow, rotation included, px/s; NaN
    where there is too little of it.
    """

    stamp: float
    interval: float
    bearings: Floats
    rates: Floats
    deviations: Floats
    motion: Floats

    @classmethod
    def of(cls, result: Mapping[str, Any]) -> "FlowColumns | None":
        """Return the columns of a result of the flow agent; None where it has no times."""
        stamp, interval, bearings = result.get("stamp"), result.get("interval"), result.get("bearings")
        if stamp is None or interval is None or bearings is None:
            return None
        flow = np.array([(np.nan, np.nan) if each is None else each for each in result["flow"]], np.float64)
        return cls(
            float(stamp),
            float(interval),
            _numbers(bearings),
            _numbers(result["rates"]),
            _numbers(result["deviations"]),
            np.hypot(*flow.reshape(-1, 2).T),
        )


def _numbers(values: Sequence[float | None]) -> Floats:
    return np.array([np.nan if each is None else each for each in values], np.float64)
