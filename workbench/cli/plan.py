"""What a study would run, in words."""

import sys

from workbench.study.runner import Plan


def say_plan(planned: Plan) -> None:
    """Print title, axes, number of cases and simulated time of a study; its warnings to standard error."""
    file = planned.study.file
    print(file.title + (f" ({file.source})" if file.source else ""))
    for name, values in _axes_of(planned).items():
        print(f"  {name}: {', '.join(values)}")
    count = len(planned.cases)
    print(f"  {count} case{'s' * (count > 1)}, {planned.simulated_seconds:g} s of simulated time")
    for line in planned.warnings:
        print(f"warning: {line}", file=sys.stderr)


def _axes_of(planned: Plan) -> dict[str, list[str]]:
    axes: dict[str, dict[str, None]] = {}
    for case in planned.cases:
        for name, value in case.columns.items():
            axes.setdefault(name, {})[str(value)] = None
    return {name: list(values) for name, values in axes.items()}
