// Curves of a page: a cursor that all figures of one kind share, zoom, and curves that can be put away. The numbers are those of the CSV links.
"use strict";
window.onerror = (message) => { document.body.dataset.error = message; };
const FIGURES = [...document.querySelectorAll("figure.figure")].map((node) => ({
  node, link: node.dataset.link || node.dataset.name, plots: [...node.querySelectorAll(".plot")],
  whole: node.querySelector(".plot").dataset.x.split(" ").map(Number), shown: null, table: null,
}));

const tableOf = (figure) => {  // columns of the CSV, read when they are first asked for
  if (!figure.table) {
    const text = decodeURIComponent(figure.node.querySelector("a.csv").href.split(",").slice(1).join(","));
    const rows = text.trim().split("\n").slice(1).map((line) => line.split(",").map((cell) => (cell === "" ? NaN : Number(cell))));
    figure.table = rows.length ? rows[0].map((_, k) => rows.map((row) => row[k])) : [];
  }
  return figure.table;
};
const stepOf = (least) => { const power = 10 ** Math.floor(Math.log10(least)); return [1, 2, 5, 10].map((f) => f * power).find((s) => s >= least * (1 - 1e-9)); };
const ticksBetween = (low, high, most) => {
  const step = stepOf((high - low) / most), digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), found = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= Math.floor(high / step + 1e-9); k += 1) found.push([(k * step - low) / (high - low), (k * step).toFixed(digits)]);
  return found;
};
const rangeOf = (plot) => plot.dataset.y.split(" ").map(Number);

function heights(figure, plot, low, high) {  // what a panel's visible curves span between two places
  let least = Infinity, most = -Infinity;
  plot.querySelectorAll("path[data-columns]:not(.off):not(.filled)").forEach((path) => {
    const [i, j] = path.dataset.columns.split(" ").map(Number), xs = tableOf(figure)[i], ys = tableOf(figure)[j];
    xs.forEach((x, k) => { if (x >= low && x <= high && Number.isFinite(ys[k])) { least = Math.min(least, ys[k]); most = Math.max(most, ys[k]); } });
  });
  const whole = rangeOf(plot), room = 0.06 * (most - least) || 0.05 * (whole[1] - whole[0]);
  return most >= least ? [least - room, most + room] : whole;
}
function zoom(figure, shown) {
  figure.shown = shown;
  const [low, high] = shown || figure.whole, span = figure.whole[1] - figure.whole[0];
  figure.plots.forEach((plot, place) => {
    const svg = plot.querySelector("svg"), whole = rangeOf(plot), [bottom, top] = shown ? heights(figure, plot, low, high) : whole, tall = whole[1] - whole[0];
    const left = 1e4 * (low - figure.whole[0]) / span, upper = 1e4 * (whole[1] - top) / tall;
    svg.setAttribute("viewBox", `${left} ${upper} ${1e4 * (high - low) / span} ${1e4 * (top - bottom) / tall}`);
    const along = ticksBetween(low, high, 7), up = ticksBetween(bottom, top, 5);
    plot.querySelector(".up").innerHTML = up.map(([share, text]) => `<span style="bottom:${100 * share}%">${text}</span>`).join("");
    if (place === figure.plots.length - 1) plot.querySelector(".along").innerHTML = along.map(([share, text]) => `<span style="left:${100 * share}%">${text}</span>`).join("");
    const across = along.map(([share]) => `<path d="M${left + share * 1e4 * (high - low) / span} -90000v190000"/>`);
    const lying = up.map(([share]) => `<path d="M-90000 ${upper + (1 - share) * 1e4 * (top - bottom) / tall}h190000"/>`);
    svg.querySelector(".grid").innerHTML = [...across, ...lying].join("");
  });
  figure.node.querySelector(".whole").hidden = !shown;
}
const linked = (figure) => FIGURES.filter((other) => other.link === figure.link);
const zoomAll = (figure, shown) => linked(figure).forEach((other) => zoom(other, shown));

function nearest(xs, x) {
  let best = -1, away = Infinity;
  xs.forEach((v, k) => { const d = Math.abs(v - x); if (d < away) { away = d; best = k; } });
  return best;
}
function point(figure, x) {  // put the cursor at a place of all linked figures, and say what the curves are there
  linked(figure).forEach((other) => {
    const along = 1e4 * (x - other.whole[0]) / (other.whole[1] - other.whole[0]);
    other.node.querySelectorAll("path.cursor").forEach((path) => path.setAttribute("d", x === null ? "" : `M${along} -90000v190000`));
    other.node.querySelectorAll(".legend button").forEach((button) => {
      const path = other.plots.flatMap((plot) => [...plot.querySelectorAll("path[data-columns]:not(.filled):not(.off)")]).find((one) => one.dataset.name === button.dataset.name);
      const table = x === null || !path ? null : tableOf(other), [i, j] = table ? path.dataset.columns.split(" ").map(Number) : [0, 0];
      const value = table ? table[j][nearest(table[i], x)] : NaN;
      button.querySelector("output").textContent = Number.isFinite(value) ? Number(value.toPrecision(4)) : "";
    });
  });
  document.dispatchEvent(new CustomEvent("cursor", { detail: { link: figure.link, x } }));
}

FIGURES.forEach((figure) => {
  const place = (plot, event) => {
    const box = plot.querySelector("svg").getBoundingClientRect(), [low, high] = figure.shown || figure.whole;
    return low + (high - low) * Math.max(0, Math.min(1, (event.clientX - box.left) / box.width));
  };
  figure.plots.forEach((plot) => {
    const svg = plot.querySelector("svg");
    let from = null;
    svg.addEventListener("pointermove", (event) => { point(figure, place(plot, event)); });
    svg.addEventListener("pointerleave", () => { if (from === null) point(figure, null); });
    svg.addEventListener("pointerdown", (event) => { from = place(plot, event); if (event.pointerType === "mouse") svg.setPointerCapture(event.pointerId); });
    svg.addEventListener("pointercancel", () => { from = null; });
    svg.addEventListener("pointerup", (event) => {
      const to = place(plot, event), [low, high] = figure.shown || figure.whole;
      if (from !== null && Math.abs(to - from) > 0.02 * (high - low)) zoomAll(figure, [Math.min(from, to), Math.max(from, to)]);
      from = null;
    });
    svg.addEventListener("dblclick", () => zoomAll(figure, null));
  });
  const first = figure.plots[0].querySelector("svg");
  first.setAttribute("tabindex", "0");
  let at = null;
  first.addEventListener("keydown", (event) => {  // arrows move the cursor, + and - zoom about it, Escape shows all again
    const [low, high] = figure.shown || figure.whole, middle = at === null ? (low + high) / 2 : at;
    if (event.key === "ArrowLeft" || event.key === "ArrowRight") at = Math.max(low, Math.min(high, middle + (event.key === "ArrowLeft" ? -1 : 1) * (high - low) / 100));
    else if (event.key === "+" || event.key === "-") {
      const half = (high - low) * (event.key === "+" ? 0.25 : 1), wide = [Math.max(figure.whole[0], middle - half), Math.min(figure.whole[1], middle + half)];
      zoomAll(figure, wide[0] === figure.whole[0] && wide[1] === figure.whole[1] ? null : wide);
    } else if (event.key === "Escape") zoomAll(figure, null);
    else return;
    event.preventDefault();
    if (at !== null) point(figure, at);
  });
  figure.node.querySelector(".whole").onclick = () => zoomAll(figure, null);
  figure.node.querySelectorAll(".legend button").forEach((button) => {
    button.onclick = () => {
      const gone = button.getAttribute("aria-pressed") === "true";
      button.setAttribute("aria-pressed", String(!gone));
      figure.node.querySelectorAll(".plot path").forEach((path) => { if (path.dataset.name === button.dataset.name) path.classList.toggle("off", gone); });
    };
  });
});
