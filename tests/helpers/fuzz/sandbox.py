"""A folder in which mutants live: the project's studies around them, and a look at what was written elsewhere."""

import os
import shutil
from pathlib import Path

from command import STUDIES

from fuzz.values import ROOT

DEEP = ("one", "two", "three")
"""Folders between the sandbox's own and the files: a name with so many ".." still leads into it."""


class Sandbox:
    """A copy of studies/ in `root`, with the place of mutants in it."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.home = root.joinpath(*DEEP)
        self.studies = self.home / "studies"
        self.out = self.home / "out" / "results"
        shutil.copytree(STUDIES, self.studies)
        self.out.parent.mkdir()

    def put(self, name: str, content: bytes) -> Path:
        """Write a mutant at its place under studies/."""
        path = self.studies / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.replace(ROOT.encode(), str(self.root).encode()))
        return path

    def listing(self) -> set[str]:
        """All that there is, but for the folder of results."""
        found = set[str]()
        waiting = [str(self.root)]
        while waiting:
            with os.scandir(waiting.pop()) as entries:
                for entry in entries:
                    if entry.path != str(self.out):
                        found.add(entry.path)
                        if entry.is_dir(follow_symlinks=False):
                            waiting.append(entry.path)
        return found

    def empty(self) -> None:
        """No results any more."""
        shutil.rmtree(self.out, ignore_errors=True)
