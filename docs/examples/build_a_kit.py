"""Build the kit of a study for twelve participants, the same again from the same seed.

For a study to try it on: emovid study new .
"""

from emovid import build_kit

kit = build_kit("study.yaml", "kit", participants=12, seed=5)
print(f"{kit.folder}: {len(kit.codes)} videos, {kit.participants} orders")
