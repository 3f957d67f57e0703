"""What a study would run, in words."""

from workbench.study.plan import Plan


def description(planned: Plan) -> list[str]:
    """Title, axes, number of cases and simulated time of a study, line by line."""
    file, count = planned.study.file, len(planned.cases)
    return [
        file.title + (f" ({file.source})" if file.source else ""),
        *(f"  {name}: {', '.join(values)}" for name, values in _axes_of(planned).items()),
        f"  {count} case{'s' * (count > 1)}, {planned.simulated_seconds:g} s of simulated time",
    ]


def _axes_of(planned: Plan) -> dict[str, list[str]]:
    axes: dict[str, dict[str, None]] = {}
    for case in planned.cases:
        for name, value in case.columns.items():
            axes.setdefault(name, {})[str(value)] = None
    return {name: list(values) for name, values in axes.items()}
