"""What kept runs on machines that are drawn as they are needed must agree in."""

import hashlib
import json
from collections.abc import Sequence

from workbench.study.plan import Plan
from workbench.study.resolve import ParsedCase
from workbench.study.study import Study


def led_to(study: Study, cases: Sequence[ParsedCase]) -> dict[str, str]:
    """What the tables and the files of a study lead to in these cases: numbers, by how much machines that are drawn may
    differ from them, plug-ins.
    """
    planned = Plan(study, [each.case for each in cases], list(cases), [each.resolve() for each in cases]).identity
    deviations = json.dumps([dict(each.values.deviations) for each in cases], sort_keys=True)
    return {
        "parameters": planned["parameters"],
        "spread of parameters": hashlib.sha256(deviations.encode()).hexdigest(),
        "version of the plug-ins": planned["version of the plug-ins"],
    }
