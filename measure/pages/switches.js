// Switches that choose which curves a page shows, and when the page was made.
"use strict";
const SWITCHES = [...document.querySelectorAll(".switches input[data-switch]")];
function chosen() {
  const state = SWITCHES.map((one) => (one.checked ? "1" : "0")).join("");
  document.querySelectorAll("[data-when]").forEach((node) => {
    const put = node.closest("figure") && node.tagName === "path" && [...node.closest("figure").querySelectorAll(".legend button")].some((b) => b.dataset.name === node.dataset.name && b.getAttribute("aria-pressed") === "false");
    node.classList.toggle("off", node.dataset.when !== state || Boolean(put));
  });
  document.body.dataset.state = state;
}
SWITCHES.forEach((one) => { one.onchange = chosen; });
if (SWITCHES.length) chosen();
const MADE = document.querySelector(".made");
if (MADE && location.protocol === "file:") {
  MADE.hidden = false;
  MADE.querySelector("dd").textContent = new Date(document.lastModified).toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "short" });
}
document.body.dataset.ready = "1";
