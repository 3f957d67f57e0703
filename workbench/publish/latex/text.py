"""Text for LaTeX: special characters, those beyond ASCII, powers and indices, and names instead of identifiers."""

import re
import unicodedata

_GREEK = (
    *("alpha", "beta", "gamma", "delta", "varepsilon", "zeta", "eta", "theta"),
    *("kappa", "lambda", "nu", "xi", "pi", "rho", "sigma", "tau", "varphi", "chi", "psi", "omega"),
)

_SPECIAL = {
    **{character: f"\\{character}" for character in "%&#${}"},
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "_": r"\_",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    "'": "'",
    "`": r"\textasciigrave{}",
    "[": "{[}",  # behind the end of a line it would be an argument, and so would a star
    "*": "{*}",
    "\t": " ",
    "\n": " ",
    "\r": " ",
    "\u00a0": "~",
    "\u202f": r"\,",
    "\u2009": r"\,",
    "\u00b5": r"\textmu{}",
    "\u03bc": r"\textmu{}",
    "±": r"\textpm{}",
    "°": r"\textdegree{}",
    "²": r"\textsuperscript{2}",
    "³": r"\textsuperscript{3}",
    "×": r"\texttimes{}",
    "·": r"\textperiodcentered{}",
    "–": "--",
    "—": "---",
    "−": r"\ensuremath{-}",
    "…": r"\ldots{}",
    "‘": "`",
    "’": "'",
    "“": "``",
    "”": "''",
    "≤": r"\ensuremath{\leq}",
    "≥": r"\ensuremath{\geq}",
    "≈": r"\ensuremath{\approx}",
    "≠": r"\ensuremath{\neq}",
    "→": r"\ensuremath{\rightarrow}",
    "↔": r"\ensuremath{\leftrightarrow}",
    "∞": r"\ensuremath{\infty}",
    "√": r"\ensuremath{\surd}",
    "Δ": r"\ensuremath{\Delta}",
    "\u03a9": r"\ensuremath{\Omega}",
    "\u2126": r"\ensuremath{\Omega}",
    **{letter: rf"\ensuremath{{\{name}}}" for letter, name in zip("αβγδεζηθ", _GREEK[:8], strict=True)},
    **{letter: rf"\ensuremath{{\{name}}}" for letter, name in zip("κλνξπρστφχψω", _GREEK[8:], strict=True)},
    "✓": r"\ensuremath{\surd}",
    "ß": r"\ss{}",
    "æ": r"\ae{}",
    "Æ": r"\AE{}",
    "ø": r"\o{}",
    "Ø": r"\O{}",
    "ł": r"\l{}",
    "Ł": r"\L{}",
}

_ACCENTS = dict(
    zip("\u0300\u0301\u0302\u0303\u0304\u0306\u0307\u0308\u030a\u030b\u030c\u0327\u0328", "`'^~=u.\"rHvck", strict=True)
)
"""LaTeX's accent for a combining mark."""

_IDENTIFIER = re.compile(r"(?<![\w./\\])[^\W_]\w*_\w+(?![\w/]|\.\w)")
"""A name of a program's kind, such as valve_flow_gain; not a part of the name of a file."""

_INDEX = re.compile(r"(?<!\w)([^\W\d_])_(\w{1,2})(?!\w)")
"""A symbol with an index, such as K_p."""

LONG, PIECE = 32, 8
"""Characters of a word from which on it may be broken, and of the pieces between."""

_EITHER = re.compile(r"\+-(?=\d)")

_RAISED = re.compile(r"(?<=[\w)])\^(-?\d+(?:\.\d+)?)")
"""A power, as in R^2."""


def display_name(text: str) -> str:
    """Text with names as a reader sees them: "valve_flow_gain" is "valve flow gain"; indices such as K_p stay."""
    return _IDENTIFIER.sub(lambda found: found[0] if _INDEX.fullmatch(found[0]) else found[0].replace("_", " "), text)


def escaped(text: str) -> str:
    """Text as LaTeX shows it, character by character. What its fonts lack is shown by its number: [U+4E2D]."""
    words = re.split(rf"(\S{{{LONG},}})", text)
    return "".join(r"\allowbreak{}".join(map(_piece, _breakable(word))) for word in words)


def _piece(text: str) -> str:
    return "".join(map(_character, text)).replace("---", "-{}-{}-").replace("--", "-{}-")


def shown_text(text: str) -> str:
    """Text for a reader: display names, K_p with an index, R^2 with a power, +-3 with its sign, all else escaped.

    Returns:
        LaTeX for text mode that compiles whatever `text` is.
    """
    shown, place, named = "", 0, _EITHER.sub("±", display_name(text))
    for found in sorted([*_INDEX.finditer(named), *_RAISED.finditer(named)], key=re.Match.start):
        shown += escaped(named[place : found.start()])
        if found.re is _INDEX:
            shown += rf"{escaped(found[1])}\textsubscript{{{escaped(found[2])}}}"
        else:
            shown += rf"\textsuperscript{{{found[1]}}}"
        place = found.end()
    return shown + escaped(named[place:])


def _breakable(word: str) -> list[str]:
    """The pieces of a word between which a line may break."""
    if len(word) < LONG or re.search(r"\s", word):
        return [word]
    return [word[i : i + PIECE] for i in range(0, len(word), PIECE)]


def _character(character: str) -> str:
    known = _SPECIAL.get(character)
    if known is not None:
        return known
    if " " <= character <= "~":
        return character
    base, *marks = list(unicodedata.normalize("NFD", character))
    if base.isascii() and base.isalpha() and len(marks) == 1 and marks[0] in _ACCENTS:
        return f"\\{_ACCENTS[marks[0]]}{{{base}}}"
    return f"{{[}}U+{ord(character):04X}]"
