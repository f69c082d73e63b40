"""Runs and tables as pandas and xarray have them, each column with its unit. Neither is needed by anything else here."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ._native import Run, unit

if TYPE_CHECKING:
    import pandas
    import xarray

    Table = Run | Mapping[str, Any]

# As `Run.axes` has them.
_AXES = ("x", "y", "z")


def to_pandas(table: "Table") -> "pandas.DataFrame":
    """A run's columns, or the table of a sweep, as a data frame; `attrs["units"]` has the unit of each column that has one.

    Of several shared axes the columns of each stand side by side under its name.
    """
    import pandas

    if not isinstance(table, Run):
        return _framed(pandas, table)
    if len(table.axes) == 1:
        return _framed(pandas, table.columns)
    frames = [_framed(pandas, columns) for columns in table.axes]
    frame: pandas.DataFrame = pandas.concat(frames, axis="columns", keys=_AXES[: len(frames)])
    frame.attrs = frames[0].attrs
    return frame


def _framed(pandas: Any, columns: Mapping[str, Any]) -> "pandas.DataFrame":
    frame: "pandas.DataFrame" = pandas.DataFrame(dict(columns), copy=False)
    frame.attrs["units"] = _units(columns)
    return frame


def _units(names: Mapping[str, Any]) -> dict[str, str]:
    return {name: of for name in names if (of := unit(name))}


def to_xarray(table: "Table") -> "xarray.Dataset":
    """A run over its time, and its axes where it has several, or the table of a sweep over its runs; units are attributes, as `units`.

    The figures of merit of a run, its verdict and its hash are attributes of the whole.
    """
    import numpy
    import xarray

    if not isinstance(table, Run):
        return xarray.Dataset({name: ("run", column, _attributes(name)) for name, column in table.items()})
    time, several = table.columns["time_s"], len(table.axes) > 1
    named: dict[str, Any] = {}
    for name in table.columns:
        if name == "time_s":
            continue
        if several:
            rows = numpy.stack([columns[name] for columns in table.axes])
            named[name] = (("axis", "time"), rows, _attributes(name))
        else:
            named[name] = ("time", table.columns[name], _attributes(name))
    places: dict[str, Any] = {"time": ("time", time, {"units": "s"})}
    if several:
        places["axis"] = ("axis", list(_AXES[: len(table.axes)]), {})
    said = {"verdict": table.verdict, "state_hash": table.state_hash, "spectral_radius": table.spectral_radius}
    merits = {name: merit for name, merit in table.merits.items() if merit is not None}
    return xarray.Dataset(named, coords=places, attrs={**said, **merits})


def _attributes(name: str) -> dict[str, str]:
    return {"units": of} if (of := unit(name)) else {}
