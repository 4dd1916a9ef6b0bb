"""Write docs/sensitivity.png and docs/sensitivity.md: descriptors against l and K around the shipped values."""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from emovid.figures.style import DOUBLE_COLUMN, EMOTION_COLOURS, in_style, save
from emovid.measure.describe import DESCRIPTORS, describe
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate

FACTORS = (0.25, 0.35, 0.5, 0.71, 1, 1.41, 2, 2.83, 4)
SEEDS = (1, 2, 3)
KEYS = ("l", "K")
SHOWN = ("speed_mean", "sharp_corner_share", "cusps_per_second", "turning_per_metre", "sparc", "cost_ratio")
MARKERS = dict(zip(EMOTIONS, "os^vDP", strict=True))


def measured(emotion: str, key: str, factor: float) -> list[float]:
    """Return the descriptors, averaged over seeds, with `key` of the robot multiplied by `factor`."""
    shipped = getattr(load_scene(emotion).robot, key)
    runs = []
    for seed in SEEDS:
        scene = load_scene(emotion, [Setting(f"robot.{key}", shipped * factor, key), Setting("seed", seed, "seed")])
        found = describe(simulate(scene))
        runs.append([found[name] for name in SHOWN])
    return np.mean(runs, axis=0).tolist()


@in_style()
def sensitivity_figure(values: dict[tuple[str, str], np.ndarray]) -> Figure:
    """Return the figure: one row per descriptor, one column per key, one line per emotion."""
    figure = Figure(figsize=(DOUBLE_COLUMN, 8.6), layout="constrained")
    axes = figure.subplots(len(SHOWN), len(KEYS), sharex="col", sharey="row")
    for (emotion, key), found in values.items():
        for row, ax in enumerate(axes[:, KEYS.index(key)]):
            colour, marker = EMOTION_COLOURS[emotion], MARKERS[emotion]
            ax.plot(FACTORS, found[:, row], color=colour, marker=marker, ms=3, lw=1, label=emotion)
    for row, name in enumerate(SHOWN):
        unit = DESCRIPTORS[name].unit
        axes[row, 0].set_ylabel(name.replace("_", " ") + (f"\n[{unit}]" if unit != "1" else ""))
        if name in ("speed_mean", "turning_per_metre", "cost_ratio"):
            axes[row, 0].set_yscale("log")
            axes[row, 0].yaxis.set_major_formatter("{x:g}")
            axes[row, 0].yaxis.set_minor_formatter("")
        for ax in axes[row]:
            ax.axvline(1, color="#b0b0b0", lw=0.6, zorder=0)
    for column, key in enumerate(KEYS):
        axes[-1, column].set_xscale("log", base=2)
        axes[-1, column].set_xticks([0.25, 0.5, 1, 2, 4], ["1/4", "1/2", "1", "2", "4"])
        axes[-1, column].minorticks_off()
        axes[-1, column].set_xlabel(f"{key} over its shipped value")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.align_ylabels(axes[:, 0])
    figure.legend(handles, labels, loc="outside upper center", ncols=len(EMOTIONS))
    return figure


def table(values: dict[tuple[str, str], np.ndarray]) -> str:
    """Return the same values as Markdown, at half, one and two times each key."""
    lines = ["| emotion | key | times | " + " | ".join(SHOWN) + " |", "|---" * (3 + len(SHOWN)) + "|"]
    for (emotion, key), found in values.items():
        for factor in (0.5, 1, 2):
            cells = ["" if np.isnan(value) else f"{value:.3g}" for value in found[FACTORS.index(factor)]]
            lines.append(f"| {emotion} | {key} | {factor:g} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main(folder: Path) -> None:
    """Sweep and write both files."""
    values = {
        (emotion, key): np.array([measured(emotion, key, factor) for factor in FACTORS])
        for emotion in EMOTIONS
        for key in KEYS
    }
    save(sensitivity_figure(values), folder / "sensitivity.png")
    (folder / "sensitivity.md").write_text(
        "Means over three seeds, to each emotion's last snapshot; made by `make sensitivity`.\n\n" + table(values)
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
