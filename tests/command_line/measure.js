// Returns the faults of the page at its present width: text that leaves its picture or covers other text, figures without a size,
// content that is cut. Letters fill the middle of their boxes only.
(() => {
  const root = document.documentElement;
  const faults = [], titles = [];
  if (root.scrollWidth > root.clientWidth) faults.push(`the page is ${root.scrollWidth} wide`);
  for (const box of document.querySelectorAll("header, nav, figure, .verdict, .range, p")) {
    const { left, right } = box.getBoundingClientRect();
    if (left < 0 || right > root.clientWidth + 0.5) faults.push(`${box.tagName} ${box.textContent.slice(0, 40)}: from ${left} to ${right}`);
  }
  for (const figure of document.querySelectorAll("figure")) {
    const title = figure.querySelector("figcaption").textContent;
    const frame = figure.querySelector("svg").getBoundingClientRect();
    titles.push(title);
    if (frame.width < 200 || frame.height < 100) faults.push(`${title}: has no size`);
    const texts = [...figure.querySelectorAll("svg text")].map((text) => {
      const box = text.getBoundingClientRect();
      const rim = 0.18 * Math.min(box.width, box.height);
      const [left, right, top, bottom] = [box.left + rim, box.right - rim, box.top + rim, box.bottom - rim];
      return { words: text.textContent.trim(), left, right, top, bottom };
    });
    texts.forEach((a, i) => {
      if (a.left < frame.left || a.right > frame.right || a.top < frame.top || a.bottom > frame.bottom)
        faults.push(`${title}: ${a.words} leaves the picture`);
      for (const b of texts.slice(i + 1))
        if (a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
          faults.push(`${title}: ${a.words} overlaps ${b.words}`);
    });
  }
  // Every control has a name.
  for (const control of document.querySelectorAll("button, input, [tabindex]"))
    if (!(control.getAttribute("aria-label") || control.textContent.trim() || control.closest("label")))
      faults.push(`a ${control.localName} without a name`);
  return JSON.stringify({ width: innerWidth, titles, faults });
})()
