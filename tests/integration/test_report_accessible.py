"""What axe-core, the checker of the browsers' own developer tools, finds on the pages."""

import re
from importlib import resources
from pathlib import Path

import pytest
from headless_browser import browse
from report_site import KINDS

#: Levels A and AA of WCAG 2.0, 2.1 and 2.2.
AXE_RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
AXE = """
const measure = async (view, one) => {
  const page = view.document;
  for (const fold of page.querySelectorAll("details")) fold.open = true;
  const { violations, passes } = await view.axe.run(
    { exclude: [[".zoomed"], ["svg.plot"]] },
    { runOnly: one.rules, resultTypes: ["violations"] },
  );
  const faults = violations.map((one) => [
    one.id, one.help, ...one.nodes.slice(0, 3).map((node) => node.target.join(" ")),
  ]);
  return { faults, passes: passes.length };
};
"""


SPOILT = '<img src="data:,"><p style="color:#999;background:#aaa">hard to read</p>'


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_fault(
    browser: str, pages: dict[str, Path], tmp_path: Path, scheme: str
) -> None:
    axe = resources.files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8")
    # colours alone differ in the dark
    rules = ["color-contrast"] if scheme == "dark" else AXE_RULES
    wanted = []
    for name in (*KINDS, "spoilt"):
        page = pages.get(name, pages["index"])
        # the page's own policy lets no foreign script in
        policy = r"<meta http-equiv=.Content-Security-Policy[^>]*>"
        text = re.sub(policy, "", page.read_text(encoding="utf-8"))
        if name == "spoilt":
            text = text.replace("</main>", f"{SPOILT}</main>")
        copy = page.with_name(f"axe-{scheme}-{name}-{page.name}")
        copy.write_text(text.replace("</body>", f"<script>{axe}</script></body>"), encoding="utf-8")
        wanted.append({"name": name, "width": 1200, "address": copy.as_uri(), "rules": rules})
    dark = ["--blink-settings=preferredColorScheme=0"] if scheme == "dark" else []
    measured, _ = browse(browser, wanted, AXE, tmp_path, *dark)
    found = {fault[0] for fault in measured.pop("spoilt")["faults"]}
    assert found >= {"color-contrast", *(() if scheme == "dark" else ("image-alt",))}
    assert {kind: one["faults"] for kind, one in measured.items()} == {kind: [] for kind in KINDS}
    assert all(one["passes"] >= (1 if scheme == "dark" else 15) for one in measured.values())
