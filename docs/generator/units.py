"""Units from names: the unit stands at the end of every name that crosses a boundary."""

from __future__ import annotations

import re

_SYMBOLS = {
    **{name: name for name in ("kg", "m", "s", "N", "rad", "Hz", "J", "mm", "px", "deg", "V")},
    **{"m2": "m²", "m3": "m³", "s2": "s²", "mm2": "mm²", "percent": "%", "fraction": "1"},
}


def unit_of(name: str) -> str:
    """The unit at the end of a name, `damping_N_s_per_m` is in N s/m; empty where the name has none.

    Parameters
    ----------
    name : a key of the model file, a parameter or a column; an index behind it (`b_l_N[0]`) does not count.

    Returns
    -------
    The unit as it is printed, "1" for a fraction.
    """
    tokens = re.sub(r"\[\d+\]$", "", name).split("_")
    first = len(tokens)
    while first > 0 and (tokens[first - 1] in _SYMBOLS or (tokens[first - 1] == "per" and first < len(tokens))):
        first -= 1
    above, _, below = " ".join(tokens[first:]).partition("per ")
    over, under = (" ".join(_SYMBOLS[token] for token in part.split()) for part in (above, below))
    return f"{over or '1'}/{under}" if under else over
