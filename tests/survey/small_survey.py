"""A study of six very small videos, for the survey's tests."""

STUDY = """\
title: Small robots
question: Which emotion best described the movement of the robots in the video?
labels: {happiness: Happiness, surprise: Surprise, anger: Anger, fear: Fear, disgust: Disgust, sadness: Sadness}
stimuli: [{scene: happiness}, {scene: surprise}, {scene: anger}, {scene: fear}, {scene: disgust}, {scene: sadness}]
set: {robots: 6}
choices: random
video: {size: 96x64, fps: 5, duration: 1}
demographics:
  - {name: gender, question: "What is your gender?", choices: [Woman, Man, Another gender]}
  - {name: country, question: "Where do you live?", required: false}
consent: {text: You can stop at any time., version: "1"}
instructions: Watch each video to its end.
thanks: {text: Thank you., code: C0MPLETE, link: "https://example.org/back?study=1&done=yes"}
"""
LABELS = ("happiness", "surprise", "anger", "fear", "disgust", "sadness")
