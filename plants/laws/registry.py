"""The friction laws by name: ours, and those that other packages bring by entry point."""

from plants.equation import fields, unmarked
from plants.laws.dahl import DAHL
from plants.laws.elasto_plastic import ELASTO_PLASTIC
from plants.laws.interface import FrictionLaw
from plants.laws.lugre import LUGRE
from plants.laws.maxwell_slip import GMS
from plants.laws.without_memory import COULOMB, STRIBECK
from plants.plugins import Registry

_OURS = (LUGRE, COULOMB, STRIBECK, DAHL, ELASTO_PLASTIC, GMS)


def _check(law: FrictionLaw) -> None:
    if mistake := unmarked((law.friction,)):
        raise TypeError(mistake)
    for cls in (law.Contact, law.Extra):
        try:
            fields(cls)
        except (AttributeError, TypeError):
            raise TypeError(f"{cls.__name__}: expected a NamedTuple of Annotated[float, unit]") from None


LAWS = Registry("friction_workbench.friction_laws", FrictionLaw, {law.name: law for law in _OURS}, _check)
