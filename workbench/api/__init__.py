"""The program in Python: `import workbench as wb`.

A loop is a plant with a controller that follows a reference. It is described once and then simulated, judged and
linearised:

>>> import workbench as wb
>>> loop = wb.setup(
...     "rotating", "owen2001_simulation", rpm=460, controller=wb.pid(kp=500), reference=wb.sine("30 mm", "0.9 Hz")
... )
>>> run = wb.simulate(loop)
>>> run.outcome
'torque-limited'

The motor of this parameter set cannot hold 460 rpm, and the run says so. Many such loops are a study, and each question
that the command line answers is a function of its name: `tune`, `decide`, `identify`, `diagnose`. Quantities are SI
floats or text with a unit ("30 mm"); rpm is in rpm. Whatever is wrong raises `UserError`, in the words of the command
line. Nothing is printed.

In the examples `folder` is an empty folder, `experiment` the path of an experiment with its records, and `small_study`
this:

>>> small_study = {
...     "title": "P control, without and with rotation",
...     "plant": {"model": "by_rpm", "parameters": "owen2001_simulation"},
...     "axes": {"rpm": [0, 120]},
...     "controllers": {"p": wb.pid(kp=500)},
...     "references": {"sine": wb.sine("5 mm", "2 Hz")},
...     "simulation": {"duration": "1 s"},
... }
"""

from workbench.api.analysis import linearise, loop_gain, margins
from workbench.api.bench import Bench, bench
from workbench.api.controllers import ControllerChoice, controller, controller_functions
from workbench.api.exports import export_controller, export_linear, export_plant, rehearse
from workbench.api.loops import LoopSetup, setup
from workbench.api.questions import decide, design, diagnose, identify, report, tune
from workbench.api.references import ReferenceChoice, chirp, multisine, ramp, recorded, reference, sine, steps, triangle
from workbench.api.results import CaseResult, StudyResults
from workbench.api.runs import LoopRun, evaluate, simulate
from workbench.api.studies import Study
from workbench.errors import UserError
from workbench.publish.page_format import figures_at

__all__ = [
    "Bench",
    "CaseResult",
    "ControllerChoice",
    "LoopRun",
    "LoopSetup",
    "ReferenceChoice",
    "Study",
    "StudyResults",
    "UserError",
    "bench",
    "chirp",
    "controller",
    "decide",
    "design",
    "diagnose",
    "evaluate",
    "export_controller",
    "export_linear",
    "export_plant",
    "figures_at",
    "identify",
    "linearise",
    "loop_gain",
    "margins",
    "multisine",
    "ramp",
    "recorded",
    "reference",
    "rehearse",
    "report",
    "setup",
    "simulate",
    "sine",
    "steps",
    "triangle",
    "tune",
]

for _name, _function in controller_functions().items():
    if _name not in __all__:
        globals()[_name] = _function
        __all__.append(_name)
