"""Equations as MathML, which browsers draw by themselves: no script, no font, nothing to fetch."""

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert


def setup(app: Any) -> None:
    """Make it the math renderer "mathml" of Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    writer.body.append(f'<div class="equation">{_mathml(node.astext(), "block")}</div>\n')
    raise nodes.SkipNode


def _mathml(equation: str, display: str) -> str:
    """MathML in which bars stand close to what they enclose, and a function to its argument."""
    found = convert(equation, display=display)
    found = re.sub(r"<mo[^>]*>(&#x0007C;|\|)</mo>", '<mo stretchy="false" lspace="0" rspace="0">|</mo>', found)
    return found.replace("<mo>sgn</mo>", '<mo lspace="0.17em" rspace="0">sgn</mo>')
