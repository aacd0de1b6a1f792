"""The page in a real browser: Debian's chromium, headless."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from itertools import pairwise

import pytest

from packgen.page import report_folder
from tests.page.test_report_page import lattice_folder

CHROMIUM = shutil.which("chromium")
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--enable-logging=stderr",
    "--window-size=1200,900", "--virtual-time-budget=60000", "--dump-dom",
)  # fmt: skip
# Does what a reader does, one thing after the other, and notes what the page shows after each.
# Under virtual time the browser shows no frames: a timer takes their place.
FRAMES = (
    "<script>window.requestAnimationFrame = act => setTimeout(() => act(performance.now()), 16);</script>"
)
READER = """
<script>
(() => {
  const canvas = document.getElementById("view"), cut = document.getElementById("cut");
  const slider = document.getElementById("cut-at");
  const colour = document.getElementById("colour"), notes = [];
  const press = key => canvas.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
  const point = (kind, x) => canvas.dispatchEvent(
    new PointerEvent(kind, {pointerId: 1, clientX: x, clientY: 100, bubbles: true}));
  const slide = to => { slider.value = to; slider.dispatchEvent(new Event("input")); };
  canvas.setPointerCapture = () => {};
  const note = name => {
    const all = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let sum = 0, drawn = 0;
    for (let at = 0; at < all.length; at += 4) {
      if (all[at + 3]) drawn++;
      sum = (sum * 31 + all[at] + 3 * all[at + 1] + 7 * all[at + 2] + all[at + 3]) % 1000003;
    }
    const legend = document.getElementById("view-legend").textContent;
    const says = slider.getAttribute("aria-valuetext"), off = slider.disabled;
    notes.push({name, sum, drawn, legend, says, off, azimuth: canvas.dataset.azimuth});
    document.body.dataset.notes = JSON.stringify(notes);
  };
  const steps = [
    ["start", () => {}],
    ["key", () => press("ArrowLeft")],
    ["drag", () => { point("pointerdown", 100); point("pointermove", 160); point("pointerup", 160); }],
    ["zoom", () => canvas.dispatchEvent(new WheelEvent("wheel", {deltaY: -300, cancelable: true}))],
    ["home", () => press("Home")],
    ["quarter", () => slide(25)],
    ["most", () => slide(90)],
    ["half", () => slide(50)],
    ["whole", () => cut.click()],
    ["radius", () => { colour.value = "radius"; colour.dispatchEvent(new Event("change")); }],
    ["zone", () => { colour.value = "zone"; colour.dispatchEvent(new Event("change")); }],
    ["top", () => document.getElementById("look-top").click()],
  ];
  const wait = time => new Promise(done => setTimeout(() => requestAnimationFrame(done), time));
  (async () => {
    await wait(500);
    for (const [name, act] of steps) {
      act();
      await wait(400);
      await wait(400);
      note(name);
    }
  })();
})();
</script>
"""


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
def test_the_view_draws_turns_zooms_cuts_and_colours_without_a_console_error(tmp_path):
    page = report_folder(lattice_folder(tmp_path))
    tried = tmp_path / "tried.html"
    text = page.read_text(encoding="utf-8").replace("<head>", "<head>" + FRAMES)
    tried.write_text(text.replace("</body>", READER + "</body>"), encoding="utf-8")
    run = subprocess.run(
        [CHROMIUM, *OPTIONS, f"--user-data-dir={tmp_path / 'profile'}", tried.as_uri()],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    assert "CONSOLE" not in run.stderr
    found = re.search(r'data-notes="([^"]*)"', run.stdout)
    assert found is not None, run.stderr[-2000:]
    seen = {each["name"]: each for each in json.loads(found[1].replace("&quot;", '"'))}
    assert seen["start"]["drawn"] > 10_000
    assert seen["key"]["azimuth"] != seen["start"]["azimuth"]
    assert seen["drag"]["azimuth"] != seen["key"]["azimuth"]
    order = ["start", "key", "drag", "zoom", "home", "quarter", "most", "half", "whole"]
    for before, after in pairwise(order):
        assert seen[before]["sum"] != seen[after]["sum"], after
    assert seen["home"]["sum"] == seen["start"]["sum"]
    assert seen["half"]["sum"] == seen["home"]["sum"]
    assert seen["most"]["drawn"] < seen["half"]["drawn"] < seen["quarter"]["drawn"]
    said = [seen[name]["says"] for name in ("start", "quarter", "whole")]
    assert said == ["in half", "25 % taken away", "whole"]
    assert [seen[name]["off"] for name in ("half", "whole")] == [False, True]
    assert seen["whole"]["drawn"] > seen["home"]["drawn"]
    assert "radius 0.1" in seen["radius"]["legend"]
    assert seen["zone"]["legend"] == "zone 0"
    assert seen["top"]["sum"] != seen["zone"]["sum"]
