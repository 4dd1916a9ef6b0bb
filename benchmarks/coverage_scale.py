"""Compare a coverage step with the Voronoi diagram of the same points alone, from 15 to 10 000 robots.

The points cover the stage evenly, or only a quarter of its width and height, like a swarm that starts in a region. The
diagram is the faster one of scipy's and shapely's (shapely only where it is installed; emovid does not need it). Runs
alternate; the ratios are medians.
"""

import time
from collections.abc import Callable
from statistics import median

import numpy as np
from scipy.spatial import Voronoi

from emovid.scene.behaviour import Coverage, Gaussian, Uniform
from emovid.scene.stage import Rectangle
from emovid.swarm.laws import coverage_velocity

try:
    import shapely
except ImportError:
    shapely = None

SIZES = (15, 150, 1500, 10_000)
STAGE = Rectangle(width=1.2, height=0.8)
LAWS = {
    "uniform": (Coverage(law="coverage", kappa=1.0, density=Uniform(kind="uniform")), 5),
    "gaussian": (Coverage(law="coverage", kappa=1.0, density=Gaussian(kind="gaussian", sigma=0.1)), 10),
}


def seconds(work: Callable[[], object], repeat: int) -> float:
    """Return the time of one run of `work` [s], from `repeat` in a row."""
    started = time.perf_counter()
    for _ in range(repeat):
        work()
    return (time.perf_counter() - started) / repeat


def row(points: np.ndarray) -> dict[str, float]:
    """Return the times [s] of each step and of the faster bare diagram, and the median ratios."""
    works: dict[str, Callable[[], object]] = {"scipy": lambda: Voronoi(points)}
    if shapely:
        geometry = shapely.multipoints(points)
        works["shapely"] = lambda: shapely.voronoi_polygons(geometry)
    works |= {name: lambda law=law: coverage_velocity(law, STAGE, points) for name, (law, _) in LAWS.items()}
    repeat = max(1, 2000 // len(points))
    for work in works.values():
        work()
    rounds = [{name: seconds(work, repeat) for name, work in works.items()} for _ in range(9)]
    times = {name: median(each[name] for each in rounds) for name in works}
    bare = "shapely" if shapely and times["shapely"] < times["scipy"] else "scipy"
    ratios = {f"{name} ratio": median(each[name] / each[bare] for each in rounds) for name in LAWS}
    return {"bare": times[bare], **{name: times[name] for name in LAWS}, **ratios}


def main() -> None:
    """Print one table for each arrangement of the points."""
    print(f"bare Voronoi diagrams: scipy{' and shapely' if shapely else '; shapely is not installed'}")
    rng = np.random.default_rng(0)
    for where, share in (("over the whole stage", 1.0), ("in a quarter of its width and height", 0.25)):
        print(f"\nrobots {where}; growth is the exponent of N since the row above")
        heads = (f"{name + ' ms':>12} {'ratio':>6} {'limit':>5} {'growth':>6}" for name in LAWS)
        print(f"{'N':>6} {'bare ms':>9}", *heads)
        before: dict[str, float] = {}
        for robots in SIZES:
            points = share * rng.uniform([-0.6, -0.4], [0.6, 0.4], (robots, 2))
            found = row(points)
            cells = []
            for name, (_, limit) in LAWS.items():
                growth = ""
                if before:
                    growth = f"{np.log(found[name] / before[name]) / np.log(robots / before['N']):.2f}"
                cells.append(f"{1000 * found[name]:12.3f} {found[f'{name} ratio']:6.1f} {limit:5d} {growth:>6}")
            print(f"{robots:6d} {1000 * found['bare']:9.3f}", *cells)
            before = found | {"N": robots}


if __name__ == "__main__":
    main()
