"""The robot from above with its dimensions, as Fig. 1 shows the GRITSBot."""

import numpy as np
from matplotlib.figure import Figure

from emovid.figures.schematic import PALE, THIN, draw_arrow, draw_dimension, drawing, write_math
from emovid.figures.style import INK, SINGLE_COLUMN, in_style
from emovid.figures.top_view import draw_robots
from emovid.scene.robots import Body

_HIGHEST = 2.2  # of the page [in]


@in_style()
def robot_figure(body: Body, *, width: float = SINGLE_COLUMN) -> Figure:
    """Draw a robot with two wheels as the simulator knows it, facing right, with its dimensions and its axes.

    Args:
        body: of the robot; its lengths are what is written.
        width: of the figure [in].
    """
    assert body.wheels is not None  # it has two
    half, base, wheel = body.width / 2, body.wheel_base / 2, body.wheels.radius
    side = base + body.wheels.width / 2
    gap = 0.2 * body.width
    bounds = np.array([[-2.6 * half, -half - 2.2 * gap], [2.6 * half, side + 1.8 * gap]])
    figure, axes = drawing(bounds, width, _HIGHEST)
    draw_robots(axes, body, np.zeros((1, 3)), [PALE.body], PALE)
    for name, tip, beside in (("x", (1.3, 0), (1.3, 0.25)), ("y", (0, 0.72), (-0.2, 0.62))):
        draw_arrow(axes, np.zeros(2), half * np.array(tip), width=THIN)
        write_math(axes, half * np.array(beside), f"${name}$")
    axes.plot(0, 0, "o", color=INK, markersize=3, zorder=6)
    write_math(axes, half * np.array([-0.2, -0.2]), "$p$")
    lengths = (
        ((-half, -half), (half, -half), (0, -1.2 * gap), body.width),
        ((half, -half), (half, half), (0.85 * half, 0), body.width),
        ((-wheel, -base), (-wheel, base), (-1.35 * half, 0), body.wheel_base),
        ((-wheel, side), (wheel, side), (0, gap), 2 * wheel),
    )
    for one, other, offset, length in lengths:
        draw_dimension(axes, np.array(one), np.array(other), np.array(offset), f"{1000 * length:g} mm")
    return figure
