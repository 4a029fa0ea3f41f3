/** Colours in Oklab, where equal distances look equal (Ottosson 2020). */

/** Lightness in [0, 1], green–red, blue–yellow. */
export type Lab = readonly [number, number, number];
/** Amounts of light in [0, 1]: linear red, green and blue of the sRGB primaries. */
export type Light = readonly [number, number, number];

/** Halvings of the interval in which the largest chroma that a screen shows is looked for: finer than a byte. */
const HALVINGS = 12;

/** The light of a colour; outside [0, 1] where no screen shows it. */
function unclamped([lightness, a, b]: Lab): Light {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
}

const clamp = (x: number) => Math.min(1, Math.max(0, x));

export function light(lab: Lab): Light {
  const [r, g, b] = unclamped(lab);
  return [clamp(r), clamp(g), clamp(b)];
}

/** The colour of a lightness, a chroma and a hue in turns; what no screen shows loses chroma until one does. */
export function coloured(lightness: number, chroma: number, hue: number): Lab {
  const [a, b] = [Math.cos(2 * Math.PI * hue), Math.sin(2 * Math.PI * hue)];
  const at = (chroma: number): Lab => [lightness, chroma * a, chroma * b];
  const isShown = (lab: Lab) => unclamped(lab).every((x) => x >= -1e-6 && x <= 1 + 1e-6);
  if (isShown(at(chroma))) return at(chroma);
  let [low, high] = [0, chroma];
  for (let i = 0; i < HALVINGS; i++) {
    const middle = (low + high) / 2;
    if (isShown(at(middle))) low = middle;
    else high = middle;
  }
  return at(low);
}

export const grey = (lightness: number): Lab => [lightness, 0, 0];

/** The first colour with a share in [0, 1] of the second. */
export function mixed(a: Lab, b: Lab, share: number): Lab {
  return [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])];
}

/** Red, green and blue as a screen takes them, 0 to 255. */
export function bytes(lab: Lab): [number, number, number] {
  const [r, g, b] = light(lab).map((x) => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
  return [r as number, g as number, b as number];
}
