"""The circumplex of affect: where emotions lie on the circle of valence and arousal."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

# Degrees from pleasure (0) through arousal (90) to displeasure (180) of the words happy, astonished, angry, afraid and
# sad as J. Russell, "A circumplex model of affect", J. Personality and Social Psychology 39, 1980, scaled them with the
# method of R. Ross, "A statistic for circular series", J. Educational Psychology 29, 1938. Russell scaled no word for
# disgust; it stands at his "distressed", between fear and sadness, where the paper has it: Table III lists the emotions
# counterclockwise in this order.
ANGLES = {"happiness": 7.8, "surprise": 69.8, "anger": 99.0, "fear": 116.0, "disgust": 138.0, "sadness": 207.5}
# The right half: positive valence, as in the paper (its footnote on valence, after Frijda 1986).
VALENCE = {emotion: bool(np.cos(np.radians(angle)) > 0) for emotion, angle in ANGLES.items()}
# The upper half: high arousal. Happiness lies just above the middle, so the choice matters most for it.
AROUSAL = {emotion: bool(np.sin(np.radians(angle)) > 0) for emotion, angle in ANGLES.items()}


def distances(labels: Sequence[str]) -> NDArray[np.float64]:
    """Return the angles (labels, labels) [degrees] between emotions, from 0 to 180, NaN where one has no place."""
    angles = np.array([ANGLES.get(label, np.nan) for label in labels])
    apart = np.abs(angles[:, None] - angles)
    return np.minimum(apart, 360 - apart)
