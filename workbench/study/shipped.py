"""Cases that are run on another machine: their rows come back with the files that they leave."""

import functools
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from workbench.parallel.cluster import check_version
from workbench.publish.folders import write_whole
from workbench.study.case_runs import CaseRuns
from workbench.study.plan import PROGRAM_FOLDERS
from workbench.study.store import Row


class Shipped(NamedTuple):
    """A row from another machine, with the files that the case leaves, by their place in the folder of results."""

    row: Row
    files: Mapping[str, bytes]


@dataclass(frozen=True)
class ShippedRuns:
    """The same work on another machine, which need not see the folder of results; it needs the same `version`."""

    work: CaseRuns
    version: str

    def __call__(self, indices: Sequence[int]) -> list[Shipped]:
        """Raises UserError where the other machine's program is of another version."""
        check_version(self.version, PROGRAM_FOLDERS)
        with tempfile.TemporaryDirectory() as name:
            work = replace(self.work, folder=Path(name))
            return [Shipped(row, _files(work, row)) for row in work(indices)]


def _files(work: CaseRuns, row: Row) -> dict[str, bytes]:
    paths = work.files(work.cases[row.case])
    return {str(path.relative_to(work.folder)): path.read_bytes() for path in paths}


def unpacked(results: Sequence[Row | Shipped], folder: Path) -> list[Row]:
    """Rows, the files that came with them written."""
    rows = []
    for result in results:
        if isinstance(result, Shipped):
            for name, content in result.files.items():
                (folder / name).parent.mkdir(exist_ok=True)
                write_whole(folder / name, functools.partial(Path.write_bytes, data=content))
        rows.append(result.row if isinstance(result, Shipped) else result)
    return rows
