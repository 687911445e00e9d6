# SPDX-License-Identifier: Apache-2.0
"""Columns as data frames of pandas and Polars, which are extras."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .errors import ConfigError

if TYPE_CHECKING:
    import pandas
    import polars

__all__ = ["Columns", "Tabular"]

Columns = Mapping[str, NDArray[Any]]
"""Name -> (n,) values; of a masked array of whole numbers, those that are masked are missing."""


class Tabular:
    """Something with columns, which can be copied into a data frame."""

    def _columns(self) -> Columns:
        raise NotImplementedError

    def to_pandas(self) -> pandas.DataFrame:
        """A copy as a frame of pandas; a column with missing values is of its nullable type Int64.

        Raises:
            ConfigError: pandas is not installed.
        """
        pandas = _imported("pandas", "to_pandas")

        def column(values: NDArray[Any]) -> Any:
            if np.ma.isMaskedArray(values):
                return pandas.arrays.IntegerArray(np.ma.getdata(values).copy(), np.ma.getmaskarray(values).copy())
            return values.copy()

        return pandas.DataFrame({name: column(values) for name, values in self._columns().items()})

    def to_polars(self) -> polars.DataFrame:
        """As `to_pandas`, of Polars, with null for missing values.

        Raises:
            ConfigError: Polars is not installed.
        """
        polars = _imported("polars", "to_polars")

        def column(name: str, values: NDArray[Any]) -> Any:
            column = polars.Series(name, np.ma.getdata(values).copy())
            return column.set(polars.Series(np.ma.getmaskarray(values)), None) if np.ma.isMaskedArray(values) else column

        return polars.DataFrame([column(name, values) for name, values in self._columns().items()])


def _imported(package: str, method: str) -> Any:
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        raise ConfigError(f"{method}: {package} is not installed: pip install 'evcot[{package}]'") from error
