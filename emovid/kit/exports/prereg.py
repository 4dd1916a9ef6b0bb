"""A draft of a preregistration, with the questions that the forms of OSF and AsPredicted have in common."""

from importlib.metadata import version

from emovid.atomic_io import file_digest
from emovid.kit.exports.reporting import OPEN, facts_of
from emovid.kit.exports.texts import Files
from emovid.kit.folder import Kit

_TEXT = """# Preregistration: {title}

A draft, filled from the kit by `emovid study export --to prereg`. What only you know is marked {open}.

## Authors

{authors}

## Have any data been collected?

{open}

## Hypotheses

{hypotheses}

## Design

Within participants: {orders}

## Stimuli

{stimuli}

## Blinding

{blinding}

## Measures

{measures}

## Sample size and stopping rule

{participants}

Stopping rule: {open}. Recruitment and payment: {open}.

## Exclusions

{exclusions}

## Analysis

By `emovid study analyze`, version {version}:

- for each emotion, over the answers to its videos, Pearson's chi-squared goodness of fit to equally likely answers,
  with the exact p beside it, and Cohen's w;
- for each emotion, the hit rate with its Wilson interval, and the exact one-sided binomial test against chance,
  corrected for {tests} emotions by Holm's method at a level of {alpha:g}; an emotion counts as recognised if that
  rejects chance;
- over all emotions, the permutation test within participants, which holds where answers depend on each other;
- confusion matrix, unbiased hit rates and kappa, described without tests.

Secondary analyses by groups: {groups}. Anything else is exploratory.

## Ethics

{ethics}

## Materials

manifest.json of the kit, by its SHA-256: `{manifest}`
"""


def prereg(kit: Kit) -> Files:
    """Return the draft."""
    facts = facts_of(kit)
    groups = [item.name.replace("_", " ") for item in kit.manifest.demographics]
    text = _TEXT.format(
        title=kit.manifest.title,
        open=OPEN,
        authors=", ".join(kit.manifest.authors) or OPEN,
        hypotheses="\n".join(f"{i}. {text}" for i, text in enumerate(facts.study.hypotheses, start=1)) or OPEN,
        orders=facts.orders,
        stimuli=facts.stimuli,
        blinding=facts.blinding,
        measures=facts.measures,
        participants=facts.participants,
        exclusions=facts.exclusions,
        version=version("emovid"),
        tests=facts.tests,
        alpha=facts.study.plan.alpha,
        groups=", ".join(groups) or "none",
        ethics=facts.ethics,
        manifest=file_digest(kit.folder.manifest),
    )
    return {"preregistration.md": text}
