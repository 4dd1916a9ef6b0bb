"""The table "What happens when" of docs/survey.md: every line has tests, and every test in the list exists."""

import re
from pathlib import Path

HERE = Path(__file__).parent
PAGE = HERE.parent.parent / "docs" / "survey.md"
TESTS = {
    "consent twice (double press, two tabs)": ["test_consent_that_is_given_twice_enrols_once"],
    "no consent": ["test_who_declines_leaves_nothing", "test_a_failed_check_and_no_consent_have_codes_of_their_own"],
    "no consent, after consent in another tab": [
        "test_who_declines_after_agreeing_in_another_tab_is_asked_whether_to_delete_all"
    ],
    "device or browser outside the requirements": ["test_requirements_are_shown_first_and_checked"],
    "an answer sent twice": ["test_an_answer_that_comes_twice_is_one"],
    "two tabs": ["test_two_tabs_are_one_participant_and_the_later_answer_counts"],
    "back button of the browser": [
        "test_the_browser_s_back_button_shows_what_the_server_has",
        "test_back_button_shows_the_answers_that_the_server_has",
    ],
    "page too far ahead, by its address": ["test_a_page_ahead_leads_to_the_current_one"],
    "answer before the video was watched": ["test_the_gate_cannot_be_skipped_by_a_direct_post"],
    "answer or slider missing, number out of range": [
        "test_a_required_question_without_an_answer_is_asked_again_with_what_was_said",
        "test_a_slider_that_was_not_moved_or_has_no_such_place_is_asked_for_again",
        "test_answers_of_other_kinds_are_checked_and_exported",
    ],
    "answers too long to be sent": [
        "test_bodies_and_fields_have_an_end",
        "test_answers_that_are_too_long_stay_on_the_page",
    ],
    "leaving a page with unsent text": ["test_long_answers_in_japanese_are_sent_and_unsent_text_is_warned_of"],
    "submission twice": ["test_a_double_submission_changes_nothing"],
    "submission before everything is answered": ["test_nothing_is_submitted_before_all_is_answered"],
    "any page or answer after submission": [
        "test_a_tab_left_open_after_submission_in_another_changes_nothing_and_is_led_to_the_thanks"
    ],
    "reload, crash of the browser or device": [
        "test_a_crash_of_the_browser_loses_no_acknowledged_answer",
        "test_every_click_is_in_the_export_and_nothing_else",
    ],
    "restart of the server, lost connection": [
        "test_a_restart_of_the_server_is_not_noticed",
        "test_no_acknowledged_answer_is_lost_and_none_is_there_twice",
        "test_questions_called_as_parts_of_the_page_are_sent_and_a_lost_connection_is_seen",
    ],
    "database locked by another program": [
        "test_a_locked_database_is_waited_for",
        "test_a_recruit_is_recorded_by_the_next_request_where_the_database_was_locked",
    ],
    "video that cannot be loaded": ["test_a_video_that_fails_says_so_and_plays_once_the_network_is_back"],
    "cookies blocked": ["test_blocked_cookies_are_named"],
    "expired or deleted cookie": ["test_an_expired_cookie_is_asked_for_the_code_which_leads_back"],
    "unknown code": ["test_an_unknown_code_is_reported_and_deletes_nothing"],
    "code of a participant who has withdrawn": ["test_withdrawal_deletes_and_every_later_step_says_so"],
    "form without the token of our page, or of another participant": [
        "test_nothing_is_taken_without_the_token_of_our_own_page",
        "test_the_form_of_one_participant_cannot_be_sent_as_another",
    ],
    "no JavaScript, or script not loaded": [
        "test_without_javascript_a_page_says_what_it_needs",
        "test_without_one_of_its_scripts_a_page_with_a_video_says_that_it_needs_them",
    ],
    "tab in the background": ["test_a_hidden_tab_pauses_the_video_and_its_share_is_reported"],
    "the server's clock put back": ["test_clock_that_is_put_back_between_two_runs_gives_no_negative_time"],
    "another member of a panel at the same browser": [
        "test_a_second_member_of_a_panel_at_the_same_computer_is_another_participant"
    ],
    "a participant leaves a kiosk in the middle": ["test_a_kiosk_forgets_whoever_leaves_in_the_middle"],
}


def test_every_line_of_the_table_has_a_test() -> None:
    section = PAGE.read_text(encoding="utf-8").partition("## What happens when\n")[2].partition("\n## ")[0]
    lines = [line.split("|")[1].strip() for line in section.strip().splitlines()[2:]]
    assert lines == list(TESTS)
    source = "".join(path.read_text(encoding="utf-8") for path in HERE.glob("test_*.py") if path != Path(__file__))
    written = set(re.findall(r"^def (test_\w+)\(", source, re.MULTILINE))
    assert {name for names in TESTS.values() for name in names} - written == set()
