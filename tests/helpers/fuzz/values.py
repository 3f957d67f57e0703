"""Values and names that no file should hold, and some do."""

import datetime
from collections.abc import Callable
from random import Random

ROOT = "/SANDBOX"
"""Stands in a mutant for the folder around everything: absolute paths lead into it."""

NUMBERS: tuple[object, ...] = (
    *(0, -1, 1, 2, 3, 1000, 2**31, 2**63 - 1, -(2**63), 2**64, 10**30, 10**400, 0.0, -0.0, 1.0, -1.0, 0.5),
    *(1e-3, 1e-9, 1e-12, 1e-300, 5e-324, 1e9, 1e12, 1e20, 1e300, -1e300, float("nan"), float("inf"), float("-inf")),
)

QUANTITIES = (
    *("1 mm", "0 m", "-5 mm", "1e300 m", "1e-300 s", "1e400 s", "nan m", "inf", "-inf s", "1e12 s", "1e-12 s", "1 s"),
    *(
        "460 rpm",
        "-460 rpm",
        "1e30 rpm",
        "3 rad",
        "90 deg",
        "1 Hz",
        "1e15 Hz",
        "2 V",
        "1 bar",
        "20 degC",
        "1 delta_degC",
    ),
    *("1e5 N s/m", "1 1/s", "5 %", "1 m**1e9", "1 m^m", "1 m/", "1 __import__('os')", "1 m" * 40, "1" * 5000 + " m"),
)

TEXTS = (
    *("", " ", "\n", "\t", "\r\n", "\0", "a\0b", "\x1b[31mred\x1b[0m", "\x1b]0;title\x07", "\x08\x08\x7f", "\u009b31m"),
    *(
        "ä",
        "摩擦",
        "مرحبا",
        "👩‍🔧",
        "a\u0301",
        "\u202eabc",
        "\u2028",
        "\ufeffx",
        "\ufffe",
        "\U000e0001",
        "\ud7ff",
        "İıſß",
    ),
    *("$", "$$", "$\\frac{1}{", "$x_{a_b}_c$", "$\\undefined$", "\\input{/etc/hosts}", "\\end{document}", "%", "#&_^~"),
    *(
        "<script>alert(1)</script>",
        "</script>",
        "{{ 7*7 }}",
        "{% raise %}",
        "|",
        "a|b",
        "**b**",
        "[a](b)",
        "`c`",
        "---",
    ),
    *(
        "x" * 300,
        "x" * 5000,
        "摩" * 3000,
        "a b " * 500,
        "\n".join("abc"),
        "'",
        '"',
        "\\",
        "a'b\"c",
        "${HOME}",
        "%s%n",
        "{0}",
    ),
)

NAMES = (
    *(
        "..",
        ".",
        "../evil",
        "../../evil",
        "../../../evil",
        f"{ROOT}/evil",
        "a/b",
        "a\\b",
        "..\\evil",
        "~",
        "~root",
        ".hidden",
    ),
    *(
        "con",
        "CON",
        "nul.txt",
        "aux",
        "COM1",
        "a:b",
        "C:\\evil",
        "a.",
        "a ",
        " a",
        "a\0b",
        "a\nb",
        "-rf",
        "*",
        "?",
        "a?b",
    ),
    *(
        "{machine}",
        "x" * 300,
        "摩" * 200,
        "a" * 255,
        "Case",
        "case",
        "CASE",
        "rpm",
        "outcome",
        "case_index",
        "index",
        "plain",
    ),
    *(
        "1",
        "0",
        "true",
        "nan",
        "a.b",
        "a..b",
        'a"b',
        "a'b",
        "time",
        "position",
        "reference",
        "controller",
        "machine",
        "",
    ),
)

DATES = (
    datetime.date(2001, 2, 3),
    datetime.time(4, 5, 6),
    datetime.datetime(2001, 2, 3, 4, 5, 6),
    datetime.datetime(1, 1, 1, tzinfo=datetime.timezone.utc),  # noqa: UP017
)


def odd_name(random: Random) -> str:
    """A name that may lead elsewhere, or cannot be one of a file."""
    return random.choice(NAMES + TEXTS)


def odd_value(random: Random, depth: int = 0) -> object:
    """A value of any type."""
    makers: tuple[Callable[[], object], ...] = (
        lambda: random.choice(NUMBERS),
        lambda: random.choice(QUANTITIES),
        lambda: random.choice(TEXTS),
        lambda: odd_name(random),
        lambda: random.choice(DATES),
        lambda: random.random() < 0.5,
        lambda: [odd_value(random, depth + 1) for _ in range(random.randrange(4))] if depth < 3 else [],
        lambda: (
            {odd_name(random): odd_value(random, depth + 1) for _ in range(random.randrange(3))} if depth < 3 else {}
        ),
        lambda: "".join(chr(random.randrange(1, 0xD7FF)) for _ in range(random.randrange(1, 30))),
    )
    return random.choice(makers)()
