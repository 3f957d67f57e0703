"""Whether a design can use the table [design] of an experiment, before any record is read."""

from plants.effects.attach import possible
from workbench.design.asked import Asked, asked_of
from workbench.design.design import missing_before_records
from workbench.design.steering import steering_of
from workbench.errors import nearest
from workbench.publish.words import listed, plain_name
from workbench.records.experiment import Experiment
from workbench.toml import reading as files


def check_design(experiment: Experiment) -> str:
    """What [design] asks for, in words.

    Raises:
        UserError: the first mistake in it, with its place.
    """
    asked = asked_of(experiment)
    known = ["none", *(effect.name for effect in possible(experiment.plant))]
    for name in asked.between:
        if name not in known:
            said = f'plant {experiment.plant.name} has no effect "{name}"; {nearest(name, known)}'
            raise files.at(experiment.path, files.read_text(experiment.path), ("design", "between"), said)
    steering_of(experiment, asked)
    missing = missing_before_records(experiment, asked)
    return f"{_words(asked)}, once its records are there: {missing}" if missing else _words(asked)


def _words(asked: Asked) -> str:
    told = listed([plain_name(name) if name != "none" else "nothing missing" for name in asked.between], "or")
    shown = listed(list(asked.identify))
    wanted = [*([f"tells {told}"] if told else []), *([f"shows {shown}"] if shown else [])]
    return f"a motion of {asked.duration:g} s" + (f" that {' and '.join(wanted)}" if wanted else "")
