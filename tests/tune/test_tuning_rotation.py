"""Tuning the rotation beside the gains: its speed, or the threshold of a scheduled one, where power has its price."""

from pathlib import Path

import numpy as np
from command import write
from tuned_study import STUDY, tuned

from workbench.toml.gain_file import gain_file_text, read_gain_file
from workbench.tune.report.gain_files import gain_file


def test_the_rotation_is_tuned_beside_the_gains(tmp_path: Path) -> None:
    """Power has its price: with weight on it the rod turns slowly, with none as fast as helps."""
    turning = (
        '[tune.gains.p]\nkp = { min = "499 V/m", max = "501 V/m" }\n'
        '[tune.rotation]\nrpm = { min = "5 rpm", max = "120 rpm" }\n'
        "[tune.objective]\nelectric_power = WEIGHT\n"
    )
    text = (
        STUDY.replace('model = "non_rotating"', 'model = "rotating"\nbristle = "isotropic"')
        .replace("[axes]\n", "[axes]\nrpm = [10]\n")
        .replace("[tune.objective]\n", turning)
    )
    dear, free = (
        tuned(tmp_path / weight, text.replace("WEIGHT", weight), "p", trials=12).tuned[0] for weight in ("1", "0")
    )
    assert dear.best is not None
    assert free.best is not None
    assert dear.best["rpm"] < 0.5 * free.best["rpm"]
    assert read_gain_file(write(tmp_path, gain_file_text(gain_file([free])), "free.toml")).at[0].rotation["rpm"] == (
        f"{free.best['rpm'] * 30.0 / np.pi:.12g} rpm"
    )


def test_the_threshold_of_a_scheduled_rotation_is_tuned(tmp_path: Path) -> None:
    """Power alone counts: the less the rod is made to slide, the less it takes."""
    text = (
        STUDY.replace('model = "non_rotating"', 'model = "rotating"\nbristle = "isotropic"\nrotation = "scheduled"')
        .replace("[axes]\n", "[axes]\nrpm = [25]\n")
        .replace("rms_error = 1", "power = 1")
        .replace(
            "[tune.objective]\n",
            '[tune.gains.p]\nkp = { min = "499 V/m", max = "501 V/m" }\n'
            '[tune.rotation]\nminimum_helical_speed = { min = "5 mm/s", max = "60 mm/s" }\n[tune.objective]\n',
        )
    )
    result = tuned(tmp_path, text, "p", trials=12, jobs=2).tuned[0]
    assert result.best is not None
    judged = [trial for trial in result.trials if trial.feasible]
    thresholds = [trial.point["minimum_helical_speed"] for trial in judged]
    assert max(thresholds) > 2.0 * min(thresholds)
    assert result.best["minimum_helical_speed"] == min(thresholds)
    kept = read_gain_file(write(tmp_path, gain_file_text(gain_file([result])), "p.toml"))
    assert kept.at[0].rotation == {"minimum_helical_speed": f"{result.best['minimum_helical_speed']:.12g} m/s"}
