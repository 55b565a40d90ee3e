"use strict";
/* How well a subset can be found again: the standard deviation of its shift along the poorer direction of its texture,

     s = sqrt(2) noise / sqrt(smaller eigenvalue of sum [fx fx, fx fy; fx fy, fy fy])

   f: grey values, blurred by 0.6 px. The command refuses a place where s at its assumed noise is above 0.1 px. */
class Texture {
  constructor(image, data) {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { width: image.width, height: image.height });
    const c = canvas.getContext("2d", { willReadFrequently: true });
    c.drawImage(image, 0, 0);
    const pixels = c.getImageData(0, 0, image.width, image.height).data;
    this.width = image.width; this.height = image.height;
    this.noise = data.noise; this.assumed = data.assumed_noise;
    const grey = new Float32Array(image.width * image.height).map((_, k) => pixels[4 * k] * data.level);
    this.raw = grey;
    this.grey = this.along(this.along(grey, 1), image.width);
  }
  along(from, step) {
    const to = Float32Array.from(from);
    for (let k = step; k < from.length - step; k++) to[k] = 0.64 * from[k] + 0.18 * (from[k - step] + from[k + step]);
    return to;
  }
  slope(k, step) { return (8 * (this.grey[k + step] - this.grey[k - step]) - (this.grey[k + 2 * step] - this.grey[k - 2 * step])) / 12; }
  rated([x, y], subset) {
    const half = (subset - 1) / 2, column = Math.round(x), row = Math.round(y);
    if (!(half <= column && column < this.width - half && half <= row && row < this.height - half)) return { word: "reaches over the border", use: false };
    let xx = 0, xy = 0, yy = 0, sum = 0, squares = 0;
    for (let j = row - half; j <= row + half; j++)
      for (let i = column - half; i <= column + half; i++) {
        const k = j * this.width + i, inside = i > 1 && j > 1 && i < this.width - 2 && j < this.height - 2;
        const fx = inside ? this.slope(k, 1) : 0, fy = inside ? this.slope(k, this.width) : 0;
        xx += fx * fx; xy += fx * fy; yy += fy * fy; sum += this.raw[k]; squares += this.raw[k] ** 2;
      }
    const weakest = Math.max(0.5 * (xx + yy) - Math.hypot(0.5 * (xx - yy), xy), 1e-9), n = subset * subset;
    const contrast = Math.sqrt(Math.max(squares / n - (sum / n) ** 2, 0)), sigma = Math.SQRT2 * this.noise / Math.sqrt(weakest);
    if (contrast < 2 * this.assumed || Math.SQRT2 * this.assumed / Math.sqrt(weakest) > 0.1) return { word: "too little texture", sigma, use: false };
    return { word: sigma <= 0.01 ? "good" : sigma <= 0.03 ? "fair" : "poor", sigma, use: true };
  }
}
