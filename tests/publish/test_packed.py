"""Numbers on a page are the numbers that went there, as finely as it says."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from page_numbers import read_floats, read_shorts

from workbench.publish.page.packed import LEVELS, floats, in_script, shorts

FINITE = st.floats(-1e12, 1e12, allow_subnormal=False)


@given(arrays.arrays(float, st.integers(0, 40), elements=FINITE))
def test_floats_keep_seven_digits(values: np.ndarray) -> None:
    assert read_floats(floats(values)) == pytest.approx(values, rel=1e-6, abs=1e-30)


@given(arrays.arrays(float, st.tuples(st.integers(1, 3), st.integers(1, 40)), elements=FINITE))
def test_shorts_keep_each_channel_to_a_step_of_its_range(values: np.ndarray) -> None:
    channels = {f"channel {i}": row for i, row in enumerate(values)}
    for name, read in read_shorts(shorts(channels)).items():
        span = float(np.ptp(channels[name]))
        assert np.max(np.abs(read - channels[name])) <= span / LEVELS + 1e-6 * float(np.max(np.abs(channels[name])))


def test_what_is_not_finite_is_at_an_end() -> None:
    read = read_shorts(shorts({"velocity": np.array([1.0, np.nan, 3.0, np.inf])}))["velocity"]
    assert read.tolist() == pytest.approx([1.0, 1.0, 3.0, 3.0])
    assert read_shorts(shorts({"none": np.array([np.nan])}))["none"].tolist() == [0.0]


def test_no_text_ends_its_script() -> None:
    assert "</" not in in_script({"title": "</script><script>alert(1)</script>"})
    assert json.loads(in_script(["</script>"])) == ["</script>"]
    with pytest.raises(ValueError, match="JSON"):
        in_script({"height": float("nan")})
