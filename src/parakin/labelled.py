"""Arrays with named dimensions: a result before it is a Dataset.

Importing xarray, and pandas with it, takes longer than most motions take to solve. The command line
needs arrays by name and little more, which these are, with the names that xarray has for it; what
reads results takes either. `dataset` makes the Dataset that users get.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from typing import TypeAlias

    import xarray as xr

    Result: TypeAlias = "xr.Dataset | Labelled"


class Variable(NamedTuple):
    """An array, the names of its dimensions, and what is told of it, such as its unit."""

    dims: tuple[str, ...]
    values: Any
    attrs: Mapping[str, Any]

    @classmethod
    def of(cls, dims: str | tuple[str, ...], values: Any, attrs: Any = None) -> Variable:
        return cls((dims,) if isinstance(dims, str) else dims, np.asarray(values), attrs or {})


@dataclass
class Labelled:
    """Variables by name, `labels` of their dimensions among them, and attributes of the whole."""

    variables: dict[str, Variable]
    labels: Collection[str]
    attrs: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Variable:
        return self.variables[name]

    def __contains__(self, name: str) -> bool:
        return name in self.variables

    @property
    def sizes(self) -> dict[str, int]:
        return {
            dim: size
            for variable in self.variables.values()
            for dim, size in zip(variable.dims, variable.values.shape, strict=True)
        }

    def isel(self, *, time: Any) -> Labelled:
        """Some samples: a slice or a mask. Not a copy where it is a slice."""
        chosen = {
            name: v._replace(values=v.values[time]) if v.dims[:1] == ("time",) else v
            for name, v in self.variables.items()
        }
        return replace(self, variables=chosen)

    def copy(self) -> Labelled:
        """The same, of arrays of its own."""
        own = {n: v._replace(values=v.values.copy()) for n, v in self.variables.items()}
        return replace(self, variables=own, attrs=dict(self.attrs))

    def drop_dims(self, names: Collection[str]) -> Labelled:
        """Without the variables that have one of these dimensions."""
        kept = {n: v for n, v in self.variables.items() if not set(v.dims) & set(names)}
        return replace(self, variables=kept, labels=[n for n in self.labels if n in kept])

    def dataset(
        self, known: tuple[Mapping[Hashable, xr.Variable], Mapping[Hashable, xr.Index]] = ({}, {})
    ) -> xr.Dataset:
        """As xarray has it. known: labels that many results have in common, with their indexes."""
        import xarray as xr

        common, indexes = known
        labels = {n: xr.Variable(*self[n]) for n in self.labels if n not in common}
        made = {n: xr.indexes.PandasIndex(v.values, n) for n, v in labels.items() if v.dims == (n,)}
        data = {n: v for n, v in self.variables.items() if n not in self.labels}
        coordinates = xr.Coordinates({**common, **labels}, {**indexes, **made})
        return xr.Dataset(data, coordinates, self.attrs)


def joined(windows: Sequence[Labelled]) -> Labelled:
    """The windows of a result as one, with the attributes of the first."""
    if len(windows) == 1:
        return windows[0]
    first = windows[0]
    whole = {
        name: v._replace(values=np.concatenate([each[name].values for each in windows]))
        if v.dims[:1] == ("time",)
        else v
        for name, v in first.variables.items()
    }
    return replace(first, variables=whole)
