"use strict";
const data = JSON.parse(document.getElementById("data").textContent), at = (id) => document.getElementById(id);
const W = Math.max(at("curves").clientWidth, 280), H = 110, LEFT = 56, BOTTOM = 18, frames = data.time_s.length;
const images = new Map();
let now = 0, timer = null;
const view = new View(at("picture"), data.width, data.height, paint);
view.tool = { down() { return null; }, click() {} };

function frame() { return data.pictures[now].frame; }
function paint(c, v) {
  if (!data.pictures.length) return;
  const k = frame(), half = data.subset / 2;
  c.font = "12px system-ui, sans-serif";
  data.names.forEach((name, i) => {
    if (data.x[i][k] === null) return;
    const [x, y] = v.screen([data.x[i][k], data.y[i][k]]), r = half * v.scale, residual = data.residual?.[i][k];
    c.lineWidth = 2; c.strokeStyle = data.colours[data.status[i][k]]; c.strokeRect(x - r, y - r, 2 * r, 2 * r);
    if (residual && residual[0] !== null) {
      const limit = 4 * half, [dx, dy] = residual.map((d) => Math.max(-limit, Math.min(limit, data.enlarged * d)) * v.scale);
      c.strokeStyle = data.residual_colour; c.beginPath(); c.moveTo(x, y); c.lineTo(x + dx, y + dy); c.stroke();
    }
    c.lineWidth = 3; c.strokeStyle = "#000b"; c.strokeText(name, x - r, y - r - 3); c.fillStyle = "#fff"; c.fillText(name, x - r, y - r - 3);
  });
}
async function go(k) {
  now = Math.max(0, Math.min(k, data.pictures.length - 1));
  const wanted = now, one = data.pictures[now], t = data.time_s[one.frame];
  at("frame").value = now;
  at("said").textContent = `${data.first + one.frame}, ${t.toFixed(5).replace(/0+$/, "0")} s`;
  at("frame").setAttribute("aria-valuetext", at("said").textContent);
  const others = data.names.map((name, i) => [name, data.status[i][one.frame]]).filter(([, word]) => word !== "ok").map((pair) => pair.join(" "));
  const values = data.curves.slice(0, 8).map((curve) => curve.values[one.frame] === null ? null : `${curve.label.split(",")[0]} ${curve.values[one.frame].toPrecision(5)}${curve.label.slice(curve.label.indexOf(",") + 1)}`).filter((text) => text);
  at("now").textContent = [...values, ...others].join("; ");
  for (const line of document.querySelectorAll(".now")) { line.setAttribute("x1", across(t)); line.setAttribute("x2", across(t)); }
  if (!images.has(one.frame)) images.set(one.frame, await pictureOf(one.src));
  if (wanted === now) view.show(images.get(one.frame));
}
function across(t) { return LEFT + (W - LEFT - 6) * (t - data.time_s[0]) / Math.max(data.time_s[frames - 1] - data.time_s[0], 1e-12); }
function short(value) { return Math.abs(value) >= 1e4 || (Math.abs(value) < 1e-3 && value) ? value.toExponential(1) : String(Number(value.toPrecision(4))); }

function drawn(curve) {
  const low = (v, k) => v - (curve.band?.[k] ?? 0), high = (v, k) => v + (curve.band?.[k] ?? 0), seen = curve.values.map((v, k) => [v, k]).filter(([v]) => v !== null);
  const svg = element("svg", { class: "chart", viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": curve.label });
  if (!seen.length) { svg.append(element("text", { x: LEFT, y: 20 }, `${curve.label}: not observed`)); return svg; }
  const least = Math.min(...seen.map(([v, k]) => low(v, k))), most = Math.max(...seen.map(([v, k]) => high(v, k))), span = most - least || 1;
  const y = (v) => 16 + (H - BOTTOM - 18) * (most - v) / span, x = (k) => across(data.time_s[k]).toFixed(1);
  const path = (of, ways) => ways.map(([v, k], n) => `${n && ways[n - 1][1] === k - 1 ? "L" : "M"}${x(k)} ${y(of(v, k)).toFixed(1)}`).join("");
  const runs = seen.reduce((all, one) => { const last = all.at(-1); if (last && last.at(-1)[1] === one[1] - 1) last.push(one); else all.push([one]); return all; }, []);
  if (curve.band) svg.append(element("path", { class: "band", d: runs.map((run) => `M${run.map(([v, k]) => `${x(k)} ${y(high(v, k)).toFixed(1)}`).join("L")}L${run.toReversed().map(([v, k]) => `${x(k)} ${y(low(v, k)).toFixed(1)}`).join("L")}Z`).join("") }));
  svg.append(element("line", { class: "axis", x1: LEFT, x2: W - 6, y1: H - BOTTOM, y2: H - BOTTOM }), element("path", { class: "curve", d: path((v) => v, seen) }));
  svg.append(element("text", { x: LEFT, y: 11 }, curve.label));
  for (const [v, where] of [[most, y(most) + 4], [least, y(least) + 4]]) svg.append(element("text", { x: LEFT - 5, y: where, "text-anchor": "end" }, short(v)));
  for (const k of [0, frames - 1]) svg.append(element("text", { x: x(k), y: H - 4, "text-anchor": k ? "end" : "start" }, short(data.time_s[k])));
  svg.append(element("line", { class: "now", x1: LEFT, x2: LEFT, y1: 14, y2: H - BOTTOM }));
  svg.addEventListener("click", (e) => {
    const box = svg.getBoundingClientRect(), t = data.time_s[0] + (W * (e.clientX - box.left) / box.width - LEFT) / (W - LEFT - 6) * (data.time_s[frames - 1] - data.time_s[0]);
    go(data.pictures.reduce((best, one, k) => Math.abs(data.time_s[one.frame] - t) < Math.abs(data.time_s[data.pictures[best].frame] - t) ? k : best, 0));
  });
  return svg;
}
function strips() {
  for (const svg of document.querySelectorAll(".strip")) {
    const status = data.status[svg.dataset.mark], width = 200 / frames;
    for (let k = 0, end = 0; k < frames; k = end) {
      for (end = k; end < frames && status[end] === status[k]; end++);
      svg.append(element("rect", { x: k * width, width: (end - k) * width, y: 0, height: 10, fill: data.colours[status[k]] }));
    }
  }
}
function play() {
  if (timer) { clearInterval(timer); timer = null; } else timer = setInterval(() => go((now + 1) % data.pictures.length), 80);
  at("play").setAttribute("aria-pressed", timer !== null); at("play").textContent = timer ? "Stop" : "Play";
}

at("curves").append(...data.curves.map(drawn));
strips();
at("frame").max = Math.max(data.pictures.length - 1, 0);
at("frame").addEventListener("input", () => go(Number(at("frame").value)));
at("play").addEventListener("click", play);
at("closer").addEventListener("click", () => view.zoom(1.5)); at("farther").addEventListener("click", () => view.zoom(1 / 1.5)); at("whole").addEventListener("click", () => view.fit());
at("picture").addEventListener("keydown", (e) => {
  const step = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
  if (step) go(now + step); else if (e.key === "+" || e.key === "=") view.zoom(1.25); else if (e.key === "-") view.zoom(0.8); else return;
  e.preventDefault();
});
if (data.pictures.length) go(0).then(() => { document.documentElement.dataset.ready = "yes"; });
