"""Take the screenshot of the survey for the README: four pages on a phone, side by side. Needs Chromium.

Usage: python docs/make_survey_picture.py FILE.png
"""

import io
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

EXAMPLE = Path(__file__).parent.parent / "studies" / "example" / "study.yaml"
WIDTH, HEIGHT, GAP = 360, 740, 24  # pixels


def main(target: str) -> None:
    """Write the picture to `target`."""
    with tempfile.TemporaryDirectory() as name:
        kit = Path(name) / "kit"
        study = Path(name) / "study.yaml"
        study.write_text(EXAMPLE.read_text().replace("duration: 15", "duration: 4"))
        emovid = [sys.executable, "-m", "emovid", "study"]
        subprocess.run([*emovid, "build", str(study), "-o", str(kit), "--seed", "5", "--quiet"], check=True)
        with subprocess.Popen([*emovid, "serve", str(kit), "--port", "0"], stderr=subprocess.PIPE, text=True) as server:
            assert server.stderr
            address = re.match(r"(http://\S+/): ", server.stderr.readline())
            assert address
            pages = screens(address[1])
            server.terminate()
    beside(pages).save(target, optimize=True)


def screens(address: str) -> list[Image.Image]:
    """Return screenshots of the instructions, a playing video, the choice and the review."""
    with sync_playwright() as playwright:
        path = shutil.which("chromium") or shutil.which("google-chrome")
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-gpu"])
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, is_mobile=True, has_touch=True)
        page.goto(address)
        page.get_by_role("button", name="I agree").click()
        page.wait_for_url("**/about")
        for group in page.locator("fieldset").all():
            group.get_by_role("radio").first.check()
        press(page, "Continue", "instructions")
        taken = [taken_of(page)]
        press(page, "Continue", "video/1")
        for place in range(1, 7):
            page.locator("#play").click()
            if place == 3:
                page.wait_for_timeout(2500)
                taken.append(taken_of(page))
            page.locator("#gate:enabled").wait_for()
            page.get_by_role("radio").nth(place - 1).check()
            if place == 3:
                taken.append(taken_of(page))
            press(page, "Submit answer", f"video/{place + 1}" if place < 6 else "review")
        taken.append(taken_of(page))
        browser.close()
    return taken


def press(page: Page, button: str, then: str) -> None:
    """Press a button and wait for the next page."""
    page.get_by_role("button", name=button).click()
    page.wait_for_url(f"**/{then}")


def taken_of(page: Page) -> Image.Image:
    """Return a screenshot."""
    return Image.open(io.BytesIO(page.screenshot())).convert("RGB")


def beside(pages: list[Image.Image]) -> Image.Image:
    """Return the pages in a row, on gray."""
    sheet = Image.new("RGB", (len(pages) * (WIDTH + GAP) + GAP, HEIGHT + 2 * GAP), "#c9cdd2")
    for i, page in enumerate(pages):
        sheet.paste(page, (GAP + i * (WIDTH + GAP), GAP))
    return sheet


if __name__ == "__main__":
    main(sys.argv[1])
