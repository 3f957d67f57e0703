"""What held-out records reject: an error of position that goes up, unless they are likelier with what was found."""

import pytest

from workbench.diagnose.result import BeforeAfter, Errors, ErrorsByUse


@pytest.mark.parametrize(
    ("after", "gained", "worse"),
    [(1.01, None, False), (1.03, None, True), (1.03, -0.1, True), (1.03, 0.1, False)],
)
def test_a_free_run_is_worse_where_its_error_goes_up_and_its_likelihood_does_not(
    after: float, gained: float | None, worse: bool
) -> None:
    none = BeforeAfter(Errors({}), Errors({}))
    tested = BeforeAfter(Errors({}, position=1.0), Errors({}, position=after))
    errors = ErrorsByUse(none, tested, gained=gained)
    assert errors.runs_worse is worse
    assert ("gained_log_likelihood" in str(errors.to_json())) is (gained is not None)
