"""Render an emotion as a video, half as long and with another seed."""

from emovid import load_scene, render_video, simulate

scene = load_scene("anger", {"duration": 7.5, "seed": 3})
trajectory = simulate(scene)
render_video(trajectory, "anger.mp4")
print(f"anger.mp4: {scene.frames} frames of {scene.robots} robots")
