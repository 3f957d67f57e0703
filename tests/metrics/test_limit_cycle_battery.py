"""The battery of made signals: how many are judged wrong, of two draws."""

from collections import Counter

import pytest
from limit_cycle_battery import HUNTING, QUIET, battery

MOST_WRONG = 2
"""Of a hundred, all of them false alarms."""


@pytest.mark.parametrize("seed", [1, 2])
def test_the_battery(seed: int) -> None:
    signals = battery(seed)
    found = [made.verdict() for made in signals]
    wrong = [(made, one.verdict) for made, one in zip(signals, found, strict=True) if one.verdict not in made.right]
    missed = [made.kind for made, _ in wrong if made.hunts]
    told = Counter((made.kind, verdict) for made, verdict in wrong)
    print(f"seed {seed}: {len(signals)} signals, {len(wrong)} wrong, {len(missed)} of them that hunt; {dict(told)}")
    assert len(signals) == sum((HUNTING | QUIET).values()) >= 100
    assert missed == [], "no motion that hunts is taken for one that does not"
    assert len(wrong) <= MOST_WRONG * len(signals) / 100.0
    for made, one in zip(signals, found, strict=True):
        if one.verdict == "sustained" and made.period is not None:
            assert one.period == pytest.approx(made.period, rel=0.05), made.kind
        # Noise of a third of the band stands on a crest by up to 1.3 times the band.
        if one.verdict == "sustained" and made.amplitude is not None:
            assert one.amplitude == pytest.approx(made.amplitude, rel=0.05, abs=3.0 * made.band), made.kind
