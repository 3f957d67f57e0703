"""What is said of a loop that holds still: words alone, for who only names them."""

from typing import Literal

Verdict = Literal["none", "decaying", "too_short", "sustained"]
"""Whether there is a limit cycle in a dwell."""
