"""Figures as files, several at a time: the same bytes as one by one, and laid out for whoever looks at them after."""

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.publish.pictures import FORMATS, Picture, save, save_all
from workbench.publish.style import figure_style


def picture(number: int) -> Picture:
    with figure_style():
        figure = Figure()
        FigureCanvasAgg(figure)
        figure.subplots().plot([0.0, 1.0], [0.0, float(number)], label=f"curve {number}")
        figure.axes[0].set_ylabel("a label\nthat needs room")
    return Picture(figure, f"Number {number}.")


def test_several_at_a_time_are_the_same_bytes(tmp_path: Path) -> None:
    several = {f"figure_{k}": picture(k) for k in range(3)}
    save_all(several, tmp_path / "several")
    for k, (name, own) in enumerate(several.items()):
        alone = picture(k)
        for path in save(alone.figure, name, tmp_path / "alone", caption=alone.caption):
            assert (tmp_path / "several" / path.name).read_bytes() == path.read_bytes()
        places = [figure.axes[0].get_position().bounds for figure in (own.figure, alone.figure)]
        assert places[0] == places[1]
    assert len(list((tmp_path / "several").iterdir())) == len(several) * len(FORMATS)
