// Puts an interactive figure in the place of each still picture that carries its data. Where this
// does not run, or the plotting library is not there, the still pictures stay.
"use strict";

(() => {
  if (!window.Plotly) return;
  // a finger that moves the page must not draw a zoom box
  const touch = window.matchMedia("(pointer: coarse)").matches;
  const config = {
    displaylogo: false,
    responsive: true,
    displayModeBar: touch ? true : "hover",
    // named one by one: none that would send data anywhere
    modeBarButtons: [
      ["toImage"],
      ["zoom2d", "pan2d"],
      ["zoomIn2d", "zoomOut2d", "resetScale2d"],
    ],
  };

  const draw = (data) => {
    const still = data.previousElementSibling;
    const live = document.createElement("div");
    live.className = "zoomed";
    live.setAttribute("role", "group");
    live.setAttribute("aria-label", still.getAttribute("aria-label") || "");
    const { data: traces, layout } = JSON.parse(data.textContent);
    live.style.height = `${layout.height}px`;
    layout.dragmode = touch ? false : "zoom";
    data.after(live);
    still.classList.add("replaced");
    window.Plotly.newPlot(live, traces, layout, config).catch((error) => {
      live.remove();
      still.classList.remove("replaced");
      console.error(error);
    });
  };

  // drawn when they come near the screen: a page of many figures opens at once
  const seen = new IntersectionObserver(
    (entries) => {
      for (const entry of entries.filter((one) => one.isIntersecting)) {
        seen.unobserve(entry.target);
        draw(entry.target.nextElementSibling);
      }
    },
    { rootMargin: "600px" },
  );
  for (const data of document.querySelectorAll("script.zoom-data")) {
    seen.observe(data.previousElementSibling);
  }
})();
