"""Write the tables of docs/claims.md between its markers: claims with reasons, and the claims each mutant breaks."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from emovid.measure.claim_metrics import claim_metrics
from emovid.measure.claims import CLAIMS
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene
from emovid.swarm.simulate import simulate
from tests.helpers.mutants import MUTANTS, broken_claims


def claims_table() -> str:
    """Return a row for each claim."""
    rows = ["| claim | source | reason for the bound |", "|---|---|---|"]
    return "\n".join([*rows, *(f"| {claim.text} | {claim.source} | {claim.reason} |" for claim in CLAIMS)])


def mutants_table() -> str:
    """Return a row for each mutant, of seed 1."""
    shipped = {name: claim_metrics(simulate(load_scene(name))) for name in EMOTIONS}
    broken = ["; ".join(sorted(broken_claims(mutant, shipped))) for mutant in MUTANTS]
    rows = [f"| {mutant} | {mutant.words} | {claims} |" for mutant, claims in zip(MUTANTS, broken, strict=True)]
    return "\n".join(["| changed key | words of the paper | claims that it breaks |", "|---|---|---|", *rows])


if __name__ == "__main__":
    target = Path(sys.argv[1]) / "claims.md"
    page = target.read_text(encoding="utf-8")
    for name, made in (("claims", claims_table()), ("mutants", mutants_table())):
        before, _, rest = page.partition(f"<!-- {name} -->\n")
        page = f"{before}<!-- {name} -->\n\n{made}\n\n<!-- end -->{rest.partition('<!-- end -->')[2]}"
    target.write_text(page, encoding="utf-8")
