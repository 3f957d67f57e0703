"""The likelihood choice between two hypotheses by the generator's own equations: both are fitted to the same records.

Of each the machine's free parameters, where each record starts, and the numbers of its effect are found, by Gauss and
Newton's steps with the columns of where they begin: the machine as it is, the rival's effect as large as first order
says.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from family.forms import Form
from family.limits import LINEAR_SIZE, drawn_form, free_parameters, left
from family.machines import Rig, resting
from family.parameters import Machine
from family.physics import P1, P2, SHOWN, SPOOL, X, Z
from family.records import CHANNELS, Record, replayed, whitened

from design_proof.cases import NONE, Pair

STEPS, LEAST_GAIN = 8, 0.02
"""Of a fit, at most, and what one has to lower the squares by for another."""

ROUNDS = 2
"""Times that columns are found anew, where a fit has ended."""

SINGULAR = 1e-8
"""Share of the largest direction below which one is none."""

MOVED = 6.0
"""Standard deviations by which a difference quotient is to move a record."""

BEGINS = (X, Z, P1, P2, SPOOL)


@dataclass(frozen=True, eq=False)
class Model:
    """A machine with one effect or none: unknowns are shares of its free parameters, then the effect's strengths."""

    rig: Rig
    form: Form | None

    @property
    def names(self) -> tuple[str, ...]:
        """Free parameters of the machine."""
        return free_parameters(self.rig)

    @property
    def count(self) -> int:
        """Of its unknowns that all records share."""
        return len(self.names) + (len(self.form.columns) if self.form else 0)

    def machine(self, x: np.ndarray) -> Machine:
        """The machine with these unknowns, of parameters that do not vanish."""
        m, own = self.rig.machine, len(self.names)
        machine = m._replace(
            **{name: getattr(m, name) * float(np.exp(s)) for name, s in zip(self.names, x, strict=False)}
        )
        if self.form:
            for strength, column in zip(x[own:], self.form.columns.values(), strict=True):
                machine = machine._replace(**column(float(strength)))
        return machine

    def start(self, s: np.ndarray) -> np.ndarray:
        """The state in which a record starts, moved by shares of each state's size."""
        rig, state = self.rig, resting(self.rig.machine)
        sizes = [rig.travel, rig.presliding, *([rig.machine.supply_pressure] * 2), rig.machine.spool_limit]
        for place, size, share in zip(BEGINS, sizes, s, strict=False):
            state[place] += share * size
        state[SHOWN] = state[X]
        return state

    @property
    def begins(self) -> int:
        """States that may start elsewhere."""
        return len(BEGINS) if self.rig.is_fluid else 2


def shown(of: Record) -> np.ndarray:
    """What a record shows, with its noise, as independent standard deviations."""
    table = np.zeros_like(of.clean)
    for name in of.rig.noises:
        table[:, CHANNELS.index(name)] = of.channels[name]
    return whitened(of, table)


def foreseen(of: Record, model: Model, x: np.ndarray, begins: np.ndarray) -> np.ndarray:
    """What a model shows under a record's command."""
    return whitened(of, replayed(of, model.machine(x), model.start(begins)))


def _column(shows, base: np.ndarray, size: float) -> tuple[np.ndarray, float]:
    """A difference quotient over a step that moves a record by neither too little nor too much, and the step."""
    moved = shows(size) - base
    for _ in range(5):
        length = float(np.linalg.norm(moved)) if np.all(np.isfinite(moved)) else 1e6
        if LINEAR_SIZE[0] <= length <= LINEAR_SIZE[1] or (size >= 0.5 and length < LINEAR_SIZE[0]):
            break
        size = min(size * MOVED / length if length > 0.0 else 1e3 * size, 0.5)
        moved = shows(size) - base
    return (moved / size if np.all(np.isfinite(moved)) else np.zeros_like(base)), size


@dataclass(frozen=True, eq=False)
class Linear:
    """A model about some unknowns along a record: what it shows there, and columns of unknowns and starts."""

    base: np.ndarray
    columns: np.ndarray
    starts: np.ndarray


def linear(of: Record, model: Model, x: np.ndarray) -> Linear:
    """A model along a record."""
    nothing = np.zeros(model.begins)
    base = foreseen(of, model, x, nothing)
    columns = [
        _column(lambda s, k=k: foreseen(of, model, x + s * np.eye(model.count)[k], nothing), base, 1e-4)[0]
        for k in range(model.count)
    ]
    starts = [
        _column(lambda s, k=k: foreseen(of, model, x, s * np.eye(model.begins)[k]), base, 1e-5)[0]
        for k in range(model.begins)
    ]
    return Linear(base, np.column_stack(columns), np.column_stack(starts))


def _side_by_side(about: Sequence[Linear]) -> np.ndarray:
    """The columns along several records: those of unknowns, which all share, then of where each starts."""
    starts = [np.zeros((one.base.size, other.starts.shape[1])) for one in about for other in about]
    count = len(about)
    blocks = [[one.columns, *starts[k * count : (k + 1) * count]] for k, one in enumerate(about)]
    for k, one in enumerate(about):
        blocks[k][1 + k] = one.starts
    return np.block(blocks)


def fitted(
    records: Sequence[Record], seen: Sequence[np.ndarray], model: Model, x: np.ndarray, about: Sequence[Linear]
) -> tuple[np.ndarray, float]:
    """The unknowns at their best, and the squares that a model leaves of records that show `seen`, from x on."""
    count, begins = model.count, model.begins
    whole = _side_by_side(about)
    sizes = np.linalg.norm(whole, axis=0)
    used = sizes > 0.0
    unit = whole[:, used] / sizes[used]
    backward = np.zeros((whole.shape[1], whole.shape[0]))
    backward[used] = np.linalg.pinv(unit, rcond=SINGULAR) / sizes[used][:, None]

    def left_at(place: np.ndarray) -> np.ndarray:
        parts = [
            seen[k] - foreseen(of, model, place[:count], place[count + k * begins : count + (k + 1) * begins])
            for k, of in enumerate(records)
        ]
        return np.nan_to_num(np.concatenate(parts), nan=1e6, posinf=1e6, neginf=-1e6)

    place = np.concatenate([x, np.zeros(begins * len(about))])
    residual = left_at(place)
    least = float(residual @ residual)
    for _ in range(STEPS):
        step, lower = backward @ residual, False
        for share in (1.0, 0.3):
            other = left_at(place + share * step)
            squares = float(other @ other)
            if squares < least:
                lower = least - squares > LEAST_GAIN
                place, residual, least = place + share * step, other, squares
                break
        if not lower:
            break
    return place[:count], least


def models_of(pair: Pair, rig: Rig) -> tuple[tuple[Model, np.ndarray], tuple[Model, np.ndarray]]:
    """The true model and its rival's, each with where a fit begins."""
    acting = pair.made.effects[pair.true]
    true = Model(rig, acting.form)
    own = np.zeros(len(true.names))
    strengths = [acting.strength * acting.form.weights.get(name, 0.0) for name in acting.form.columns]
    rival = Model(rig, None if pair.rival == NONE else drawn_form(rig, pair.rival))
    return (true, np.concatenate([own, strengths])), (rival, np.zeros(rival.count))


def expected(pair: Pair, records: Sequence[Record]) -> float:
    """What `difference` is on the average over the sensors' noise, to first order in the rival's unknowns."""
    _, (model, x) = models_of(pair, records[0].rig)
    about = [linear(of, model, x) for of in records]
    apart = np.concatenate([whitened(of, of.clean) - one.base for of, one in zip(records, about, strict=True)])
    return left(apart, list(_side_by_side(about).T)) ** 2


def difference(pair: Pair, records: Sequence[Record]) -> float:
    """S_rival - S_true over all records: twice the logarithm of the odds for the truth."""
    rig = records[0].rig
    seen, squares = [shown(of) for of in records], []
    for model, x in models_of(pair, rig):
        for _ in range(ROUNDS):
            x, least = fitted(records, seen, model, x, [linear(of, model, x) for of in records])
        squares.append(least)
    if pair.rival == NONE:  # the true model can do all that the machine without its effect does
        squares[0] = min(squares)
    return squares[1] - squares[0]
