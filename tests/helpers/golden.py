"""Golden images: a small image of each figure of the catalog, as last accepted by a person.

Coverage is chaotic: its runs, and therefore its figures, differ from machine to machine and could not be
compared. Its runs are stored with the images, and figures are drawn from them. Everything else is computed each time.

Usage: python -m tests.helpers.golden (make golden)
"""

from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import uniform_filter

from emovid.figures.catalogue import CATALOGUE, MEASURES, STUDY, Entry
from emovid.figures.run_cache import Material
from emovid.scene.behaviour import Coverage
from emovid.scene.model import Scene
from emovid.swarm.files import load_trajectory, save_trajectory
from emovid.swarm.trajectory import Trajectory
from emovid.workflows.figures import measures_of, study_results

FOLDER = Path(__file__).parents[1] / "golden"
SMALLER = 4  # times, than 300 dots per inch
WINDOW = 2  # pixels: a difference is the mean over so many by so many
TOLERANCE = 48.0  # of 255: rounding, and even a shift by a dot, stay below; a wrong digit exceeds it (76)
CUT = 16.0  # s: of testbeds' runs, whose digits stay the same for longer (to 1e-6 m), though they are too long to store


class GoldenMaterial(Material):
    """Inputs of figures that are the same on every machine.

    Args:
        fresh: whether to simulate the stored runs again.
    """

    def __init__(self, *, fresh: bool = False) -> None:
        super().__init__(tables={STUDY: lambda _: study_results(None), MEASURES: measures_of})
        self._fresh = fresh

    def scene(self, name: str) -> Scene:
        scene = super().scene(name)
        return scene.model_copy(update={"duration": CUT, "snapshots": (CUT,)}) if of_testbed(name) else scene

    def run(self, name: str) -> Trajectory:
        if name not in self._runs and self.is_stored(name):
            if self._fresh:
                save_trajectory(super().run(name), stored_run(name))
            else:
                self._runs[name] = load_trajectory(stored_run(name))
        return super().run(name)

    def is_stored(self, name: str) -> bool:
        return isinstance(self.scene(name).behaviour, Coverage) and not of_testbed(name)


def of_testbed(name: str) -> bool:
    return "/" in name


def stored_run(name: str) -> Path:
    return FOLDER / f"{name}.npz"


def image_of(name: str) -> Path:
    return FOLDER / f"{name}.png"


def small(entry: Entry, material: Material) -> np.ndarray:
    """Return a figure as (height, width, 3) RGB, averaged from its PNG."""
    (png,) = entry.files(material, ["png"])
    return np.asarray(Image.open(BytesIO(png)).convert("RGB").reduce(SMALLER))


def differences(drawn: np.ndarray, golden: np.ndarray) -> np.ndarray:
    """Return the difference in brightness between windows of two pictures (height, width, 3)."""
    return uniform_filter(drawn.astype(float) - golden.astype(float), (WINDOW, WINDOW, 0), mode="nearest")


def difference_picture(drawn: np.ndarray, golden: np.ndarray) -> Image.Image:
    """Return both pictures and, below, their difference: white for none, darker for more."""
    height, width = (max(sides) for sides in zip(drawn.shape[:2], golden.shape[:2], strict=True))
    both = [np.full((height, width, 3), 255, np.uint8) for _ in range(2)]
    for page, picture in zip(both, (drawn, golden), strict=True):
        page[: picture.shape[0], : picture.shape[1]] = picture
    off = np.abs(both[0].astype(int) - both[1])
    return Image.fromarray(np.concatenate([*both, (255 - np.minimum(4 * off, 255)).astype(np.uint8)]))


def make() -> None:
    """Make all images and the stored runs again."""
    FOLDER.mkdir(exist_ok=True)
    for old in [*FOLDER.glob("*.png"), *FOLDER.glob("*.npz")]:
        old.unlink()
    material = GoldenMaterial(fresh=True)
    for entry in CATALOGUE.values():
        if entry.draw is None:
            continue
        Image.fromarray(small(entry, material)).save(image_of(entry.name), optimize=True)
        print(image_of(entry.name).relative_to(FOLDER.parent))


if __name__ == "__main__":
    make()
