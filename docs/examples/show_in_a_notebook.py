"""In a notebook, the last line of this cell plays the video under it, again and again."""

from emovid import load_scene, show, simulate

show(simulate(load_scene("sadness", {"video.theme": "dark"})))
