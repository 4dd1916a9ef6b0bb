"""The six fundamental emotions of the study.

Source: M. Santos and M. Egerstedt, "From Motions to Emotions: Can the Fundamental Emotions be Expressed in a Robot
Swarm?", Int. J. Social Robotics 2021, doi 10.1007/s12369-020-00665-6.
"""

from typing import Literal, NamedTuple, get_args

EmotionName = Literal["happiness", "surprise", "sadness", "fear", "disgust", "anger"]

PLATFORMS = ("robotarium", "robotarium-today")  # testbeds with their own six scenes, in folders of these names


class Emotion(NamedTuple):
    """One row of Table II, with the snapshot times [s] and the video of its figure."""

    name: EmotionName
    behaviour: str
    control: str
    snapshot_times: tuple[float, ...]
    video: str


EMOTIONS: dict[str, Emotion] = {
    emotion.name: emotion
    for emotion in (
        Emotion("happiness", "sinusoid over circle", "fast, smooth", (0, 1, 4), "https://youtu.be/q_FenI1DdRY"),
        Emotion("surprise", "expanding circle", "fast, smooth", (0, 1, 4), "https://youtu.be/VYIJ5hBeOIU"),
        Emotion("sadness", "small circle", "very slow, smooth", (0, 2, 8), "https://youtu.be/rfHZcFnRFg8"),
        Emotion("fear", "uniform coverage", "slow, angular", (0, 3, 15), "https://youtu.be/jz-5INUd8wc"),
        Emotion("disgust", "coverage on boundaries", "slow, angular", (0, 5, 12), "https://youtu.be/EprfuCsuuRM"),
        Emotion("anger", "coverage on center", "fast, angular", (0, 2, 6), "https://youtu.be/kAGBrMkOtyY"),
    )
}

assert tuple(EMOTIONS) == get_args(EmotionName)
