// A deployment in space: drag to turn, slide or play along time, in step with the cursor of the curves beside it.
"use strict";
document.querySelectorAll(".scene").forEach((root) => {
  const D = JSON.parse(root.querySelector("script").textContent), canvas = root.querySelector("canvas"), slider = root.querySelector("input[type=range]");
  const clock = root.querySelector("output"), play = root.querySelector(".play"), choice = root.querySelector("select:not(.speed)");
  let frame = 0, playing = false, last = 0, at = 0, turn = -0.6, tilt = 0.35, near = 1;
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const model = () => D.models[choice ? Number(choice.value) : 0];
  const rotated = (q, p) => {  // v + 2 w (u x v) + 2 u x (u x v)
    const [w, x, y, z] = q, [a, b, c] = p, s = [y * c - z * b, z * a - x * c, x * b - y * a];
    return [a + 2 * (w * s[0] + y * s[2] - z * s[1]), b + 2 * (w * s[1] + z * s[0] - x * s[2]), c + 2 * (w * s[2] + x * s[1] - y * s[0])];
  };
  const placed = (place, q) => D.joints.map((joint) => rotated(q, joint).map((v, k) => v + place[k]));
  const around = (points) => {
    const m = [0, 1].map((k) => points.reduce((sum, p) => sum + p[k], 0) / points.length);
    return points.map((_, i) => i).sort((i, j) => Math.atan2(points[i][1] - m[1], points[i][0] - m[0]) - Math.atan2(points[j][1] - m[1], points[j][0] - m[0]));
  };
  const ORDER = around(D.joints), BASE = around(D.base);
  function draw() {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight, g = canvas.getContext("2d");
    if (!width) return;
    canvas.width = width * ratio; canvas.height = height * ratio; g.setTransform(ratio, 0, 0, ratio, 0, 0); g.font = "12px system-ui, sans-serif";
    const c = Math.cos(turn), s = Math.sin(turn), ct = Math.cos(tilt), st = Math.sin(tilt), scale = near * 0.42 * Math.min(width, height) / D.size;
    const project = ([x, y, z]) => {
      const a = c * x - s * y, b = s * x + c * y, h = z - D.middle, f = scale * 4 * D.size / (4 * D.size + ct * b + st * h);
      return [width / 2 + f * a, height / 2 - f * (ct * h - st * b)];
    };
    const line = (points, stroke, wide, closed, fill) => {
      g.beginPath(); points.forEach(([x, y], i) => (i ? g.lineTo(x, y) : g.moveTo(x, y)));
      if (closed) g.closePath();
      if (fill) { g.globalAlpha = 0.2; g.fillStyle = fill; g.fill(); g.globalAlpha = 1; }
      g.strokeStyle = stroke; g.lineWidth = wide; g.stroke();
    };
    const M = model(), q = M.quaternion[frame], quiet = colour("--quiet");
    line(BASE.map((i) => project(D.base[i])), quiet, 1.5, true, quiet);
    line(ORDER.map((i) => project(placed([0, 0, D.stowed], [1, 0, 0, 0])[i])), colour("--rule"), 1, true);
    if (q[0] === null) { g.fillStyle = colour("--bad"); g.fillText("the run has diverged", 12, 20); return; }
    const joints = placed(M.place[frame], q), most = Math.max(1e-9, ...M.force[frame].map(Math.abs)), ink = colour(M.colour);
    joints.forEach((joint, i) => {
      line([project(D.base[i]), project(joint)], ink, 1.2 + 2.8 * Math.max(0, M.force[frame][i]) / most);
      const [x, y] = project(D.base[i]); g.fillStyle = quiet; g.fillText(i + 1, x + 5, y + 13);
    });
    line(ORDER.map((i) => project(joints[i])), ink, 2, true, ink);
    const seen = D.measured && D.measured.place[frame];
    if (seen) line(ORDER.map((i) => project(placed(seen, D.measured.quaternion[frame])[i])), colour("--measured"), 2, true);
  }
  function legs() {
    const table = root.querySelector("table tbody");
    if (!table || !D.lengths) return;
    const row = (name, values, digits) => `<tr><th scope="row">${name}</th>${values.map((v) => `<td class="n">${v === null ? "" : v.toFixed(digits)}</td>`).join("")}</tr>`;
    table.innerHTML = row("length, mm", D.lengths[frame].map((v) => (v === null ? null : 1e3 * v)), 1) + row("force, N", model().force[frame], 3);
  }
  function show(next) {
    frame = Math.max(0, Math.min(D.time.length - 1, next)); slider.value = frame; clock.textContent = `${D.time[frame].toFixed(3)} s`;
    draw(); legs(); root.dataset.frame = frame;
  }
  const frameAt = (t) => Math.max(0, D.time.findLastIndex((v) => v <= t + 1e-9));
  function run(now) {
    if (!playing) return;
    at += (now - last) / 1000 * Number(root.querySelector(".speed") ? root.querySelector(".speed").value : 0.1); last = now;
    if (at > D.time[D.time.length - 1]) { playing = false; play.textContent = "play"; at = D.time[D.time.length - 1]; }
    show(frameAt(at)); requestAnimationFrame(run);
  }
  play.onclick = () => {
    playing = !playing; play.textContent = playing ? "pause" : "play";
    if (playing) { at = frame === D.time.length - 1 ? 0 : D.time[frame]; last = performance.now(); requestAnimationFrame(run); }
  };
  slider.max = D.time.length - 1;
  slider.oninput = () => { playing = false; play.textContent = "play"; show(Number(slider.value)); };
  if (choice) choice.onchange = () => show(frame);
  document.addEventListener("cursor", (event) => { if (event.detail.link === D.link && event.detail.x !== null) show(frameAt(event.detail.x - D.begin)); });
  canvas.onpointermove = (event) => { if (event.buttons) { turn += event.movementX / 150; tilt = Math.max(-1.5, Math.min(1.5, tilt + event.movementY / 150)); draw(); } };
  canvas.onwheel = (event) => { if (event.ctrlKey) { event.preventDefault(); near *= Math.exp(-event.deltaY / 600); draw(); } };
  window.addEventListener("resize", draw);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  const asked = /t=([0-9.]+)/.exec(location.hash);
  show(frameAt(asked ? Number(asked[1]) : D.shown));
});
