"""The face of a result in a notebook: a heading, a few lines, a small table and a picture, in one piece of HTML."""

import base64
import io
from collections.abc import Sequence
from html import escape

import pandas as pd
from matplotlib.figure import Figure

from workbench.publish.figure_text import drawable
from workbench.publish.style import figure_style

DOTS_PER_INCH = 80
"""Of an inline picture: some 500 pixels wide, 20 to 40 kB."""

MOST_ROWS = 12
"""Of a table: what is longer shows its first rows and says how many there are."""

DIGITS = 4
"""Significant digits of a number in a table."""


class NotebookFigure(Figure):
    """A matplotlib figure that a notebook shows without pyplot."""

    def _repr_png_(self) -> bytes:
        return png_of(self)


def png_of(figure: Figure) -> bytes:
    """The picture as PNG."""
    buffer = io.BytesIO()
    with drawable(figure), figure_style():
        figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
    return buffer.getvalue()


def face(
    title: str, *, lines: Sequence[str] = (), table: pd.DataFrame | None = None, figure: Figure | None = None
) -> str:
    """HTML that stands alone: the picture is inline, all text is escaped, nothing is fetched."""
    parts = [f"<strong>{escape(title)}</strong>", *(escape(line) for line in lines)]
    body = "".join(f"<div>{part}</div>" for part in parts)
    if table is not None and not table.empty:
        body += table.head(MOST_ROWS).to_html(index=False, na_rep="", border=0, float_format=f"{{:.{DIGITS}g}}".format)
        if len(table) > MOST_ROWS:
            body += f"<div>{len(table)} rows, the first {MOST_ROWS} shown</div>"
    if figure is not None:
        code = base64.b64encode(png_of(figure)).decode("ascii")
        body += f'<img alt="{escape(title)}" src="data:image/png;base64,{code}">'
    return f'<div class="friction-workbench">{body}</div>'
