"""What people call channels, in words: English, German, French, Italian, Spanish, and their abbreviations."""

import re
from collections.abc import Mapping


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


WORDS: Mapping[str, frozenset[str]] = {
    "time": _set("t time zeit temps tempo tiempo timestamp stamp clock elapsed xvalue xaxis uhrzeit"),
    "position": _set(
        "x y s q pos position weg hub stroke lage qm xm displacement verschiebung deplacement course posizione corsa "
        "spostamento posicion desplazamiento angle winkel theta phi angolo angulo encoder lvdt joint"
    ),
    "velocity": _set("v vel velocity speed geschwindigkeit vitesse velocita velocidad omega qd dq xd dx drehzahl"),
    "acceleration": _set("acc accel acceleration beschleunigung accelerazione aceleracion qdd"),
    "command": _set(
        "u vir cmd command control ctrl stellgroesse stellgröße stellsignal output voltage spannung tension tensione "
        "commande comando mando dac uc effort drive"
    ),
    "valve_voltage": _set("valve ventil servovalve servoventil valvola valvula vanne uv spool schieber"),
    "pump_speed": _set("pump pumpe pompe pompa bomba"),
    "pressure_1": _set("pa p1 pressurea druckea drucka pcap cap bore kolbenseite bodenseite pressa"),
    "pressure_2": _set("pb p2 pressureb druckb prod rodside stangenseite ringseite pressb"),
    "supply_pressure": _set("ps supply psup versorgung psupply alimentation alimentazione"),
    "force": _set("f force kraft forza fuerza effortf load loadcell kraftmessdose fm last"),
    "torque": _set("torque moment drehmoment couple coppia tau trq par mom"),
    "motor_current": _set("i current strom courant corrente corriente iq imot motorcurrent"),
}
"""Words by channel; a name is cut into words at anything that is no letter, at capitals and at digits."""

PRESSURE = _set("p pressure druck pression pressione presion press")
"""A pressure of one side or the other."""

SIDES: Mapping[str, frozenset[str]] = {
    "pressure_1": frozenset(("a", "1", "cap", "bore", "kolben", "head")),
    "pressure_2": frozenset(("b", "2", "rod", "stange", "ring")),
    "supply_pressure": frozenset(("s", "0", "sup", "supply", "versorgung", "source")),
}

REFERENCE = _set(
    "ref reference soll sollwert set setpoint sp des desired target demand consigne riferimento referencia wanted qg "
    "xd xref wsoll w traj trajectory plan"
)
"""Words of what was wanted and not measured."""

MEASURED = _set("ist actual act meas measured istwert mesure misurata medida fb feedback m")


COMMANDED = _set("cmd command commanded befehl commande comando")
"""Words by which a force, a torque or a current is what the axis was told, and no sensor's."""

MOST_WORDS = 40
"""Of a name, that are looked at."""


def words_of(name: str) -> list[str]:
    """A name in its words, in small letters: "ValvePos_mm2" is valve, pos, mm, 2."""
    spaced = re.sub(r"(?<=[a-zäöüß])(?=[A-Z])", " ", name)
    found = re.findall(r"[a-zäöüßéèàóò]+|\d+", spaced.lower())
    whole = re.sub(r"[^a-z0-9äöüß]", "", name.lower())
    return list(dict.fromkeys([*[*dict.fromkeys(found)][:MOST_WORDS], whole]))


def is_reference(name: str) -> bool:
    """Whether a column is what was wanted, not what was."""
    return any(word in REFERENCE for word in words_of(name)) and not any(word in MEASURED for word in words_of(name))


def scores(name: str) -> dict[str, float]:
    """How well a column's name is that of each channel: by its words, or by those behind the last dot of a struct's or
    a message's field.
    """
    whole, last = _scores(name), _scores(name.rsplit(".", 1)[-1])
    return {channel: max(whole.get(channel, 0.0), last.get(channel, 0.0)) for channel in {**whole, **last}}


def _scores(name: str) -> dict[str, float]:
    """The share of a name's words that are a channel's; one more where all of it is."""
    words = words_of(name)
    found: dict[str, float] = {}
    for channel, known in WORDS.items():
        hits = [word for word in words if word in known or any(_longer(word, each) for each in known)]
        if hits:
            found[channel] = len(hits) / len(words) + (words[-1] in hits)
    if PRESSURE & set(words) or any(word.startswith(("press", "druck")) for word in words):
        for channel, sides in SIDES.items():
            if sides & set(words):
                found[channel] = found.get(channel, 0.0) + 2.0
        if not any(channel in found for channel in SIDES):
            found["pressure_1"] = 1.0
    if COMMANDED & set(words) and not MEASURED & set(words) and {"force", "torque", "motor_current"} & set(found):
        found["command"] = found.get("command", 0.0) + 2.0
    for strong in ("valve_voltage", "pump_speed"):  # a pump's speed, a valve's command
        if strong in found:
            found[strong] += 1.0
    return found


def _longer(word: str, known: str) -> bool:
    """Whether a word contains a long known one: "ventilspannung", "weggeber"."""
    return len(known) >= 4 and known in word
