"""The elasto-plastic law: LuGre's bristle, but purely elastic up to a deflection at which it begins to slip.

Under a force that changes below its break-away a LuGre contact creeps, a little each time; this one does not.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.equation import Scalar, equation, select
from plants.friction import directed, stribeck_level
from plants.laws import lugre
from plants.laws.interface import FrictionLaw
from plants.laws.lugre import Bristle


class Elasticity(NamedTuple):
    """Share of its steady deflection up to which a bristle is elastic. The default is this program's own choice."""

    elastic_share: Annotated[float, "1"] = 0.7


@equation
def slipping(bent: Scalar, elastic_share: Scalar) -> Scalar:
    """alpha, the share of slip: 0 up to z_ba = elastic_share z_ss, 1 from z_ss on, half a sine between.

    `bent` is |z| / z_ss. Dupont et al. 2002 with z_max = z_ss.
    """
    way = np.minimum(np.maximum((bent - elastic_share) / (1.0 - elastic_share), 0.0), 1.0)
    return 0.5 - 0.5 * np.cos(np.pi * way)


@equation
def friction(velocity: Scalar, contact: Bristle, held: Scalar, p: Any) -> tuple[Scalar, Bristle]:
    """Friction (N) and bristle rate (m/s).

        dz/dt = v - alpha |v| z / z_ss(v),   z_ss = g(v) / sigma0,   alpha = 0 where z and v have other signs
        F     = sigma0 z + sigma1 dz/dt + a2 v

    Dupont, Hayward, Armstrong and Altpeter 2002.
    """
    bristle = contact.bristle_deflection
    own = directed(velocity, bristle, p.friction)
    bent = bristle * own.bristle_stiffness / stribeck_level(velocity, own)
    alpha = select(velocity * bristle > 0.0, slipping(np.abs(bent), p.law.elastic_share), 0.0)
    rate = velocity - alpha * np.abs(velocity) * bent
    return own.bristle_stiffness * bristle + own.bristle_damping * rate + own.viscous * velocity, Bristle(rate)


ELASTO_PLASTIC = FrictionLaw(
    name="elasto_plastic",
    summary="LuGre's bristle, purely elastic up to a share of the deflection at which it slips: it does not creep",
    source="Dupont, Hayward, Armstrong and Altpeter 2002",
    friction=friction,
    steady=lugre.steady,
    Contact=Bristle,
    Extra=Elasticity,
)
