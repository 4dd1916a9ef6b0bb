"""Give fear another density: a small crowd on the left of the stage and a wide one on the right."""

from emovid import load_scene, render_video, simulate

crowds = {
    "kind": "sum",
    "parts": [
        {"weight": 4.0, "density": {"kind": "gaussian", "centre": {"x": -0.3, "y": 0.0}, "sigma": 0.06}},
        {"weight": 1.0, "density": {"kind": "gaussian", "centre": {"x": 0.25, "y": 0.0}, "sigma": 0.12}},
    ],
}
look = {"video.overlays.density": True, "video.size": "640x360"}
trajectory = simulate(load_scene("fear", {"behaviour.density": crowds, **look}))
render_video(trajectory, "two_crowds.mp4")

left = int((trajectory.poses[-1, :, 0] < 0).sum())
print(f"two_crowds.mp4: {left} robots end on the left, {15 - left} on the right")
