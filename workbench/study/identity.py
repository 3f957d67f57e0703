"""What kept results must agree in, beside the file of their study: the numbers that it leads to, and the plug-ins."""

import hashlib
import json
from collections.abc import Iterator, Sequence

import numpy as np

from controllers.registry import CONTROLLERS
from plants.equation import to_array
from plants.laws.registry import LAWS
from plants.registry import PLANTS
from workbench.metrics.registry import METRICS
from workbench.parameters.sets import parameter_path, read_deviations
from workbench.simulation.integrators.registry import INTEGRATORS
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.setup import Setup
from workbench.study.reference_tables import REFERENCES
from workbench.study.resolve import ParsedCase, Resolved
from workbench.study.study import Case, Study
from workbench.study.uncertainty import Draws

INSTANTS = 1001
"""At which a signal is compared; one that was recorded is, sample by sample, beside."""


def led_to(cases: Sequence[Case], resolved: Sequence[Resolved]) -> dict[str, str]:
    """What the tables and files of a study lead to in these cases: hashes of all numbers, and the plug-ins."""
    numbers, signals = hashlib.sha256(), hashlib.sha256()
    for item in resolved:
        numbers.update(_controller(item))
        for part in _numbers(item.setup):
            numbers.update(part)
        for part in _signals(item.setup):
            signals.update(part)
    return {
        "parameters": numbers.hexdigest(),
        "reference": signals.hexdigest(),
        "version of the plug-ins": _plugins(cases, resolved),
    }


def led_to_when_drawn(cases: Sequence[ParsedCase]) -> dict[str, str]:
    """The same where machines are drawn from what the cases declare, with by how much these may differ from it."""
    deviations = json.dumps([dict(each.values.deviations) for each in cases], sort_keys=True)
    return {
        **led_to([each.case for each in cases], [each.resolve() for each in cases]),
        "spread of parameters": hashlib.sha256(deviations.encode()).hexdigest(),
    }


def _controller(item: Resolved) -> bytes:
    """Which controller runs, and its settings: words among them, and what another gives the same numbers."""
    loop = item.setup.loop
    return repr((loop.controller.name, loop.drives, item.settings, [feed.input for feed in item.setup.feeds])).encode()


def _numbers(setup: Setup) -> Iterator[bytes]:
    """Numbers on which a run depends and that may come from another file."""
    turned = (setup.rotary.gains,) if setup.rotary else ()
    if setup.machine is not None:
        yield repr(setup.machine.content).encode()
    for values in (setup.parameters, setup.state, setup.inputs, setup.loop.gains, *turned):
        yield to_array(values).tobytes()
    yield repr((setup.sensors, setup.seed)).encode()


def _signals(setup: Setup) -> Iterator[bytes]:
    """What a run follows, or is fed."""
    for signal in (setup.reference, *(feed.signal for feed in setup.feeds)):
        if signal is not None:
            yield signal(np.linspace(0.0, setup.duration, INSTANTS))[0].tobytes()
            yield from _recorded(signal)


def _recorded(signal: ReferenceSignal) -> Iterator[bytes]:
    """The samples of a signal that was recorded."""
    for values in vars(signal).values():
        if isinstance(values, np.ndarray):
            yield values.tobytes()


def spreads(study: Study, cases: Sequence[Case], draws: Draws) -> str:
    """All that the machines come from which a study draws, beside what it declares, as JSON."""
    sets = sorted({str(case.tables["plant"]["parameters"]) for case in cases})
    folder = study.path.parent
    deviations = {name: dict(read_deviations(parameter_path(name, folder), draws.axis)) for name in sets}
    first, count = draws.numbers[0], len(draws.numbers)
    in_a_row = [*draws.numbers] == [*range(first, first + count)]
    numbers = {"first": first, "draws": count} if in_a_row else {"numbers": [*draws.numbers]}
    table = draws.table.model_dump(exclude={"draws"})
    return json.dumps({"uncertainty": {**numbers, **table}, "standard deviations": deviations}, default=str)


def _plugins(cases: Sequence[Case], resolved: Sequence[Resolved]) -> str:
    """The plug-ins that the cases name, and all metrics, each with a hash of its source; "" without any."""
    used = {item.setup.plant for item in resolved}
    types = {str(table.get("type")) for case in cases for table in case.tables["controllers"].values()}
    sources = [(name, PLANTS.source(name)) for name, plant in PLANTS.working().items() if plant in used]
    sources += [(name, CONTROLLERS.source(name)) for name in sorted(types)]
    sources += [(name, METRICS.source(name)) for name in METRICS.working()]
    laws = {str(case.tables.get("plant", {}).get("friction", "")) for case in cases}
    sources += [(name, LAWS.source(name)) for name in sorted(laws)]
    methods = {item.setup.integrator.method for item in resolved}
    sources += [(name, INTEGRATORS.source(name)) for name in sorted(methods)]
    kinds = {str(table.get("kind")) for case in cases for table in case.tables["references"].values()}
    sources += [(name, REFERENCES.source(name)) for name in sorted(kinds)]
    return ", ".join(f"{name} {source}" for name, source in sources if source)
