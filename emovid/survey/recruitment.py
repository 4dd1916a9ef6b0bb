"""Participants sent by recruitment services: parameters of the survey's address, and the way back."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import quote

from flask import g, request

from emovid.kit.study import Return
from emovid.survey import codes
from emovid.survey.export import passed_checks
from emovid.survey.records import Participant
from emovid.survey.session import survey

_MAX_VALUE = 2000  # characters of a parameter; services use up to about 100


@dataclass(frozen=True)
class WayBack:
    """Return to the recruitment service: a code, a link, and the seconds until the page follows it."""

    code: str | None
    link: str | None
    automatic: int | None


def parameters_of(given: Mapping[str, str]) -> dict[str, str]:
    """Return the parameters that the study stores, of an address or of the form of the first page."""
    recruitment = survey().manifest.recruitment
    names = recruitment.names if recruitment else ()
    return {name: given[name][:_MAX_VALUE] for name in names if given.get(name)}


def way_back(to: Return, given: Mapping[str, str]) -> WayBack | None:
    """Return the way back to the service, with parameters in the places of the link that name them."""
    if not (to.code or to.link):
        return None
    recruitment = survey().manifest.recruitment
    link = to.link and re.sub(r"{([A-Za-z][\w-]*)}", lambda match: quote(given.get(match[1], ""), safe=""), to.link)
    return WayBack(to.code, link, recruitment.automatic if recruitment and link else None)


def way_back_of(person: Participant) -> WayBack | None:
    """Return the way back of a participant who has submitted."""
    server = survey().kit.server
    passed, asked = passed_checks(person, survey().kit)
    failed = passed < asked and (server.failed.code or server.failed.link)
    given = survey().store.recruit_parameters(codes.recruit_digest(g.code))
    return way_back(server.failed if failed else server.complete, given)


def is_someone_else(given: Mapping[str, str]) -> bool:
    """Return whether an address names another person than the participant of this browser.

    The first parameter that the study names identifies a person; others may differ when the same person returns.
    """
    recruitment = survey().manifest.recruitment
    if not (recruitment and recruitment.names and given.get(recruitment.names[0])):
        return False
    known = survey().store.recruit_parameters(codes.recruit_digest(g.code)).get(recruitment.names[0])
    return known is not None and known != given[recruitment.names[0]]


def record_start() -> None:
    """Record the parameters that the form of the first page sends, once."""
    if given := parameters_of(request.form):
        survey().store.add_recruit(codes.recruit_digest(g.code), given)


def record_end(person: Participant) -> None:
    """Record among the recruits that a participant has finished, or failed an attention check."""
    if survey().manifest.recruitment:
        passed, asked = passed_checks(person, survey().kit)
        survey().store.end_recruit(codes.recruit_digest(g.code), "failed" if passed < asked else "finished")
