"""The extension of Sphinx: pages are made before it looks for sources, equations and docstrings as it reads them."""

import logging
from pathlib import Path
from typing import Any

from builder import docstrings, mathml
from builder.pages import make


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    logging.getLogger("fontTools").setLevel(logging.WARNING)  # it tells every step of every font
    mathml.setup(app)
    docstrings.setup(app)
    app.connect("builder-inited", lambda app: make(Path(app.srcdir) / "made"))
    return {"parallel_read_safe": True}
