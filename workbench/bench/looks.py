"""How widgets of the bench look: in the colours of the page, light or dark."""

from typing import Any

Options = list[str | tuple[Any, str]]
"""What may be chosen: values with what a reader is shown of each."""

WIDGETS = """
:host { color: var(--ink); font-size: 13px; }
.bk-input, select.bk-input, .bk-btn { background: var(--paper); color: var(--ink); border-color: var(--line); }
.bk-btn.bk-active { background: var(--strong); color: var(--paper); }
.bk-input-group > label, .bk-slider-title { color: var(--ink); }
"""
"""A style sheet of each widget: those of the page do not reach into it."""

WRAPPED = ":host .bk-btn-group { flex-wrap: wrap; }"
