"""Plan a study: how many participants it needs, and its analysis, rehearsed with simulated answers."""

from emovid import confusion_table, plan_study, read_responses, simulate_responses

participants = plan_study(rate=0.5).n
print(f"{participants} participants show a hit rate of 50 %")
simulate_responses(participants, accuracy=0.5).to_csv("simulated.csv", index=False)
print(confusion_table(read_responses("simulated.csv")).to_string())
