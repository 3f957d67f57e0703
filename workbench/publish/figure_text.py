"""Text of figures as matplotlib can draw it: mathematics that cannot be set is shown as written, as are single dollars;
a glyph that the font lacks is a box, and a very long line is its beginning.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text

from workbench.errors import shortened, visible

BOX = "\u25a1"

LONGEST = 120
"""Characters of a line that a figure shows: a longer one would leave no room for what is drawn."""

LATIN = "\u0250"
"""The first character that a font of figures may lack."""


def mathematics_fails(text: str) -> str:
    """Why matplotlib cannot set the mathematics between the dollars of a text, in words; "" where it can."""
    try:
        for line in text.split("\n"):  # as it is set
            MathTextParser("path").parse(line)
    except RecursionError:
        return "it is too deep"
    except ValueError as error:
        return str(error).strip().splitlines()[-1]
    return ""


def lacking(text: str, font: FontProperties | None = None) -> str:
    """The characters of a text that the font of figures does not have, each once."""
    if all(letter < LATIN for letter in text):
        return ""
    known = get_font(findfont(font or FontProperties())).get_charmap()
    return "".join(dict.fromkeys(letter for letter in text if letter != "\n" and ord(letter) not in known))


def boxed(text: str, font: FontProperties | None = None) -> str:
    """Visible text with a box for each character that the font lacks."""
    shown = visible(text)
    absent = lacking(shown, font)
    return shown.translate(dict.fromkeys(map(ord, absent), BOX)) if absent else shown


def literal(text: str) -> str:
    """A name as it stands, where matplotlib looks for mathematics between dollars."""
    return boxed(text).replace("$", r"\$")


def _shown(said: str, font: FontProperties) -> str:
    """What can be drawn of a text: of a long line its beginning."""
    return "\n".join(shortened(line, LONGEST) for line in boxed(said, font).split("\n"))


@contextmanager
def drawable(figure: Figure) -> Iterator[None]:
    """Within this context every text of the figure can be drawn; afterwards it is what it was."""
    before = [(text, text.get_text(), text.get_parse_math()) for text in figure.findobj(Text) if isinstance(text, Text)]
    for text, said, parsed in before:
        if (shown := _shown(said, text.get_fontproperties())) != said:
            text.set_text(shown)
        if parsed and "$" in said and mathematics_fails(shown):
            text.set_parse_math(False)
    try:
        yield
    finally:
        for text, said, parsed in before:
            text.set_parse_math(parsed)
            if text.get_text() == _shown(said, text.get_fontproperties()):
                text.set_text(said)
