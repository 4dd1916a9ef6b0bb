"""The keys of `safety`: what keeps bodies apart and on the stage, besides the law itself."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from emovid.scene.fields import Keys, Length
from emovid.scene.robots import Robot

MAX_PERIOD = 0.04  # s; of a barrier that names none: robots' own control periods are about as long


class NoSafety(Keys):
    """The paper's study: nothing but what keeps bodies on the stage, and a coverage law's `separation`."""

    kind: Literal["none"] = Field("none", description="nothing changes a command but the edge of the stage")


class Barrier(Keys):
    """Control barrier certificates, for the paper's Sec. V: a quadratic program changes the commands that need it."""

    kind: Literal["barrier"] = Field(description="control barrier certificates for all pairs of robots and all walls")
    spacing: Length | None = Field(
        None,
        description="distance kept between two bodies' middles [m], half of it to a wall; null: bodies just apart",
    )
    gamma: Annotated[float, Field(gt=0, le=1000)] = Field(
        5.0, description="how fast robots may use up what is left beyond the spacing [1/s], at most 1 / period"
    )
    period: Annotated[float, Field(ge=1e-6, le=60)] | None = Field(
        None,
        description="how often it is solved [s], a whole number of times in a control period; null: the longest such "
        "part of at most 0.04 s",
    )


def _by_its_kind(keys: Any) -> Any:
    """Let a scene say `safety: barrier` for a group with that kind and the rest as by default."""
    return {"kind": keys} if isinstance(keys, str) else keys


Safety = Annotated[
    Annotated[NoSafety | Barrier, Field(discriminator="kind")],
    BeforeValidator(
        _by_its_kind,
        json_schema_input_type=Literal["none", "barrier"] | Annotated[NoSafety | Barrier, Field(discriminator="kind")],
    ),
]


def spacing_of(safety: Barrier, robot: Robot) -> float:
    """Return the distance D [m] that the barrier keeps between the middles of two bodies."""
    return 2 * robot.body.guarded[1] if safety.spacing is None else safety.spacing
