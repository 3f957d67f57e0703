"""Units for LaTeX's siunitx: "N s/m" as \\unit{\\newton\\second\\per\\metre}."""

import re

from workbench.publish.latex.text import escaped

_SYMBOLS = {
    "m": r"\metre",
    "s": r"\second",
    "kg": r"\kilogram",
    "g": r"\gram",
    "A": r"\ampere",
    "K": r"\kelvin",
    "N": r"\newton",
    "Pa": r"\pascal",
    "J": r"\joule",
    "W": r"\watt",
    "V": r"\volt",
    "H": r"\henry",
    "Hz": r"\hertz",
    "ohm": r"\ohm",
    "Ω": r"\ohm",
    "rad": r"\radian",
    "deg": r"\degree",
    "°": r"\degree",
    "bar": r"\bar",
    "min": r"\minute",
    "h": r"\hour",
    "l": r"\litre",
    "L": r"\litre",
    "dB": r"\decibel",
    "%": r"\percent",
}

_PREFIXES = {
    "n": r"\nano",
    "µ": r"\micro",
    "\u03bc": r"\micro",
    "u": r"\micro",
    "m": r"\milli",
    "c": r"\centi",
    "d": r"\deci",
    "k": r"\kilo",
    "M": r"\mega",
    "G": r"\giga",
}

_LITERAL = ("rpm", "psi")
"""Units that siunitx has no name for, and shows as they are written."""

_TOKEN = re.compile(
    r"\s*(?:(?P<symbol>[^\W\d_]+|%|°)(?:\^(?P<power>-?\d+(?:\.\d+)?))?|(?P<one>1)(?=\s*/)|(?P<sign>[/()]))"
)

_POWERS = {"2": r"\squared", "3": r"\cubed"}


def latex_unit(unit: str) -> str | None:
    """A unit as we write it ("N s/m", "V/(m s)", "m^2/(s Pa^0.5)", "1/s", "deg") as siunitx's \\unit.

    A slash divides by the one factor behind it, or by those in brackets. Returns None for what is no unit.
    """
    factors = _factors(unit)
    if not factors:
        return None
    if any(symbol in _LITERAL for symbol, _, _ in factors):
        return rf"\unit{{{unit.replace(' ', '.')}}}" if unit.isascii() and "%" not in unit else None
    return rf"\unit{{{''.join(map(_macro, *zip(*factors, strict=True)))}}}"


def unit_text(unit: str) -> str:
    """A unit in a cell: by siunitx where it is one, else as text."""
    return latex_unit(unit) or escaped(unit)


def _factors(unit: str) -> list[tuple[str, str, bool]]:
    """Symbol, power and whether it divides, of each factor; none where it is no unit."""
    factors: list[tuple[str, str, bool]] = []
    place, divides, inside, outer = 0, False, False, False
    text = unit.strip()
    if text.count("(") != text.count(")"):
        return []
    while place < len(text):
        token = _TOKEN.match(text, place)
        if token is None:
            return []
        place = token.end()
        if token["sign"] == "/":
            divides = not outer  # in brackets that divide, it multiplies
        elif token["sign"]:
            inside = token["sign"] == "("
            divides = outer = divides and inside
        elif token["symbol"]:
            if token["symbol"] not in _LITERAL and _named(token["symbol"]) is None:
                return []
            factors.append((token["symbol"], token["power"] or "", divides))
            divides = outer
    return factors


def _named(symbol: str) -> str | None:
    """siunitx's name of a unit with its prefix."""
    if symbol in _SYMBOLS:
        return _SYMBOLS[symbol]
    prefix, rest = symbol[:1], symbol[1:]
    return _PREFIXES[prefix] + _SYMBOLS[rest] if prefix in _PREFIXES and rest in _SYMBOLS else None


def _macro(symbol: str, power: str, divides: bool) -> str:
    raised = _POWERS.get(power, rf"\tothe{{{power}}}" if power else "")
    return f"{chr(92) + 'per' if divides else ''}{_named(symbol)}{raised}"
