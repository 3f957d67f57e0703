"""The page over a folder of results: what each says first, with a picture, sorted and filtered, and a link."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from html.parser import HTMLParser
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


class _Head(HTMLParser):
    """Title and meta elements of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.title, self.meta, self._within = "", dict[str, str](), False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._within = tag == "title"
        given = dict(attrs)
        if tag == "meta" and given.get("name"):
            self.meta[str(given["name"])] = given.get("content") or ""

    def handle_endtag(self, tag: str) -> None:
        self._within = False

    def handle_data(self, data: str) -> None:
        if self._within:
            self.title += data


def write_index(folder: Path) -> tuple[Path, int]:
    """Write `folder`/index.html over all results in it; returns its path and how many there are.

    Raises:
        UserError: it is no folder, or has an index.html that this program did not write.
    """
    if not folder.is_dir():
        raise UserError(f"{folder}: no such folder; name one that holds folders of results")
    path = folder / INDEX
    if path.exists() and _head(path).meta.get("generator") != GENERATOR:
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
    """All pages of results below a folder, by place."""
    pages = sorted(page for depth in range(1, DEPTH + 1) for page in folder.glob(f"{'*/' * depth}*.html"))
    found = []
    for page in pages:
        head = _head(page)
        if head.meta.get("generator") == GENERATOR and page.name != INDEX:
            found.append(_entry(page, head, folder))
    return found


def _head(page: Path) -> _Head:
    head = _Head()
    with page.open(encoding="utf-8", errors="replace") as text:
        head.feed(text.read(HEAD_CHARACTERS))
    return head


def _entry(page: Path, head: _Head, folder: Path) -> Entry:
    record = _record(page.parent / RECORD)
    picture = page.parent / "figures" / f"{head.meta.get('picture')}.png"
    took = record.get("wall_seconds")
    return Entry(
        folder=page.parent.relative_to(folder).as_posix(),
        link=_link(page, folder),
        title=head.title,
        kind=head.meta.get("kind", ""),
        says=head.meta.get("description", ""),
        cases=str(record.get("cases", "")),
        started=str(record.get("started", "")).replace("T", " ").rstrip("Z"),
        took=f"{took:.1f}" if isinstance(took, int | float) else "",
        picture=_link(picture, folder) if picture.exists() else "",
    )


def _link(path: Path, folder: Path) -> str:
    return quote(path.relative_to(folder).as_posix())


def _record(path: Path) -> dict[str, object]:
    """What run.json says; nothing where there is none, or another."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def _unfinished(folder: Path) -> Sequence[str]:
    """Folders in which cases or trials are kept that no results came of yet."""
    begun = sorted({path.parent for depth in range(1, DEPTH + 1) for path in folder.glob(f"{'*/' * depth}{DATABASE}")})
    return [place.relative_to(folder).as_posix() for place in begun if not (place / RECORD).exists()]
