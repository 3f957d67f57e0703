"""A record smoothed and differentiated: the same sums whatever way they are made, and no sample that a gap touches."""

import numpy as np
import pytest

from workbench.diagnose.residuals import motion


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("samples", [700, 40_000])
def test_a_wide_window_has_the_sums_of_any(monkeypatch: pytest.MonkeyPatch, samples: int, order: int) -> None:
    values = 1e-3 * np.cumsum(np.random.default_rng(3).standard_normal(samples))
    wide = motion.smoothed(values, 1201, order, 5e-5)
    monkeypatch.setattr(motion, "WIDE", 10_000)
    plain = motion.smoothed(values, 1201, order, 5e-5)
    assert wide == pytest.approx(plain, abs=1e-12 * np.max(np.abs(plain)))
    assert not np.array_equal(wide, plain), "they are made in two ways"
