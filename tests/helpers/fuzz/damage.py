"""Mutations of bytes: what a disk, an editor, or a mail program does to a file."""

from collections.abc import Callable
from random import Random

INSERTED = (
    *(
        b"\0",
        b"\xff\xfe",
        b"\xef\xbb\xbf",
        b"\x1b[2J",
        b"\r",
        b"\n\n\n",
        b"[",
        b"]",
        b"[[",
        b"=",
        b'"',
        b'"""',
        b"'",
        b"#",
    ),
    *(
        b"\xc3",
        b"\xed\xa0\x80",
        b"\xf4\x90\x80\x80",
        b"\\u0000",
        b"\\ud800",
        b"\\x",
        b"nan",
        b"inf",
        b"1e999",
        b"-",
        b"_",
    ),
    *(b"9" * 5000, b"-" + b"9" * 4301, b"0x" + b"f" * 5000, b"9" * 20000 + b".0", b"1979-05-27T07:32:00Z", b"07:32:00"),
    *(b"deep = " + b"[" * 2000 + b"]" * 2000 + b"\n", b"deep = " + b"{a=" * 900 + b"1" + b"}" * 900 + b"\n"),
    *(b"[" + b"a." * 3000 + b"a]\n", b"a." * 3000 + b"a = 1\n", b"x" * 100_000, b"\n" * 5000, b"title = 1\n"),
)


def damaged(content: bytes, random: Random) -> bytes:
    """The bytes with one to three changes."""
    for _ in range(random.choice((1, 1, 2, 3))):
        content = random.choice(WAYS)(content, random)
    return content


def _cut(content: bytes, random: Random) -> bytes:
    return content[: random.randrange(len(content) + 1)]


def _flipped(content: bytes, random: Random) -> bytes:
    if not content:
        return content
    place = random.randrange(len(content))
    return content[:place] + bytes([content[place] ^ 1 << random.randrange(8)]) + content[place + 1 :]


def _inserted(content: bytes, random: Random) -> bytes:
    place = random.randrange(len(content) + 1)
    if random.random() < 0.5:  # where a line begins, or a value
        ends = [i + 1 for i, byte in enumerate(content) if byte in (ord("\n"), ord("="))]
        place = random.choice(ends) if ends else place
    return content[:place] + random.choice(INSERTED) + content[place:]


def _line_twice(content: bytes, random: Random) -> bytes:
    lines = content.splitlines(keepends=True)
    if not lines:
        return content
    line = random.choice(lines)
    place = random.randrange(len(lines) + 1)
    return b"".join([*lines[:place], line, *lines[place:]])


def _line_lost(content: bytes, random: Random) -> bytes:
    lines = content.splitlines(keepends=True)
    if lines:
        del lines[random.randrange(len(lines))]
    return b"".join(lines)


def _piece_lost(content: bytes, random: Random) -> bytes:
    begin = random.randrange(len(content) + 1)
    return content[:begin] + content[begin + random.randrange(1, 200) :]


def _recoded(content: bytes, random: Random) -> bytes:
    text = content.decode("utf-8", errors="replace")
    return text.encode(random.choice(("utf-16", "utf-16-le", "utf-32", "cp1252", "latin-1", "utf-7")), errors="replace")


WAYS: tuple[Callable[[bytes, Random], bytes], ...] = (
    *(_cut, _flipped, _flipped, _inserted, _inserted, _inserted, _line_twice, _line_lost, _piece_lost, _recoded),
)
