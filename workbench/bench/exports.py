"""A scope as a file: its picture as SVG, its curves as CSV; PNG is Bokeh's own tool."""

from collections.abc import Mapping, Sequence

from bokeh.models import ColumnDataSource, CustomAction, CustomJS
from bokeh.plotting import figure

_ICON = (
    "data:image/svg+xml;utf8,<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 24 24'>"
    "<text x='12' y='16' font-size='11' font-family='sans-serif' text-anchor='middle'>{words}</text></svg>"
)

_DOWNLOAD = """
const link = document.createElement("a")
link.href = URL.createObjectURL(blob)
link.download = `${name}.${ending}`
link.click()
setTimeout(() => URL.revokeObjectURL(link.href), 1000)
"""

_SVG = f"""
const view = Bokeh.index.get_one(plot)
const layer = view.export("svg", false)
layer.to_blob().then((blob) => {{
    const ending = "svg"
    {_DOWNLOAD}
}})
"""

_CSV = f"""
const axes = [plot.below[0].axis_label ?? "x", plot.left[0].axis_label ?? "y"]
const quoted = (text) => `"${{String(text).replaceAll('"', '""')}}"`
const lines = [["curve", ...axes].map(quoted).join(",")]
for (const [words, source] of Object.entries(sources)) {{
    const {{x, y}} = source.data
    for (let i = 0; i < x.length; i++) lines.push([quoted(source.name ?? words), x[i], y[i]].join(","))
}}
const blob = new Blob([lines.join("\\n") + "\\n"], {{type: "text/csv"}})
const ending = "csv"
{_DOWNLOAD}
"""


def export_tools(plot: figure, name: str, sources: Mapping[str, ColumnDataSource]) -> Sequence[CustomAction]:
    """Tools of a figure that write its picture and its curves (those of `sources`, by name)."""
    arguments = {"plot": plot, "name": name}
    return [
        CustomAction(
            icon=_ICON.format(words="SVG"),
            description="Save as SVG",
            callback=CustomJS(args=arguments, code=_SVG),
        ),
        CustomAction(
            icon=_ICON.format(words="CSV"),
            description="Save the curves as CSV",
            callback=CustomJS(args={**arguments, "sources": dict(sources)}, code=_CSV),
        ),
    ]
