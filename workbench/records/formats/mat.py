"""MAT files of MATLAB: vectors, matrices, structs, and what Simulink logs."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.records.formats.interface import RecordFormat, library

if TYPE_CHECKING:
    import pandas as pd

MOST_COLUMNS = 100
"""Columns of a matrix beyond which it is no set of channels."""


def read(path: Path) -> "pd.DataFrame":
    """All vectors that are as long as the longest: fields of structs have dotted names, columns of a matrix numbers.

    Of Simulink's "structure with time" the signals have their labels.
    """
    import pandas as pd
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = {
            name: _plain(value)
            for name, value in loadmat(path, squeeze_me=True, struct_as_record=False).items()
            if not name.startswith("__")
        }
    except NotImplementedError:  # version 7.3 is HDF5
        content = _hdf5(path)
    except MatReadError as error:
        raise ValueError(str(error)) from None
    columns = {name: values for key, value in content.items() for name, values in _columns(key, value)}
    longest = max((values.size for values in columns.values()), default=0)
    return pd.DataFrame({name: values for name, values in columns.items() if values.size == longest})


def _plain(value: Any) -> Any:
    """A value of scipy as numbers, text, a dictionary (a struct) or a list (a struct array)."""
    if hasattr(value, "_fieldnames"):
        return {name: _plain(getattr(value, name)) for name in value._fieldnames}
    if isinstance(value, np.ndarray) and value.dtype == object:
        return [_plain(each) for each in value.ravel()]
    return value


def _hdf5(path: Path) -> dict[str, Any]:
    """The same of a file of version 7.3."""
    h5py = library("h5py", path)
    with h5py.File(path) as file:
        return {name: _of_hdf5(item, h5py, file) for name, item in file.items() if not name.startswith("#")}


def _of_hdf5(item: Any, h5py: Any, file: Any) -> Any:
    if isinstance(item, h5py.Group):
        found = {name: _of_hdf5(each, h5py, file) for name, each in item.items()}
        sizes = {len(value) if isinstance(value, list) else 0 for value in found.values()}
        if len(sizes) == 1 and 0 not in sizes:  # a struct array has a list for each field
            return [{name: value[k] for name, value in found.items()} for k in range(sizes.pop())]
        return found
    if item.dtype == h5py.ref_dtype:
        return [_of_hdf5(file[reference], h5py, file) for reference in np.ravel(item[()])]
    values = np.squeeze(np.transpose(item[()]))
    if item.attrs.get("MATLAB_class", b"") == b"char":
        return "".join(map(chr, np.ravel(values)))
    return np.array([]) if item.attrs.get("MATLAB_empty", 0) else values


def _columns(name: str, value: Any) -> Iterator[tuple[str, np.ndarray]]:
    """The vectors in a value, each with its name."""
    if isinstance(value, Mapping):
        if "time" in value and "signals" in value:
            yield from _logged(name, value)
            return
        for field, each in value.items():
            yield from _columns(f"{name}.{field}", each)
    elif isinstance(value, list):
        for k, each in enumerate(value):
            yield from _columns(f"{name}_{k}", each)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "iufb" and value.size > 1:
        if value.ndim == 1:
            yield name, value
        elif value.ndim == 2 and min(value.shape) <= MOST_COLUMNS:
            tall = value if value.shape[0] >= value.shape[1] else value.T
            yield from ((f"{name}_{k}", column) for k, column in enumerate(tall.T))


def _logged(name: str, value: Mapping[str, Any]) -> Iterator[tuple[str, np.ndarray]]:
    """Simulink's structure with time: one clock, and signals with values and a label."""
    yield from _columns(f"{name}.time", value["time"])
    signals = value["signals"] if isinstance(value["signals"], list) else [value["signals"]]
    for k, signal in enumerate(signals):
        label = signal.get("label", "")
        known = label if isinstance(label, str) and label else f"signals_{k}"
        yield from _columns(f"{name}.{known}", signal.get("values"))


MAT = RecordFormat("mat", "MATLAB: vectors, matrices and structs, as long as the longest", (".mat",), read)
