"""Networked haptics: scenes, runs, stability and sweeps, computed by the code that flies (docs/guides/python.md).

Columns and figures of merit carry their unit at the end of their name: `_m`, `_mm`, `_n`, `_j`, `_s`.
"""

from ._native import (
    Findings,
    Journal,
    LivePeer,
    LiveState,
    Pair,
    Pairs,
    Peer,
    Run,
    Scene,
    Stability,
    Study,
    Sweep,
    __version__,
    add_law,
    advice,
    generate_key,
    keys,
    limit,
    run,
    scenes,
    stability,
    unit,
)
from .tables import to_pandas, to_xarray

__all__ = [
    "Findings",
    "Journal",
    "LivePeer",
    "LiveState",
    "Pair",
    "Pairs",
    "Peer",
    "Run",
    "Scene",
    "Stability",
    "Study",
    "Sweep",
    "__version__",
    "add_law",
    "advice",
    "generate_key",
    "keys",
    "limit",
    "run",
    "scenes",
    "stability",
    "to_pandas",
    "to_xarray",
    "unit",
]
