"use strict";
/* The project file (TOML) of what was chosen, and the same as options of the command. */
function tomlValue(value) {
  if (typeof value === "string") return JSON.stringify(value).replace(/\u007f/g, "\\u007f");
  if (Array.isArray(value)) return `[${value.map(tomlValue).join(", ")}]`;
  return String(value);
}

function tomlText(project) {
  const lines = [`schema = ${project.schema ?? 1}`];
  for (const [section, keys] of Object.entries(project)) {
    if (typeof keys !== "object" || keys === null || !Object.keys(keys).length) continue;
    lines.push("", `[${section}]`);
    for (const [key, value] of Object.entries(keys)) {
      if (key !== "place_px") lines.push(`${key} = ${tomlValue(value)}`);
      else lines.push("place_px = [", ...value.map((place) => `    ${tomlValue(place)},`), "]");
    }
  }
  return lines.join("\n") + "\n";
}

const OPTIONS = {
  film: { fps: "--fps", from_s: "--from", to_s: "--to", fields: "--fields" },
  marks: { place_px: "--mark", subset_px: "--subset", warp: "--warp" },
  scale: { mm_per_px: "--mm-per-px", from_px_mm: "--scale-from", rule_px_mm: "--rule", plumb_px: "--plumb", up_deg: "--up" },
  platform: { start_height_m: "--start-height-m", radius_m: "--radius-m" },
  camera: { distance_m: "--distance-m", readout_s: "--readout-s" },
};

function optionWords(project) {
  const words = [], left = [];
  for (const [section, keys] of Object.entries(project)) {
    if (typeof keys !== "object" || keys === null) continue;
    for (const [key, value] of Object.entries(keys)) {
      const option = (OPTIONS[section] || {})[key];
      if (section === "film" && key === "file") continue;
      if (!option) left.push(`${section}.${key}`);
      else if (key === "place_px") words.push(...value.map((place) => `${option}=${place.join(",")}`));
      else if (key === "fields") words.push(...(value ? [option] : []));
      else words.push(`${option}=${Array.isArray(value) ? value.join(",") : value}`);
    }
  }
  return [words.join(" "), left];
}
