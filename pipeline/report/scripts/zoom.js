// Puts an interactive figure in the place of each still picture that carries its data. Where this
// does not run, or the plotting library is not there, the still pictures stay.
"use strict";

// A file of numbers behind every table and curve, made where it is asked for.
(() => {
  const word = document.documentElement.lang === "ru" ? "Скачать CSV" : "Download CSV";
  const cell = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const save = (name, rows) => {
    const text = rows.map((row) => row.map((one) => cell(String(one ?? ""))).join(",")).join("\n");
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([`${text}\n`], { type: "text/csv" }));
    link.download = `${name}.csv`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  const button = (after, name, rows) => {
    const own = document.createElement("button");
    own.type = "button";
    own.className = "csv";
    own.textContent = word;
    own.addEventListener("click", () => save(name, rows()));
    after.after(own);
  };
  const numbers = (one) => {
    if (!one || !one.bdata) return one || [];
    const bytes = Uint8Array.from(atob(one.bdata), (sign) => sign.charCodeAt(0));
    return one.dtype === "f8" ? new Float64Array(bytes.buffer) : new Float32Array(bytes.buffer);
  };
  document.querySelectorAll(".wide > table").forEach((table, place) => {
    const rows = () => [...table.rows].map((row) => [...row.cells].map((one) => one.innerText.trim()));
    button(table.parentElement, `table-${place + 1}`, rows);
  });
  document.querySelectorAll("script.zoom-data").forEach((data) => {
    const figure = data.closest("figure");
    const rows = () => {
      const { data: traces, layout } = JSON.parse(data.textContent);
      const title = (one, way) =>
        layout[(one[`${way}axis`] || way).replace(way, `${way}axis`)]?.title?.text || "";
      const bars = traces.some((one) => one.orientation === "h");
      const apart = "xaxis2" in layout;
      const x = title({}, "x") || "x";
      return [
        ["panel", "curve", ...(bars ? ["bar", x] : [apart ? "x" : x, "value"]), "low", "high"],
        ...traces.flatMap((one) => {
          const [at, values] = (bars ? [one.customdata, one.x] : [one.x, one.y]).map(numbers);
          const panel = title(one, "y") + (apart ? ` (x: ${title(one, "x")})` : "");
          const error = one.error_x || one.error_y;
          const [up, down] = error ? [numbers(error.array), numbers(error.arrayminus)] : [];
          return [...at].map((place, k) => {
            const ends = error ? [values[k] - down[k], values[k] + up[k]] : [];
            return [panel, one.name, place, values[k], ...ends];
          });
        }),
      ];
    };
    button(figure.querySelector("figcaption"), figure.id, rows);
  });
})();

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

  const [ink, soft, grid, clear] = ["#1b1f24", "#6b737c", "#dfe3e8", "rgba(0,0,0,0)"];
  const styled = (layout) => {
    Object.assign(layout, {
      paper_bgcolor: clear,
      plot_bgcolor: clear,
      font: { family: "system-ui, sans-serif", size: 12, color: ink },
      hovermode: layout.hovermode || "x",
      modebar: { bgcolor: clear, color: soft, activecolor: ink },
      legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom", itemwidth: 30, font: { size: 11 } },
      dragmode: touch ? false : "zoom",
    });
    if (layout.coloraxis) layout.coloraxis.colorscale = "Viridis";
    for (const name of Object.keys(layout).filter((one) => /^[xy]axis/.test(one))) {
      const own = name.startsWith("x") ? { zeroline: false, hoverformat: ".2f" } : { nticks: 6 };
      layout[name] = { gridcolor: grid, zerolinecolor: soft, ...own, ...layout[name] };
    }
    return layout;
  };

  const draw = (data) => {
    const still = data.previousElementSibling;
    const live = document.createElement("div");
    live.className = "zoomed";
    live.setAttribute("role", "group");
    live.setAttribute("aria-label", still.getAttribute("aria-label") || "");
    const { data: traces, layout } = JSON.parse(data.textContent);
    live.style.height = `${layout.height}px`;
    data.after(live);
    still.classList.add("replaced");
    window.Plotly.newPlot(live, traces, styled(layout), config).catch((error) => {
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
