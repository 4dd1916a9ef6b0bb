from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.kit.orders import balance_of, largest_spread, presentation_orders
from emovid.survey import codes
from emovid.survey.rules import (
    Page,
    Play,
    Progress,
    Step,
    after_video,
    before,
    credited,
    current,
    is_open,
    may_answer,
    next_row,
    wait,
)

DONE = st.builds(
    lambda asked, told, instructed, videos, answered, submitted: Progress(
        asked, told, instructed, videos, {n for n in answered if n <= videos}, submitted
    ),
    st.booleans(),
    st.booleans(),
    st.booleans(),
    st.integers(1, 8),
    st.sets(st.integers(1, 8)),
    st.booleans(),
)
STEPS = [Step(Page.ABOUT), Step(Page.INSTRUCTIONS), *(Step(Page.VIDEO, n) for n in range(10)), Step(Page.REVIEW)]


@given(st.lists(st.sampled_from(["finish", "abandon"]), max_size=80), st.integers(1, 12))
def test_row_counts_differ_by_at_most_one_for_any_dropouts(fates, rows) -> None:
    names = [f"P{n:03d}" for n in range(rows)]
    taken = Counter[str]()
    for fate in fates:
        row = next_row(names, taken)
        assert taken[row] == min(taken[name] for name in names)
        if fate == "finish":
            taken[row] += 1
        assert max(taken.values(), default=0) - min(taken[name] for name in names) <= 1


@given(st.integers(2, 8), st.integers(1, 60), st.sampled_from(["latin", "williams"]))
def test_enrollment_without_dropouts_keeps_the_balance_of_the_orders(videos, people, scheme) -> None:
    codes = [f"v{n}" for n in range(videos)]
    orders = {f"P{n:03d}": order for n, order in enumerate(presentation_orders(scheme, codes, 60, 5))}
    taken = Counter[str]()
    for _ in range(people):
        taken[next_row(list(orders), taken)] += 1
    seen = [order for name, order in orders.items() for _ in range(taken[name])]
    places, pairs = largest_spread(scheme, videos, people)
    balance = balance_of(seen, codes)
    assert balance.places_spread <= places
    assert pairs is None or balance.pairs_spread <= pairs


@given(DONE)
def test_current_and_earlier_pages_are_open(done) -> None:
    step = current(done)
    assert is_open(step, done)
    while (step := before(step, done)) is not None:
        assert is_open(step, done)


@given(DONE, st.sampled_from(STEPS))
def test_later_pages_are_closed_and_after_submission_all_except_the_last(done, step) -> None:
    if is_open(step, done):
        assert step <= current(done)
        assert not done.submitted
        assert step.page is not Page.VIDEO or 1 <= step.place <= done.videos


@given(st.integers(1, 8))
def test_answering_in_sequence_shows_each_video_once_and_ends_at_the_review(videos) -> None:
    answered: set[int] = set()
    step, shown = Step(Page.VIDEO, 1), []
    while step.page is Page.VIDEO:
        shown.append(step.place)
        answered.add(step.place)
        step = after_video(step.place, Progress(False, False, True, videos, answered, False))
    assert shown == list(range(1, videos + 1))
    assert step == Step(Page.REVIEW)


def test_changed_answer_leads_to_the_next_video_or_back_to_the_review() -> None:
    assert after_video(2, Progress(False, False, True, 6, {1, 2, 3}, False)) == Step(Page.VIDEO, 3)
    assert after_video(2, Progress(False, False, True, 6, range(1, 7), False)) == Step(Page.REVIEW)


MOMENTS = st.floats(0, 1e6)


@given(MOMENTS, MOMENTS, st.floats(0.04, 60), st.floats(allow_nan=False))
def test_credited_playback_is_limited_by_elapsed_time(started, now, duration, share) -> None:
    believed = credited(share, started, now, duration)
    assert 0 <= believed <= 1
    assert believed * duration <= max(now - started, 0) + 1e-6


@given(st.lists(st.builds(Play, MOMENTS, st.floats(0, 1)), max_size=5), MOMENTS, st.floats(0.04, 60))
def test_question_opens_only_after_a_complete_play_and_its_duration(plays, now, duration) -> None:
    if may_answer(plays, now, duration):
        assert any(play.share >= 0.98 for play in plays)
        assert all(
            now - play.started >= 0.98 * duration for play in plays if play is min(plays, key=lambda p: p.started)
        )
    else:
        late = now - min((play.started for play in plays), default=now) >= 0.98 * duration
        assert not (late and any(play.share >= 0.98 for play in plays))


@pytest.mark.parametrize(("elapsed", "share", "seconds"), [(0, 1, 9.8), (9, 1, 0.8), (9.8, 1, 0), (5, 0.97, 0)])
def test_early_report_gets_the_remaining_waiting_time(elapsed, share, seconds) -> None:
    assert wait(share, 100.0, 100.0 + elapsed, 10.0) == pytest.approx(seconds)


def test_codes_are_long_and_survive_being_copied_by_hand() -> None:
    drawn = {codes.fresh_code() for _ in range(500)}
    assert len(drawn) == 500
    for code in drawn:
        assert codes.normalized(f" {codes.readable(code).upper()}\n") == code
    marks = Counter("".join(drawn))
    assert len(marks) == 28
    assert 28 ** len(code) > 2**115
    assert max(marks.values()) < 1.4 * min(marks.values())


@given(st.text(max_size=60))
def test_a_normalized_code_is_empty_or_the_text_without_separators(text) -> None:
    assert codes.normalized(text) in ("", "".join(text.split()).replace("-", "").lower())


@pytest.mark.parametrize(
    "text", ["", "a" * 24, "0" * 24, "b" * 23, "b" * 25, "b" * 10**6, "' OR 1=1 --", "b" * 23 + "ö"]
)
def test_invalid_codes_are_refused_before_database_access(text) -> None:
    assert codes.normalized(text) == ""


def test_form_token_is_valid_for_one_secret_and_one_code() -> None:
    token = codes.form_token(b"secret", "code")
    assert codes.is_form_token(token, b"secret", "code")
    for given_token, secret, code in [(token, b"other", "code"), (token, b"secret", "edoc"), ("", b"secret", "code")]:
        assert not codes.is_form_token(given_token, secret, code)
    assert not codes.is_form_token("ö", b"secret", "code")
    assert len({codes.form_token(b"secret", str(n)) for n in range(50)}) == 50
    assert all(first != second for first, second in pairwise([token, codes.digest("code"), "code"]))
