"""Read the answers of a study and print how well each emotion was recognized.

For answers to try it on: emovid study simulate -o responses.csv
"""

from emovid import analyze, read_responses

responses = read_responses("responses.csv")
results = analyze(responses)
for emotion, found in results.recognition.items():
    low, high = found.ci_low, found.ci_high
    print(f"{emotion}: {found.hits} of {found.n} hits, {low:.0%} to {high:.0%}, Holm p {found.p_holm:.2g}")
