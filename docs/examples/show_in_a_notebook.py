"""Show a looping video in a notebook: the last line of the cell displays the player."""

from emovid import load_scene, show, simulate

show(simulate(load_scene("sadness", {"video.theme": "dark"})))
