"""make docs-test: every block of every page, or of those that are named."""

import sys
import tempfile
import time
from pathlib import Path

from snippets.blocks import pages
from snippets.folders import prepared
from snippets.running import BlockError, run_all


def main(wanted: list[str]) -> int:
    """Run the pages; the number of those that fail."""
    failed = 0
    for page in pages():
        if wanted and page.stem not in wanted:
            continue
        with tempfile.TemporaryDirectory() as temporary:
            started = time.monotonic()
            try:
                done = list(run_all(page, prepared(Path(temporary) / "page")))
                print(f"{page.stem}: {len(done)} blocks in {time.monotonic() - started:.0f} s", flush=True)
            except BlockError as error:
                failed += 1
                print(f"FAILED {error}", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(min(main(sys.argv[1:]), 1))
