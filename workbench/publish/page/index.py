"""The page over a folder of results: what each says first, with a picture, sorted and filtered, and a link."""

import json
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from html import unescape
from pathlib import Path
from urllib.parse import quote

from workbench.errors import UserError
from workbench.publish.folders import write_whole
from workbench.publish.page.environment import page_environment

INDEX = "index.html"

GENERATOR = "friction-workbench"

RECORD, DATABASE = "run.json", "results.sqlite"
"""What says how results came about, and what lies there before they are whole."""

HEAD_CHARACTERS = 65536
"""Of a page, in which its head ends."""

DEPTH = 3
"""Folders below the one that is shown, in which results are looked for."""

_HTML = """\
{% extends "frame.html" %}
{% block title %}Results in {{ name }}{% endblock %}
{% block summary %}{{ entries | length }} results{% endblock %}
{% block style -%}
.results img { width: 170px; display: block; }
.results td { text-align: left; min-width: 6em; }
.results td:first-child { min-width: 14em; }
.results .says { min-width: 22em; max-width: 46em; }
.says div { display: -webkit-box; -webkit-box-orient: vertical; -webkit-line-clamp: 6; overflow: hidden; }
{% endblock %}
{% block body %}
<h1>Results in {{ name }}</h1>
{% if entries %}<div class="wide"><table class="sorts results">
<thead><tr><th scope="col" class="words">result</th><th scope="col" class="words">kind</th>
<th scope="col" class="words">what it says</th><th scope="col">cases</th><th scope="col">started (UTC)</th>
<th scope="col">took (s)</th><th scope="col" class="words">picture</th></tr></thead>
<tbody>{% for entry in entries %}<tr><td><a href="{{ entry.link }}">{{ entry.title }}</a><br>
<small>{{ entry.folder }}</small></td><td>{{ entry.kind }}</td><td class="says"><div>{{ entry.says }}</div></td>
<td>{{ entry.cases }}</td><td>{{ entry.started }}</td><td>{{ entry.took }}</td>
<td>{% if entry.picture -%}
<a href="{{ entry.link }}"><img src="{{ entry.picture }}" alt="" loading="lazy"></a>{% endif %}</td>
</tr>
{% endfor %}</tbody></table></div>
{% else %}<p>No finished results here.</p>
{% endif %}{% if unfinished %}<h2>Not finished</h2>
<ul>{% for folder in unfinished %}<li>{{ folder }}: go on with <code>--resume</code></li>
{% endfor %}</ul>
{% endif %}{% endblock %}
{% block scripts %}{% endblock %}
"""


@dataclass(frozen=True)
class Entry:
    """A page of results: where it lies, what it is, what it says first, and how it came about where that is known."""

    folder: str
    link: str
    title: str
    kind: str
    says: str
    cases: str = ""
    started: str = ""
    took: str = ""
    picture: str = ""


@dataclass(frozen=True)
class _Head:
    """What a page of this program says in its head."""

    title: str
    meta: Mapping[str, str]

    @property
    def is_ours(self) -> bool:
        return self.meta.get("generator") == GENERATOR


_META = re.compile(r'<meta name="([a-z]+)" content="([^"]*)">')

_TITLE = re.compile(r"<title>([^<]*)</title>")


def write_index(folder: Path) -> tuple[Path, int]:
    """Write `folder`/index.html over all results in it; returns its path and how many there are.

    Raises:
        UserError: it is no folder, or one of results, or has an index.html that this program did not write.
    """
    if not folder.is_dir():
        raise UserError(f"{folder}: no such folder; name one that holds folders of results")
    if any(_head(page).is_ours for page in folder.glob("*.html") if page.name != INDEX):
        raise UserError(f"{folder}: is a folder of results itself; name the one that holds it, such as {folder.parent}")
    path = folder / INDEX
    if path.exists() and not _head(path).is_ours:
        raise UserError(f"{path}: is not of this program; move it away, or choose another folder")
    entries = entries_of(folder)
    html = (
        page_environment(folder)
        .from_string(_HTML)
        .render(name=folder.resolve().name, entries=entries, unfinished=_unfinished(folder))
    )
    write_whole(path, lambda beside: beside.write_text(html, encoding="utf-8"))
    return path, len(entries)


def entries_of(folder: Path) -> list[Entry]:
    """All pages of results below a folder, by place. Links lead nowhere: what lies elsewhere is not shown."""
    found = []
    for place, names in _walked(folder):
        for name in sorted(names):
            page = place / name
            if place != folder and page.suffix == ".html" and name != INDEX and (head := _head(page)).is_ours:
                found.append(_entry(page, head, folder))
    return found


def _walked(folder: Path) -> Iterator[tuple[Path, list[str]]]:
    """The folder and those below it, with the names of their files; what cannot be read, or named, is passed over."""
    for place, folders, names in os.walk(folder):
        depth = len(Path(place).relative_to(folder).parts)
        folders[:] = sorted(name for name in folders if depth < DEPTH and _can_be_said(name))
        yield Path(place), [name for name in names if _can_be_said(name)]


def _can_be_said(name: str) -> bool:
    return name.isprintable() and not any("\ud800" <= letter <= "\udfff" for letter in name)


def _head(page: Path) -> _Head:
    """The head of a page, empty of what is no file, or cannot be read."""
    text = ""
    if page.is_file() and not page.is_symlink():
        with suppress(OSError), page.open(encoding="utf-8", errors="replace") as content:
            text = content.read(HEAD_CHARACTERS)
    head, title = text.partition("<style>")[0], _TITLE.search(text)
    said = {name: unescape(content) for name, content in _META.findall(head)}
    return _Head(unescape(title[1]) if title else "", said)


def _entry(page: Path, head: _Head, folder: Path) -> Entry:
    record = _record(page.parent / RECORD)
    named = head.meta.get("picture", "")
    picture = page.parent / "figures" / f"{named}.png"
    shows = bool(re.fullmatch(r"[\w.-]+", named)) and _is_plain(picture)
    took = record.get("wall_seconds")
    return Entry(
        folder=page.parent.relative_to(folder).as_posix(),
        link=_link(page, folder),
        title=head.title,
        kind=head.meta.get("kind", ""),
        says=head.meta.get("description", ""),
        cases=str(cases) if isinstance(cases := record.get("cases"), int) else "",
        started=str(record.get("started", ""))[:20].replace("T", " ").rstrip("Z"),
        took=f"{took:.1f}" if isinstance(took, float) and math.isfinite(took) else "",
        picture=_link(picture, folder) if shows else "",
    )


def _is_plain(path: Path) -> bool:
    try:
        return path.is_file() and not path.is_symlink() and not path.parent.is_symlink()
    except OSError:
        return False


def _link(path: Path, folder: Path) -> str:
    return quote(path.relative_to(folder).as_posix())


def _record(path: Path) -> dict[str, object]:
    """What run.json says; nothing where there is none, or another."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _unfinished(folder: Path) -> Sequence[str]:
    """Folders in which cases or trials are kept that no results came of yet."""
    begun = [place for place, names in _walked(folder) if DATABASE in names and RECORD not in names]
    return [place.relative_to(folder).as_posix() for place in begun if place != folder]
