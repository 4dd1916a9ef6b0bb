"""Write the tables of docs/claims.md between its markers: claims with reasons, and the mutants that each rejects."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from emovid.measure.claim_metrics import claim_metrics
from emovid.measure.claims import CLAIMS
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene
from emovid.swarm.simulate import simulate
from tests.helpers.mutants import MUTANTS, broken_claims


def tables() -> tuple[str, str]:
    """Return the table of claims, with the mutants of seed 1 that each rejects, and that of mutants."""
    shipped = {name: claim_metrics(simulate(load_scene(name))) for name in EMOTIONS}
    broken = [broken_claims(mutant, shipped) for mutant in MUTANTS]
    claims = ["| | claim | source | reason for the bound | rejected mutants |", "|---|---|---|---|---|"]
    for number, claim in enumerate(CLAIMS, 1):
        rejected = ", ".join(f"m{i}" for i, texts in enumerate(broken, 1) if claim.text in texts)
        claims.append(f"| {number} | {claim.text} | {claim.source} | {claim.reason} | {rejected or 'none'} |")
    mutants = ["| | changed key | words of the paper | claims that reject it |", "|---|---|---|---|"]
    for number, (mutant, texts) in enumerate(zip(MUTANTS, broken, strict=True), 1):
        rejecting = ", ".join(str(i) for i, claim in enumerate(CLAIMS, 1) if claim.text in texts)
        mutants.append(f"| m{number} | {mutant} | {mutant.words} | {rejecting} |")
    return "\n".join(claims), "\n".join(mutants)


if __name__ == "__main__":
    target = Path(sys.argv[1]) / "claims.md"
    page = target.read_text(encoding="utf-8")
    for name, made in zip(("claims", "mutants"), tables(), strict=True):
        before, _, rest = page.partition(f"<!-- {name} -->\n")
        page = f"{before}<!-- {name} -->\n\n{made}\n\n<!-- end -->{rest.partition('<!-- end -->')[2]}"
    target.write_text(page, encoding="utf-8")
