"""The table "Special situations" of docs/survey.md: every line has tests, and every test in the list exists."""

import re
from pathlib import Path

HERE = Path(__file__).parent
PAGE = HERE.parent.parent / "docs" / "survey.md"
TESTS = {
    "consent twice (double press, two tabs)": ["test_repeated_consent_enrolls_once"],
    "no consent": ["test_declining_stores_no_data", "test_failed_check_and_declined_consent_have_separate_codes"],
    "no consent, after consent in another tab": ["test_declining_after_consent_in_another_tab_offers_withdrawal"],
    "device or browser outside the requirements": ["test_requirements_are_shown_and_checked_first"],
    "an answer sent twice": ["test_repeated_answer_is_stored_once"],
    "two tabs": ["test_two_tabs_share_a_participant_and_the_later_answer_counts"],
    "back button of the browser": [
        "test_back_button_shows_the_stored_state",
        "test_back_button_shows_the_answers_that_the_server_has",
    ],
    "address of a later page": ["test_a_page_ahead_leads_to_the_current_one"],
    "answer before the video was watched": ["test_unwatched_video_cannot_be_answered_by_a_direct_post"],
    "answer or slider missing, number out of range": [
        "test_missing_required_answer_is_requested_and_other_answers_are_kept",
        "test_unmoved_or_invalid_slider_is_requested_again",
        "test_answers_of_other_kinds_are_checked_and_exported",
    ],
    "answers too long to be sent": [
        "test_request_bodies_and_fields_are_limited",
        "test_answers_that_are_too_long_stay_on_the_page",
    ],
    "leaving a page with unsent text": ["test_long_japanese_answers_are_sent_and_unsent_text_gives_a_warning"],
    "submission twice": ["test_a_double_submission_changes_nothing"],
    "submission before everything is answered": ["test_submission_requires_all_answers"],
    "any page or answer after submission": ["test_tab_open_after_submission_is_redirected_to_the_last_page"],
    "reload, crash of the browser or device": [
        "test_browser_crash_loses_no_acknowledged_answer",
        "test_export_contains_exactly_the_clicks",
    ],
    "restart of the server, lost connection": [
        "test_server_restart_does_not_interrupt_participants",
        "test_acknowledged_answers_are_stored_exactly_once",
        "test_questions_named_like_page_elements_are_sent_and_connection_loss_is_shown",
    ],
    "database locked by another program": [
        "test_a_locked_database_is_waited_for",
        "test_a_recruit_is_recorded_by_the_next_request_where_the_database_was_locked",
    ],
    "video that cannot be loaded": ["test_failed_video_is_reported_and_plays_after_reconnecting"],
    "cookies blocked": ["test_blocked_cookies_are_named"],
    "expired or deleted cookie": ["test_expired_cookie_requires_the_code_to_resume"],
    "unknown code": ["test_an_unknown_code_is_reported_and_deletes_nothing"],
    "code of a participant who has withdrawn": ["test_withdrawal_deletes_data_and_later_requests_report_it"],
    "form without a valid token, or with that of another participant": [
        "test_posts_without_the_form_token_are_refused",
        "test_the_form_of_one_participant_cannot_be_sent_as_another",
    ],
    "no JavaScript, or script not loaded": [
        "test_pages_without_javascript_explain_the_requirement",
        "test_without_one_of_its_scripts_a_page_with_a_video_says_that_it_needs_them",
    ],
    "tab in the background": ["test_a_hidden_tab_pauses_the_video_and_its_share_is_reported"],
    "the server's clock put back": ["test_clock_set_back_between_runs_gives_no_negative_time"],
    "another member of a panel at the same browser": [
        "test_a_second_member_of_a_panel_at_the_same_computer_is_another_participant"
    ],
    "a participant leaves a kiosk in the middle": ["test_a_kiosk_forgets_whoever_leaves_in_the_middle"],
}


def test_every_line_of_the_table_has_a_test() -> None:
    section = PAGE.read_text(encoding="utf-8").partition("## Special situations\n")[2].partition("\n## ")[0]
    lines = [line.split("|")[1].strip() for line in section.strip().splitlines()[2:]]
    assert lines == list(TESTS)
    source = "".join(path.read_text(encoding="utf-8") for path in HERE.glob("test_*.py") if path != Path(__file__))
    written = set(re.findall(r"^def (test_\w+)\(", source, re.MULTILINE))
    assert {name for names in TESTS.values() for name in names} - written == set()
