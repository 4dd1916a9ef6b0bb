"""Show the effect of the look-ahead distance l on the traces of anger: small is angular, large is smooth."""

from emovid import describe, load_scene, simulate

for l in (0.004, 0.0125, 0.04):  # m
    found = describe(simulate(load_scene("anger", {"robot.l": l, "duration": 6.0})))
    print(f"l = {l:.4f} m: traces turn {found['turning_per_metre']:.0f} rad per meter")
