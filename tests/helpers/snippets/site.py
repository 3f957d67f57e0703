"""The pages that the site's build makes, importable without the site's generator."""

import sys

from command import ROOT

sys.path.append(str(ROOT / "docs"))

from builder.pages import PAGES

__all__ = ["PAGES"]
