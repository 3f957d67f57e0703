"""What repeats, by the amplitudes of its cosine and its sine."""

import numpy as np

from plants.equation import Scalar, equation, when


@equation
def wave(cosine: Scalar, sine: Scalar, angle: Scalar) -> Scalar:
    """a cos(angle) + b sin(angle) in the unit of the amplitudes, the angle in rad; not computed where both are 0."""
    return when(np.abs(cosine) + np.abs(sine) != 0.0, _swinging, 0.0, cosine, sine, angle)


@equation
def _swinging(cosine: Scalar, sine: Scalar, angle: Scalar) -> Scalar:
    return cosine * np.cos(angle) + sine * np.sin(angle)
