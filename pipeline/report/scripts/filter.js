// Shows of the list only the entries that hold every word typed. Where this does not run, the field
// is hidden and the list is whole.
"use strict";

(() => {
  const form = document.querySelector("form.filter");
  if (!form) return;
  const field = form.querySelector("input");
  const found = document.getElementById("found");
  const groups = [...document.querySelectorAll("[data-group]")].reverse();
  const entries = [...document.querySelectorAll("[data-entry]")];
  const folds = [...document.querySelectorAll("main details")];
  const opened = folds.map((fold) => fold.open);
  // an entry is found by its own words and by those of what it belongs to: "boat zig-zag"
  const texts = entries.map((entry) => {
    const parts = [entry.textContent];
    for (let at = entry.parentElement; at; at = at.parentElement) {
      const head = at.matches("[data-group]") && at.querySelector(":scope > [data-head]");
      if (head && head !== entry) parts.push(head.textContent);
    }
    return parts.join(" ").toLowerCase();
  });

  const apply = () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    entries.forEach((entry, number) => {
      entry.hidden = !words.every((word) => texts[number].includes(word));
      count += entry.hidden ? 0 : 1;
    });
    // from the innermost outwards; a group with anything found keeps the entry at its head
    for (const group of groups) {
      group.hidden = !group.querySelector("[data-entry]:not([hidden])");
      const head = group.querySelector(":scope > [data-head]");
      if (head && !group.hidden) head.hidden = false;
    }
    folds.forEach((fold, number) => {
      fold.open = words.length ? true : opened[number];
    });
    const text = found.dataset.text.replace("{0}", count).replace("{1}", entries.length);
    found.textContent = words.length ? text : "";
  };

  form.hidden = false;
  form.addEventListener("submit", (event) => event.preventDefault());
  field.addEventListener("input", apply);
  apply(); // the browser may have kept what was typed
})();
