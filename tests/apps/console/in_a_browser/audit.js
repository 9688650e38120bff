// Returns what is wrong with the layout of a page, a sentence each: what is wider than the window, cut text, text with
// too little contrast (WCAG 2.1: 4.5, and 3 for large text), and controls without a name.
() => {
  const found = [], width = document.documentElement.clientWidth;
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const SCROLLS = ".c-nav, .c-robots, .a-diagram, .a-scroll, .c-unseen, .c-skip";
  const words = (element) => (element.innerText || element.value || element.className || element.tagName).trim().slice(0, 60);
  const isSeen = (element) => element.checkVisibility({ opacityProperty: true, visibilityProperty: true });

  function blend(colours) {
    canvas.clearRect(0, 0, 1, 1);
    for (const colour of ["white", ...colours]) {
      canvas.fillStyle = colour;
      canvas.fillRect(0, 0, 1, 1);
    }
    return [...canvas.getImageData(0, 0, 1, 1).data].slice(0, 3);
  }
  function luminance(rgb) {
    const [red, green, blue] = rgb.map((each) => (each / 255 <= 0.04045 ? each / 255 / 12.92 : ((each / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  }
  function contrast(element, style) {
    const behind = [];
    for (let each = element; each; each = each.parentElement) behind.unshift(getComputedStyle(each).backgroundColor);
    const [one, other] = [luminance(blend(behind)), luminance(blend([...behind, style.color]))];
    return (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
  }

  if (document.documentElement.scrollWidth > width) found.push(`the page is ${document.documentElement.scrollWidth} px wide in a window of ${width} px`);
  for (const element of document.querySelectorAll("body *")) {
    const box = element.getBoundingClientRect();
    if (!box.width || !box.height || !isSeen(element) || element.closest(".c-skip, .c-unseen, noscript")) continue;
    const style = getComputedStyle(element);
    if (box.right > width + 1 && !element.closest(SCROLLS)) found.push(`beyond the right side: ${words(element)}`);
    const isDisabled = element.closest("[disabled], .disabled, [aria-disabled=true]");
    const hasText = [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());
    if (hasText && !isDisabled && !(element instanceof SVGElement) && !element.matches(".q-icon, option, i")) {
      const size = parseFloat(style.fontSize), isLarge = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
      const ratio = contrast(element, style);
      if (ratio < (isLarge ? 3 : 4.5)) found.push(`contrast ${ratio.toFixed(2)}: ${words(element)}`);
    }
    if (hasText && style.overflowX !== "visible" && element.scrollWidth > element.clientWidth + 1 && !element.closest(SCROLLS)) {
      found.push(`cut: ${words(element)}`);
    }
    if (element.matches("input") && element.placeholder && !element.value && !["checkbox", "radio", "range"].includes(element.type)) {
      canvas.font = style.font;
      if (canvas.measureText(element.placeholder).width > element.clientWidth + 1) found.push(`cut: ${element.placeholder}`);
    }
    if (element.matches("button, a[href], input, select, textarea, [role=button], [role=switch], [role=checkbox], [role=combobox], [role=slider]")) {
      const label = element.ariaLabel || element.title || element.innerText || element.labels?.length || element.getAttribute("aria-labelledby");
      if (!label || !String(label).trim()) found.push(`without a name: ${element.outerHTML.slice(0, 120)}`);
    }
  }
  return [...new Set(found)];
}
