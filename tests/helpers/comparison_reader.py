"""Derives the sentences about one cell of a comparison again from its rows."""

import re
from collections.abc import Callable

import numpy as np
from comparison_rows import CANDIDATE, MARGIN, PRESSURE, SIZED, WORD, Key, Rows, class_of, interval, same

from workbench.metrics.statistics import share_interval

SIDES = {
    "nothing": "plain at rest",
    "compensate": "compensation at rest",
    "avoid": "rotation",
    "both": "compensation with rotation",
}
WATTS = r"([\d.]+) (k?)W"


class Reader:
    """Derives the sentences about one cell again."""

    def __init__(self, rows: Rows, cell: Key) -> None:
        self.rows, self.cell = rows, cell

    def who(self, name: str, rpm: str | None, real: str | None = None) -> tuple[str, float]:
        """The candidate that is named; its real speed is told exactly where it is another."""
        candidate = (name.replace(" ", "_"), float(rpm or 0.0))
        turned = self.rows.of(self.rows.fresh, self.cell, *candidate)["rotation_speed_mean_rpm"].mean()
        off = candidate[1] > 0 and abs(turned - candidate[1]) > 0.02 * candidate[1]
        assert bool(real) == off
        assert real is None or same(real, turned)
        return candidate

    def sized(self, groups: tuple[str, ...]) -> tuple[str, float]:
        """A candidate with its error and interval."""
        name, rpm, real, mean, low, high = groups
        candidate = self.who(name, rpm, real)
        errors = 1e3 * self.rows.errors(self.rows.fresh, self.cell, *candidate)
        assert same(mean, errors.mean())
        for text, value in zip((low, high), interval(errors), strict=True):
            assert same(text, value)
        return candidate

    def margin(self, first: tuple[str, float], second: tuple[str, float], groups: tuple[str, ...], pairs: int) -> None:
        """Ratio and difference with their intervals."""
        a, b = (self.rows.errors(self.rows.fresh, self.cell, *who) for who in (first, second))
        ratio, *ends, difference, low, high, _ = groups
        assert same(ratio, float(np.exp(np.mean(np.log(b / a)))))
        for text, value in zip(ends, np.exp(interval(np.log(b / a), pairs)), strict=True):
            assert same(text, float(value))
        assert same(difference, 1e3 * float(np.mean(b - a)))
        for text, value in zip((low, high), interval(1e3 * (b - a), pairs), strict=True):
            assert same(text, value)

    def verdict(self, *groups: str) -> None:
        kind, *rest = groups
        assert kind.lower() == self.rows.kind(self.cell)
        named, rival = self.sized(tuple(rest[:6])), self.sized(tuple(rest[7:13]))
        assert rest[6] == self.rows.word(self.cell, named, rival)
        held = self.rows.stands(self.cell)
        assert held[class_of(*named)] == named
        assert held[class_of(*rival)] == rival
        self.margin(named, rival, tuple(rest[13:]), 6)
        if kind in ("Compensate", "Avoid", "Both"):
            assert class_of(*named) == kind.lower()
            assert rest[6] == "beats"

    def rarely(self, strictly: str, otherwise: str, *groups: str) -> None:
        assert (strictly, otherwise) == self.rows.both_ways(self.cell)
        assert strictly != otherwise
        candidate = self.sized(groups[:6])
        assert list(self.rows.rare(self.cell).values()) == [candidate]
        count, draws = self.rows.hunting(self.cell, *candidate)
        assert groups[6:8] == (str(count), str(draws))
        for text, value in zip(groups[8:], share_interval(count, draws), strict=True):
            assert same(text, 100.0 * value)

    def in_front(self, side: str, *groups: str) -> None:
        candidate = self.sized(groups[:6])
        assert self.rows.rare(self.cell)[class_of(*candidate)] == candidate
        assert SIDES[class_of(*candidate)] == side
        assert groups[6:8] == tuple(map(str, self.rows.hunting(self.cell, *candidate)))
        assert len(set(self.rows.both_ways(self.cell))) == 1

    def against(self, *groups: str) -> None:
        bare, rest = self.sized(groups[:6]), groups[6]
        held = self.rows.stands(self.cell)
        assert held["nothing"] == bare
        told = {}
        for part in rest.split("; "):
            side, name, rpm, real, word = re.fullmatch(rf"([a-z ]+), {CANDIDATE}, {WORD} it", part).groups()
            candidate = self.who(name, rpm, real)
            assert word == self.rows.word(self.cell, candidate, bare)
            told[side] = candidate
        assert told == {SIDES[kind]: candidate for kind, candidate in held.items() if kind != "nothing"}

    def together(self, *groups: str) -> None:
        both, (word, sign, paid, kilo), rest = self.sized(groups[:6]), groups[6:10], groups[10:]
        held = self.rows.stands(self.cell)
        named = held[self.rows.kind(self.cell)]
        assert (held["both"], word) == (both, self.rows.word(self.cell, both, named))
        cost = [self.rows.of(self.rows.fresh, self.cell, *who)["paid_power_W"].mean() for who in (both, named)]
        assert same(f"{sign}{paid}", (cost[0] - cost[1]) / (1e3 if kilo else 1.0), 2)
        self.margin(both, named, rest, 6)

    def price(self, *groups: str) -> None:
        name, rpm, real, motor, mk, loss, lk, paid, pk, pump, uk, still, sk, other, other_rpm, _, torque = groups
        rows = self.rows.of(self.rows.fresh, self.cell, *self.who(name, rpm, real))
        rest = self.rows.of(self.rows.fresh, self.cell, *self.who(other, other_rpm))
        for text, kilo, column, part in (
            (motor, mk, "motor_electric_power_W", rows),
            (loss, lk, "motor_loss_W", rows),
            (paid, pk, "paid_power_W", rows),
            (pump, uk, "supply_power_W", rows),
            (still, sk, "supply_power_W", rest),
        ):
            assert same(text, part[column].mean() / (1e3 if kilo else 1.0), 2)
        mean = rows["motor_torque_rms_N_m"].mean()
        assert (torque is not None) == (mean > 8.0)
        assert torque is None or same(torque, mean, 2)

    def cheapest(self, *groups: str) -> None:
        candidate = self.sized(groups[:6])
        held = self.rows.stands(self.cell)["both" if self.rows.kind(self.cell) == "both" else "avoid"]
        assert self.rows.word(self.cell, candidate, held, 1) in ("is level with", "beats")
        paid = [self.rows.of(self.rows.fresh, self.cell, *who)["paid_power_W"].mean() for who in (candidate, held)]
        assert paid[0] < paid[1]

    def model(self, *groups: str) -> None:
        start, *rest = groups
        pressure, model, word = self.sized(tuple(rest[:6])), self.sized(tuple(rest[7:13])), rest[6]
        ranked = self.rows.ranked(self.cell, "compensate")
        assert pressure == next(candidate for candidate in ranked if candidate[0] in PRESSURE)
        assert model == next(candidate for candidate in ranked if candidate[0] not in PRESSURE)
        assert word == self.rows.word(self.cell, pressure, model, 1)
        needed = {"loses to": "A friction model is worth having", "cannot be told from": "Whether a friction model"}
        assert start.startswith(needed.get(word, "No friction model is needed"))
        self.margin(pressure, model, tuple(rest[13:]), 1)

    def within(self, *groups: str) -> None:
        candidate = self.sized(groups[1:])
        assert self.rows.stands(self.cell)["nothing"] == candidate
        assert interval(self.rows.errors(self.rows.fresh, self.cell, *candidate))[1] <= 1e-6

    def flawed(self, side: str, name: str, rpm: str | None, real: str | None, count: str, draws: str) -> None:
        kind = next(kind for kind, called in SIDES.items() if called == side)
        assert kind not in self.rows.stands(self.cell)
        assert (int(count), int(draws)) == self.rows.hunting(self.cell, *self.who(name, rpm, real))

    def read(self, sentence: str) -> None:
        """Find the derivation of a sentence and try it."""
        price = (
            rf"{WATTS} at the motor's terminals, {WATTS} of it lost before the rod; {WATTS} paid with the pump; the "
            rf"pump {WATTS}, against {WATTS} for {CANDIDATE}(?:; ([\d.]+) N m rms, above the nominal 8 N m)?\."
        )
        forms: dict[str, Callable[..., None]] = {
            rf"(Compensate|Avoid|Both|Level|Nothing needed|Cannot be told): {SIZED}, {WORD} {SIZED}: {MARGIN}\.": (
                self.verdict
            ),
            r"Cannot be told: ([a-z ]+) without what hunts on any draw, ([a-z ]+) with what hunts rarely: "
            rf"{SIZED}, hunts at a standstill on (\d+) of (\d+) draws, so on ([\d.]+) to ([\d.]+) % of such "
            r"machines\.": (self.rarely),
            rf"Of ([a-z ]+), {SIZED}, would stand in front, but hunts at a standstill on (\d+) of (\d+) draws, so on "
            r"[\d.]+ to [\d.]+ % of such machines\.": self.in_front,
            rf"Against {SIZED}: (.*)\.": self.against,
            rf"Both together, {SIZED}, {WORD} it, at ([+-]){WATTS} paid: {MARGIN}\.": self.together,
            rf"Price of {CANDIDATE}: {price}": self.price,
            rf"Level with it, the cheapest is {SIZED}: .*\.": self.cheapest,
            rf"(No friction model is needed|A friction model is worth having|Whether a friction model is needed cannot "
            rf"be told): measured load pressure without one, {SIZED}, {WORD} the best with one, {SIZED}: {MARGIN}\.": (
                self.model
            ),
            rf"(Nothing needed): {SIZED}, is within 0\.001 mm\.": self.within,
            rf"No candidate of ([a-z ]+) holds: hunts \(least often {CANDIDATE}, on (\d+) of (\d+) draws\)\.": (
                self.flawed
            ),
        }
        for form, derived in forms.items():
            if match := re.fullmatch(form, sentence):
                derived(*match.groups())
                return
        raise AssertionError(f"no derivation of: {sentence}")
