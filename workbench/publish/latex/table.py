"""A table as LaTeX: siunitx columns, booktabs' rules, notes and sources as footnotes, and a form that fits its page.

The form is the first of these that fits a text width of 160 mm at 11 pt: \\small; \\footnotesize; the same with long
text broken over lines; \\scriptsize; turned by 90 degrees; in parts, each with the first column. A table that is longer
than a page breaks over pages.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from string import ascii_lowercase

from workbench.publish.latex.columns import MOST_LINES, Column, Word, column_of, text_width
from workbench.publish.latex.text import shown_text

HEAD = "% A table of Friction Workbench; needs array, booktabs, siunitx, threeparttable"
"""How every table begins: what else it needs follows."""

MM = 72.27 / 25.4
"""Points of a millimetre."""

TEXT_WIDTH, TEXT_HEIGHT = 160.0 * MM, 235.0 * MM
"""Points: of a page, for tables that stand upright; of a turned one the other way round."""

BETWEEN = 4.0
"""\\tabcolsep, in points."""

LEAST_WIDTH = 0.6
"""Share of the text's width that a table takes at least, so that its notes have room: columns stand apart for it."""

FULL = 0.85
"""Share of a page that a table fills at most without breaking."""

SMALL, SMALLER, SMALLEST = (r"\small", 10.0), (r"\footnotesize", 9.25), (r"\scriptsize", 8.5)
"""Sizes of text in a document of 11 pt, by command, and their em in points, which grows as fonts get smaller."""


@dataclass(frozen=True)
class Form:
    """How a table is set: size of text, columns, the width (em) of those whose text is broken, and whether turned."""

    size: tuple[str, float]
    columns: Sequence[Column]
    widths: Mapping[int, float]
    turned: bool = False

    @property
    def heads(self) -> list[list[str]]:
        """The lines of the headings, of as many each."""
        heads = [_broken(column.heading, self.widths.get(i, column.width)) for i, column in enumerate(self.columns)]
        most = max(map(len, heads))
        return [[""] * (most - len(head)) + head for head in heads]

    @property
    def width(self) -> float:
        """How wide the body is, about, in points."""
        widths = (self.widths.get(i, _whole(column, column.width)) for i, column in enumerate(self.columns))
        return self.size[1] * sum(widths) + 2.0 * BETWEEN * len(self.columns)

    @property
    def height(self) -> float:
        """How high the body is, about, in points."""
        rows = len(self.columns[0].cells) if self.columns else 0
        lines = sum(
            max(
                [
                    1,
                    *(
                        -int(-text_width(self.columns[i].shown[row]) * 1.15 // width)
                        for i, width in self.widths.items()
                    ),
                ]
            )
            for row in range(rows)
        )
        return 1.22 * self.size[1] * (lines + len(self.heads[0]) + 1)


def latex_table(
    name: str,
    title: str,
    cells: Mapping[str, Sequence[str]],
    notes: Sequence[str],
    sources: Mapping[str, str],
    words: Sequence[str],
) -> str:
    """A table as LaTeX, to be read by \\input.

    Args:
        name: what its label ends in: tab:NAME.
        title: its caption.
        cells: text by column.
        notes: what stands below.
        sources: by heading, or the last part of one behind a comma, where its values come from: a footnote each.
        words: names of columns that are text, whatever their cells are.
    """
    marked = [source for source in sources if any(_is_of(heading, source) for heading in cells)]
    marks = dict(zip(marked, ascii_lowercase, strict=False))
    columns = [
        column_of(
            heading,
            list(map(str, found)),
            "".join(mark for source, mark in marks.items() if _is_of(heading, source)),
            heading in words,
        )
        for heading, found in cells.items()
    ]
    below = [
        *(rf"\item[{mark}] {shown_text(_ended(sources[source]))}" for source, mark in marks.items()),
        *(
            rf"\item[] {shown_text(_ended(f'{source}: {sources[source]}'))}"
            for source in sources
            if source not in marks
        ),
        *(rf"\item[] {shown_text(note)}" for note in notes),
    ]
    forms = _forms(columns)
    parts = []
    for number, form in enumerate(forms, 1):
        part = f" (part {number} of {len(forms)})" if len(forms) > 1 else ""
        label = rf"\label{{tab:{name}}}" if number == 1 else ""
        caption = rf"\caption{{{shown_text(title + part)}}}{label}"
        parts.append(
            _set(
                form,
                caption,
                below if number == len(forms) else [],
                sum(map(len, notes)) + sum(map(len, sources.values())),
            )
        )
    text = "\n".join(parts)
    needs = "".join(f", {package}" for package, used in _NEEDED.items() if used in text)
    return f"{HEAD}{needs}\n{text}"


_NEEDED = {"rotating": "{sidewaystable}", "longtable, threeparttablex": "{longtable}", "pdflscape": "{landscape}"}
"""Packages that not every table needs, and what needs them."""


def _is_of(heading: str, source: str) -> bool:
    """Whether the values under a heading are of a source."""
    return heading == source or heading.endswith(f", {source}")


def _ended(text: str) -> str:
    return text if text.endswith(".") else f"{text}."


# --- its form ---


def _forms(columns: Sequence[Column]) -> list[Form]:
    """The form that fits; several where the table has to be parted."""
    for size, breaks, turned in (
        (SMALL, False, False),
        (SMALLER, False, False),
        (SMALLER, True, False),
        (SMALLEST, True, False),
        (SMALLER, True, True),
        (SMALLEST, True, True),
    ):
        form = _fitted(columns, size, breaks, turned)
        if form is not None:
            return [form]
    first, *others = columns
    return _parted(first, others)


def _parted(first: Column, others: Sequence[Column]) -> list[Form]:
    """As many columns as fit, part by part, the first one in each."""
    forms: list[Form] = []
    while others:
        count = len(others)
        while (form := _fitted([first, *others[:count]], SMALLER, True, False)) is None and count > 1:
            count -= 1
        forms.append(form or Form(SMALLEST, [first, *others[:1]], {}))
        others = others[count:]
    return forms


def _fitted(columns: Sequence[Column], size: tuple[str, float], breaks: bool, turned: bool) -> Form | None:
    """The form with text of that size, broken over lines where it `breaks`; None where it does not fit."""
    room = ((TEXT_HEIGHT if turned else TEXT_WIDTH) - 2.0 * BETWEEN * len(columns)) / size[1]
    whole = [_whole(column, column.width) for column in columns]
    if sum(whole) <= room:
        return Form(size, columns, {}, turned)
    texts = [i for i, column in enumerate(columns) if column.is_text and column.width > 6.0]
    if not breaks or not texts:
        return None
    left = room - sum(width for i, width in enumerate(whole) if i not in texts)
    least = {i: _least(columns[i]) for i in texts}
    widths = _shared(left, least, {i: whole[i] for i in texts})
    return None if widths is None else Form(size, columns, widths, turned)


def _shared(left: float, least: Mapping[int, float], wanted: Mapping[int, float]) -> dict[int, float] | None:
    """The room that is left, shared so that none has less than its least, in proportion to what they lack."""
    if sum(least.values()) > left:
        return None
    lacking = {i: max(0.0, wanted[i] - least[i]) for i in least}
    share = min(1.0, (left - sum(least.values())) / (sum(lacking.values()) or 1.0))
    return {i: least[i] + share * lacking[i] for i in least}


def _least(column: Column) -> float:
    """The least width (em) of a column of text: that of its longest word, and such that no cell has too many lines."""
    longest = max(
        text_width(word)
        for text in (*column.shown, *(each.shown for each in column.heading))
        for word in [*text.split(), ""]
    )
    return max(1.1 * longest, column.width / 6.0, 5.0)


def _whole(column: Column, width: float) -> float:
    """The width (em) that a column takes with its heading."""
    return max([width, *(text_width(line) for line in _lines(column.heading, width))])


def _lines(heading: Sequence[Word], width: float) -> list[str]:
    return [" ".join(word.shown for word in line) for line in _wrapped(heading, width)]


def _broken(heading: Sequence[Word], width: float) -> list[str]:
    """The lines of a heading above cells of that width, as LaTeX."""
    return [" ".join(word.latex for word in line).replace(r" \tnote", r"\tnote") for line in _wrapped(heading, width)]


def _wrapped(heading: Sequence[Word], width: float) -> list[list[Word]]:
    """A heading in few lines of about that width (em): a unit and a mark stay with the word before where they fit."""
    room = max([width, 3.5, *(text_width(word.shown) for word in heading)])
    while len(lines := _filled(heading, room)) > MOST_LINES:
        room *= 1.1
    return lines


def _filled(heading: Sequence[Word], room: float) -> list[list[Word]]:
    lines: list[list[Word]] = [[]]
    for word in heading:
        marks = word.latex.startswith(r"\tnote")
        if lines[-1] and not marks and text_width(" ".join(each.shown for each in [*lines[-1], word])) > room:
            lines.append([])
        lines[-1].append(word)
    return lines


# --- its text ---


def _set(form: Form, caption: str, below: Sequence[str], characters: int) -> str:
    """The table in its environment."""
    page, width = (TEXT_WIDTH, TEXT_HEIGHT) if form.turned else (TEXT_HEIGHT, TEXT_WIDTH)
    noted = 9.0 * 1.22 * (0.5 * 9.0 * characters / width + len(below))
    if form.height + noted > FULL * page:
        return _long(form, caption, below)
    environment = "sidewaystable" if form.turned else "table"
    wide = form.width > LEAST_WIDTH * width
    tabular = "tabular" if wide else rf"tabular*}}{{{LEAST_WIDTH}\linewidth"
    apart = "" if wide else r"@{\extracolsep{\fill}}"
    lines = [
        rf"\begin{{{environment}}}[{'p' if form.turned else 'htbp'}]",
        *_settings(form),
        r"\centering",
        r"\begin{threeparttable}",
        caption,
        rf"\begin{{{tabular}}}{{{apart}{_format(form)}}}",
        r"\toprule",
        *_head(form),
        r"\midrule",
        *_body(form),
        r"\bottomrule",
        rf"\end{{{tabular.partition('}')[0]}}}",
        *_notes("tablenotes", below),
        r"\end{threeparttable}",
        rf"\end{{{environment}}}",
    ]
    return "\n".join(lines) + "\n"


def _long(form: Form, caption: str, below: Sequence[str]) -> str:
    count = len(form.columns)
    head = [r"\toprule", *_head(form), r"\midrule"]
    lines = [
        *([r"\begin{landscape}"] if form.turned else []),
        r"\begingroup",
        *_settings(form),
        r"\begin{ThreePartTable}",
        *_notes("TableNotes", below),
        rf"\begin{{longtable}}{{{_format(form)}}}",
        rf"{caption}\\",
        *head,
        r"\endfirsthead",
        rf"\multicolumn{{{count}}}{{l}}{{\emph{{continued}}}}\\",
        *head,
        r"\endhead",
        r"\midrule",
        rf"\multicolumn{{{count}}}{{r}}{{\emph{{continued on the next page}}}}\\",
        r"\endfoot",
        r"\bottomrule",
        *([r"\insertTableNotes"] if below else []),
        r"\endlastfoot",
        *_body(form),
        r"\end{longtable}",
        r"\end{ThreePartTable}",
        r"\endgroup",
        *([r"\end{landscape}"] if form.turned else []),
    ]
    return "\n".join(lines) + "\n"


def _settings(form: Form) -> list[str]:
    return [form.size[0], rf"\setlength{{\tabcolsep}}{{{BETWEEN:g}pt}}"]


def _notes(environment: str, below: Sequence[str]) -> list[str]:
    if not below:
        return []
    return [rf"\begin{{{environment}}}[flushleft]", r"\footnotesize\raggedright", *below, rf"\end{{{environment}}}"]


def _format(form: Form) -> str:
    """The columns of a tabular."""
    found = []
    for i, column in enumerate(form.columns):
        if column.table_format:
            plus = ",retain-explicit-plus" if "+" in column.table_format else ""
            found.append(f"S[table-format={column.table_format}{plus}]")
        elif i in form.widths:
            found.append(rf">{{\raggedright\arraybackslash}}p{{{form.widths[i] * form.size[1]:.1f}pt}}")
        else:
            found.append("l")
    return "".join(found)


def _head(form: Form) -> list[str]:
    heads = [[f"{{{line}}}" if line else "" for line in head] for head in form.heads]
    return [_row(line) for line in zip(*heads, strict=True)]


def _body(form: Form) -> list[str]:
    return [_row(row) for row in zip(*(column.cells for column in form.columns), strict=True)]


def _row(cells: Sequence[str]) -> str:
    return rf"{' & '.join(cells)} \\"
