"""Measure how two emotions move."""

from emovid import describe, load_scene, simulate

happiness, anger = (describe(simulate(load_scene(emotion))) for emotion in ("happiness", "anger"))
for descriptor in ("speed_mean", "turning_per_metre", "radius_of_gyration_mean"):
    print(f"{descriptor}: happiness {happiness[descriptor]:.3g}, anger {anger[descriptor]:.3g}")
