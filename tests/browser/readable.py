"""Whether a page can be read and reached: contrasts, broken words, what the tabulator comes to."""

from __future__ import annotations

from typing import Any

CONTRAST = """() => {
  const parse = (text) => text.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => {
    const [x, y, z] = [r, g, b].map((v) => v / 255).map(
      (v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
    return 0.2126 * x + 0.7152 * y + 0.0722 * z;
  };
  const contrast = (a, b) => {
    const [high, low] = [light(a), light(b)].sort((x, y) => y - x);
    return (high + 0.05) / (low + 0.05);
  };
  const ground = (element) => {
    for (let e = element; e; e = e.parentElement) {
      const found = parse(getComputedStyle(e).backgroundColor);
      if (found.length < 4 || found[3] > 0) return found;
    }
    return [255, 255, 255];
  };
  const texts = [...document.querySelectorAll("body *")]
    .filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()))
    .filter((e) => e.checkVisibility() && !["OPTION", "SCRIPT", "STYLE"].includes(e.tagName))
    .map((e) => [e.textContent.trim(), contrast(parse(getComputedStyle(e).color), ground(e))]);
  const probe = document.createElement("i");
  document.body.append(probe);
  const named = (name) => {
    probe.style.color = `var(--${name})`;
    return parse(getComputedStyle(probe).color);
  };
  const colours = ["user-0", "user-1", "user-2", "user-3", "slide", "loss", "line", "focus"]
    .map((name) => [name, contrast(named(name), named("ground"))]);
  probe.remove();
  return { texts, colours };
}"""

BROKEN = """() => {
  const found = [];
  for (const name of document.querySelectorAll("tbody th")) {
    const walker = document.createTreeWalker(name, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      for (const word of walker.currentNode.data.matchAll(/\\S+/g)) {
        const range = document.createRange();
        range.setStart(walker.currentNode, word.index);
        range.setEnd(walker.currentNode, word.index + word[0].length);
        const lines = new Set([...range.getClientRects()].map((each) => Math.round(each.top)));
        if (lines.size > 1) found.push(word[0]);
      }
    }
  }
  for (const cell of document.querySelectorAll("tbody td")) {
    const range = document.createRange();
    range.selectNodeContents(cell);
    const lines = new Set([...range.getClientRects()].map((each) => Math.round(each.top)));
    if (/^[-−]?[\\d.]+\\S*\\s\\S+$/.test(cell.textContent) && lines.size > 1) {
      found.push(cell.textContent);
    }
  }
  return found;
}"""

OPERABLE = """[...document.querySelectorAll(
  "a[href], button, input, select, textarea, summary, [tabindex]")]
  .filter((e) => e.checkVisibility() && !e.disabled && e.tabIndex >= 0)"""
NAMED = "((e) => e.id || e.name || e.textContent.trim().slice(0, 20) || e.tagName)"


def too_faint(page: Any) -> list[list[Any]]:
    """Texts below 4.5 to 1 and colours of lines below 3 to 1 (WCAG 2.2, AA), on their ground."""
    found = page.evaluate(CONTRAST)
    assert len(found["texts"]) > 1
    faint = [each for each in found["texts"] if each[1] < 4.5]
    return faint + [each for each in found["colours"] if each[1] < 3.0]


def broken_words(page: Any) -> list[str]:
    """Words of the tables' names, or their parts, and values that go on in another line."""
    assert page.locator("tbody th").count() > 0
    return page.evaluate(BROKEN)


def unreached(page: Any) -> list[str]:
    """What can be operated and no tabulator key comes to, or shows no focus when it does.

    Of radio buttons of one name one is reached, and the arrow keys lead on.
    """
    count = page.evaluate(f"(globalThis.operable = {OPERABLE}).length")
    assert count > 0
    page.evaluate("(document.activeElement?.blur(), globalThis.reached = new Set())")
    for _ in range(count + 2):
        page.keyboard.press("Tab")
        page.evaluate(
            "(getComputedStyle(document.activeElement).outlineStyle !== 'none')"
            " && reached.add(document.activeElement)"
        )
    return page.evaluate(
        "operable.filter((e) => !reached.has(e) && !(e.type === 'radio' &&"
        f" operable.some((o) => o.name === e.name && reached.has(o)))).map({NAMED})"
    )
