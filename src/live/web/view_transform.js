// Scene-linear light as a display shows it: what image/view_transform.cpp does for previews (there: sources of the curves).
// tests/live/view_transform_test.cpp holds the two together.
'use strict';

/** sRGB of [0, 1] in 65536 steps, in each of which it changes by less than 0.0002. */
const srgbTable = new Float32Array(65537);
for (let i = 0; i <= 65536; ++i) {
  const x = i / 65536;
  srgbTable[i] = x <= 0.0031308 ? 12.92 * x : 1.055 * Math.pow(x, 1 / 2.4) - 0.055;
}
const encodeSrgb = (x) => srgbTable[x > 0 ? Math.min(65536, Math.round(65536 * x)) : 0];
const bounded = (x) => x > 0 ? Math.min(x, 1e6) : 0;

const agxInset = [0.842479062253094, 0.0423282422610123, 0.0423756549057051, 0.0784335999999992, 0.878468636469772, 0.0784336,
  0.0792237451477643, 0.0791661274605434, 0.879142973793104];  // by columns
const agxOutset = (() => {
  const m = agxInset, minor = (a, b, c, d) => m[a] * m[d] - m[b] * m[c];
  const adjugate = [minor(4, 7, 5, 8), -minor(1, 7, 2, 8), minor(1, 4, 2, 5), -minor(3, 6, 5, 8), minor(0, 6, 2, 8), -minor(0, 3, 2, 5),
    minor(3, 6, 4, 7), -minor(0, 6, 1, 7), minor(0, 3, 1, 4)];
  const determinant = m[0] * adjugate[0] + m[3] * adjugate[1] + m[6] * adjugate[2];
  return adjugate.map((x) => x / determinant);
})();
/** Of a light by stops between the least and the most that the curve has. */
function agxCurve(light) {
  const stops = Math.log2(Math.max(light, 1e-10)), x = Math.min(1, Math.max(0, (stops + 12.47393) / (4.026069 + 12.47393)));
  const x2 = x * x, x4 = x2 * x2;
  return 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
}

/** By name: takes linear red, green, blue and leaves what the display gets, each in [0, 1], in `out`. */
const viewTransforms = {
  standard(r, g, b, out) {
    out[0] = encodeSrgb(r);
    out[1] = encodeSrgb(g);
    out[2] = encodeSrgb(b);
  },
  neutral(r, g, b, out) {
    r = bounded(r);
    g = bounded(g);
    b = bounded(b);
    const fresnel = 0.04, from = 0.8 - fresnel, least = Math.min(r, g, b);
    const taken = least < 2 * fresnel ? least - least * least / (4 * fresnel) : fresnel;
    r -= taken;
    g -= taken;
    b -= taken;
    const peak = Math.max(r, g, b);
    if (peak >= from) {
      const room = 1 - from, reached = 1 - room * room / (peak + room - from), white = 1 - 1 / (0.15 * (peak - reached) + 1);
      const mix = (x) => x * reached / peak * (1 - white) + reached * white;
      r = mix(r);
      g = mix(g);
      b = mix(b);
    }
    viewTransforms.standard(r, g, b, out);
  },
  agx(r, g, b, out) {
    r = bounded(r);
    g = bounded(g);
    b = bounded(b);
    const i = agxInset, o = agxOutset;
    const x = agxCurve(i[0] * r + i[3] * g + i[6] * b), y = agxCurve(i[1] * r + i[4] * g + i[7] * b), z = agxCurve(i[2] * r + i[5] * g + i[8] * b);
    for (let c = 0; c < 3; ++c) out[c] = Math.min(1, Math.max(0, o[c] * x + o[c + 3] * y + o[c + 6] * z));
  },
};
