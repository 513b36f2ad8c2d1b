#include "scene/model/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "tress/fiber/parameter_ranges.h"

namespace tress::scene {
namespace {

using enum ValueKind;

constexpr Range of(const fiber::ParameterRange& range) { return {range.least, range.most}; }
/// A call and no braces: clang-format gives every field of a row with braces within it a line of its own.
constexpr Range in(double least, double most, bool least_open = false) { return {least, most, least_open}; }

constexpr Range none{0, 0}, share{0, 1}, factor{0, 1e6}, world{-world_cm, world_cm}, length{1e-3, world_cm};
constexpr Range turn{-360, 360}, light{0, 1e9}, sky{0, 1e6}, radius{1e-4, 1}, per_unit{1e-6, 1e6};
constexpr Range frames{-1e6, 1e6}, pixels{1, 65536}, seeds{0, past_int64}, half_range{0, 0.9};
constexpr Range accuracy{0, 1, true}, paths{1, 4096};
constexpr std::string_view degrees = "degrees", cm = "cm";

/// An array of C: clang allows no deduction from more than 256 elements.
constexpr Parameter table[] = {
    {"/$schema", "", text, none, "", "", "", "for editors: where schema.json is"},
    {"/camera/frame", "", flag, none, "", "", "true without `eye`",
     "the camera sees all grooms, from 8 degrees above; excludes `eye`, `look_at`, `up`"},
    {"/camera/turn_deg", "--turn", number, turn, degrees, "", "0",
     "side that the camera is on, counter-clockwise from above; 0: -y"},
    {"/camera/eye", "", triple, world, cm, "", "", "where the camera is"},
    {"/camera/look_at", "", triple, world, cm, "", "[0, 0, 0]", "the middle of the picture"},
    {"/camera/up", "", triple, world, "", "", "[0, 0, 1], straight up or down [0, 1, 0]",
     "the direction that is up in the picture"},
    {"/camera/vertical_fov_deg", "", number, in(0.1, 150), degrees, "", "30", "vertical angle of view"},
    {"/camera/focal_length_mm", "", number, in(1, 10000), "mm", "", "by `vertical_fov_deg`",
     "in place of the angle of view, by the sensor"},
    {"/camera/sensor_mm", "", number, in(1, 1000), "mm", "", "36", "width of the sensor behind the focal length"},
    {"/camera/sensor_fit", "", choice, none, "", "longer, width, height", "longer",
     "side of the picture that `sensor_mm` spans"},
    {"/camera/orthographic_height_cm", "", number, length, cm, "", "", "parallel rays, and the height of the picture"},
    {"/camera/shift_x", "", number, in(-10, 10), "", "", "0", "lens shift right, in picture widths"},
    {"/camera/shift_y", "", number, in(-10, 10), "", "", "0", "up, in picture heights"},
    {"/camera/depth_of_field/f_number", "", number, in(0.1, 1000), "", "", "this or `radius_cm`",
     "focal length over the lens's diameter; portraits 2 to 4"},
    {"/camera/depth_of_field/radius_cm", "", number, in(1e-4, 1000), cm, "", "", "radius of the lens"},
    {"/camera/depth_of_field/focus_cm", "", number, length, cm, "", "that of `look_at`",
     "distance of the sharp plane from the eye"},
    {"/camera/depth_of_field/focus_point", "", triple, world, cm, "", "",
     "in place of `focus_cm`: a point that is sharp in every frame"},
    {"/camera/depth_of_field/blades", "", whole, in(3, 64), "", "", "a round lens",
     "corners of the lens, a regular polygon"},
    {"/camera/depth_of_field/blade_rotation_deg", "", number, turn, degrees, "", "0",
     "turn of the polygon, counter-clockwise as bright points behind the focus show it; 0: a corner to the right"},
    {"/camera/frames/N/frame", "", whole, frames, "", "", "needed",
     "number of a keyframe, rising; linear between, held outside; with `eye` (needed), `look_at`, "
     "`up`, `vertical_fov_deg` or `focal_length_mm` as in `camera`"},
    {"/camera/turntable/frames", "", whole, in(1, 1e6), "", "", "needed",
     "frames of one turn; frame 0 is seen from -y"},
    {"/camera/turntable/turns", "", choice, none, "", "object, camera", "object",
     "object: grooms and meshes turn, clockwise from above; camera: it circles them "
     "counter-clockwise, through the lights"},
    {"/camera/turntable/look_at", "", triple, world, cm, "", "the middle of the hair",
     "the axis of the turn, and what the camera looks at"},
    {"/camera/turntable/distance_cm", "", number, length, cm, "", "all hair seen, from 8 degrees above",
     "from the vertical axis through `look_at`"},
    {"/camera/turntable/height_cm", "", number, world, cm, "", "0", "above `look_at`; beside `distance_cm`"},
    {"/camera/shutter", "--shutter", numbers_by_name, in(-10, 10), "frames", "open, close",
     "closed: nothing is blurred by its motion", "opens and closes, from the frame on: 0 and 0.5 are its first half"},
    {"/camera/motion_samples", "--motion-samples", whole, in(2, 64), "", "", "2",
     "moments of the open shutter, evenly spaced, at which what moves is read; straight between"},
    {"/camera/frames_per_second", "--fps", number, in(0.001, 100000), "", "", "as the file says, else 24",
     "of Alembic files, which count in seconds"},
    {"/image/width", "", whole, pixels, "", "", "512", "pixels; 2^26 in all at most"},
    {"/image/height", "", whole, pixels, "", "", "512", "pixels; 2^26 in all at most"},
    {"/image/samples", "--spp", whole, in(1, 1e6), "", "", "64", "samples a pixel"},
    {"/image/least_width", "--least-width", number, in(0, 100), "pixels", "", "0",
     "thinner strands are widened to it and let the rest of the light through: sparse hair has "
     "less noise"},
    {"/image/curve_error", "--curve-error", number, in(0.001, 100), "pixels", "", "0.1",
     "how far straight pieces may lie beside their curve; 4 to 16 a segment"},
    {"/image/transparent", "--transparent", flag, none, "", "", "false",
     "R, G, B without what is behind the hair, A its coverage; PNG too"},
    {"/image/exposure", "--exposure", number, in(-20, 20), "stops", "", "0",
     "scales the PNG by 2 to this; not the EXR"},
    {"/image/view", "--view", choice, none, "", "standard, neutral, agx", "standard",
     "how the PNG shows what is too bright: cut off; by Khronos PBR Neutral, which "
     "compresses highlights; by AgX, like film. Not the EXR"},
    {"/integrator/max_depth", "--max-depth", whole, paths, "", "", "256", "hits of a path"},
    {"/integrator/light_samples", "--light-samples", whole, paths, "", "", "2",
     "samples of the lights at the first hit"},
    {"/integrator/bcsdf_samples", "--bcsdf-samples", whole, paths, "", "", "1",
     "samples of the fiber at the first hit"},
    {"/integrator/roulette", "--roulette", choice, none, "", "throughput, learned",
     "learned where rows learn, else throughput",
     "where paths end or part, without bias. learned: by the light to come, as earlier passes "
     "found it; throughput: by what they have lost, alike in crops"},
    {"/integrator/deep_light", "--deep-light", choice, none, "", "traced, learned", "traced",
     "light of hits deep in the hair. traced: by paths from there, without bias; learned: the mean of "
     "what earlier passes found there, and the path ends. Biased; the bias is reported with its error"},
    {"/integrator/deep_light_depth", "--deep-light-depth", whole, in(2, 1 << 20), "", "", "3",
     "a path's first hit that learned deep light answers"},
    {"/integrator/near", "--near", number_or_choice, in(0, 1e6), "", "nowhere, seen, touching, everywhere", "2",
     "hits traced from where the ray met the fiber, which rows do not know: where a fiber is wider than this, in "
     "pixels (all from twice on), and, but for small lights, where fibers touch and rows lose light; touching: at all "
     "that touch, for all lights, with more noise; seen: not where they touch; 0 is nowhere"},
    {"/integrator/adaptive", "--adaptive", flag, none, "", "", "with `--noise` and `--time`",
     "more samples where the picture is noisier, `samples` being their mean"},
    {"/integrator/spectral", "--spectral", flag, none, "", "", "false",
     "absorption by the spectra of melanin in place of three colors; the picture remains Rec. 709"},
    {"/environment/file", "", text, none, "", "", "",
     "path to an EXR or HDR (RGBE) picture; latitude-longitude, top row up"},
    {"/environment/constant", "", triple, sky, "", "", "", "linear RGB radiance from everywhere"},
    {"/environment/studio", "", only_true, none, "", "", "of `file`, `constant`, `studio`, `sky`",
     "soft key, rim and fill before a neutral background"},
    {"/environment/sky/zenith", "", triple, sky, "", "", "[0.18, 0.32, 0.7]",
     "linear RGB radiance; to the horizon's by the root of the elevation's sine"},
    {"/environment/sky/horizon", "", triple, sky, "", "", "[0.75, 0.82, 0.9]", "linear RGB radiance"},
    {"/environment/sky/ground", "", triple, sky, "", "", "[0.22, 0.2, 0.18]",
     "linear RGB radiance below the horizon; beside it `sun`, with the keys of `lights/N/distant`, turns and "
     "scales with the sky, unseen by the camera"},
    {"/environment/rotate_deg", "--rotate", number, turn, degrees, "", "0",
     "turn about the vertical, counter-clockwise from above"},
    {"/environment/frames/N/frame", "", whole, frames, "", "", "needed",
     "as `camera/frames/N/frame`; with `rotate_deg` (needed)"},
    {"/environment/scale", "", number, factor, "", "", "1", "factor of the radiance"},
    {"/environment/group", "", text, none, "", "", "", "as `lights/N/group`, for the environment and its sun"},
    {"/environment/light_link/include/N", "", text, none, "", "", "",
     "as in `lights/N`, also `exclude`, and `shadow_link`"},
    {"/environment_visible", "", flag, none, "", "", "true", "whether the environment shows behind the hair"},
    {"/lights/N/distant/direction", "", triple, world, "", "", "",
     "towards the light; or `azimuth_deg` and `elevation_deg`"},
    {"/lights/N/distant/azimuth_deg", "", number, turn, degrees, "", "0",
     "0 is -y, counter-clockwise from above (+x is 90)"},
    {"/lights/N/distant/elevation_deg", "", number, in(-90, 90), degrees, "", "0", "above the horizon"},
    {"/lights/N/distant/angle_deg", "", number, in(0.01, 180), degrees, "", "0.53",
     "full angular diameter; uniform within"},
    {"/lights/N/distant/radiance", "", triple, light, "", "", "this or `irradiance`",
     "linear RGB, the same in all its directions"},
    {"/lights/N/distant/irradiance", "", triple, light, "", "", "",
     "in place of `radiance`: linear RGB, across the direction"},
    {"/lights/N/sphere/center", "", triple, world, cm, "", "needed", "shines inwards too"},
    {"/lights/N/sphere/radius_cm", "", number, length, cm, "", "needed", "of the sphere"},
    {"/lights/N/sphere/radiance", "", triple, light, "", "", "needed", "linear RGB"},
    {"/lights/N/rectangle/center", "", triple, world, cm, "", "needed", "of the rectangle"},
    {"/lights/N/rectangle/look_at", "", triple, world, cm, "", "needed", "it shines to this side only"},
    {"/lights/N/rectangle/up", "", triple, world, "", "", "[0, 0, 1], level ones [0, 1, 0]", "where the height runs"},
    {"/lights/N/rectangle/width_cm", "", number, length, cm, "", "needed", "full edge"},
    {"/lights/N/rectangle/height_cm", "", number, length, cm, "", "needed", "full edge"},
    {"/lights/N/rectangle/radiance", "", triple, light, "", "", "needed", "linear RGB"},
    {"/lights/N/spot/center", "", triple, world, cm, "", "needed", "of a sphere that shines into a cone"},
    {"/lights/N/spot/look_at", "", triple, world, cm, "", "needed", "a point on the axis of the cone"},
    {"/lights/N/spot/radius_cm", "", number, length, cm, "", "1", "of the sphere: a large one softens shadows"},
    {"/lights/N/spot/cone_deg", "", number, in(0.1, 180), degrees, "", "45",
     "full angle of the cone, outside which it is dark"},
    {"/lights/N/spot/soft", "", number, share, "", "", "0.15",
     "share of the cone, in the cosine, over which light rises, 3 t^2 - 2 t^3"},
    {"/lights/N/spot/radiance", "", triple, light, "", "", "this or `irradiance`", "linear RGB, on the axis"},
    {"/lights/N/spot/irradiance", "", triple, light, "", "", "",
     "in place of `radiance`: linear RGB at `look_at`, across the axis"},
    {"/lights/N/scale", "", number, per_unit, "", "", "1",
     "of its place, edges and radius about the origin; not of its radiance"},
    {"/lights/N/rotate_deg", "", triple, turn, degrees, "", "[0, 0, 0]",
     "turns about x, then y, then z, after the scale"},
    {"/lights/N/translate", "", triple, world, cm, "", "[0, 0, 0]", "after the turn"},
    {"/lights/N/frames/N/frame", "", whole, frames, "", "", "needed", "as `meshes/N/frames/N/frame`"},
    {"/lights/N/visible", "", flag, none, "", "", "false", "whether the camera sees the light"},
    {"/lights/N/group", "", text, none, "", "", "",
     "layer `light.NAME` of all lights with it, 1 to 64 letters, digits, _ and -; the "
     "rest: `light.other`; 16 at most"},
    {"/lights/N/light_link/include/N", "", text, none, "", "", "all", "names of what the light illuminates"},
    {"/lights/N/light_link/exclude/N", "", text, none, "", "", "none",
     "in place of `include`: what it does not illuminate"},
    {"/lights/N/shadow_link/include/N", "", text, none, "", "", "all", "names of what casts shadows in it"},
    {"/lights/N/shadow_link/exclude/N", "", text, none, "", "", "none", "in place of `include`: what casts none"},
    {"/meshes/N/file", "", text, none, "", "", "needed",
     "path to an OBJ file, seen from both sides; ####: the frame's number"},
    {"/meshes/N/name", "", text, none, "", "", "of the file", "its name in mattes; equal names are one matte"},
    {"/meshes/N/up", "", choice, none, "", "y, z", "z", "axis of the file that points up; y becomes z, z becomes -y"},
    {"/meshes/N/cm_per_unit", "", number, per_unit, cm, "", "1", "length of a unit of the file"},
    {"/meshes/N/scale", "", number, per_unit, "", "", "1", "of the whole mesh, after the above"},
    {"/meshes/N/rotate_deg", "", triple, turn, degrees, "", "[0, 0, 0]",
     "turns about x, then y, then z, after the scale"},
    {"/meshes/N/translate", "", triple, world, cm, "", "[0, 0, 0]", "after the turn"},
    {"/meshes/N/frames/N/frame", "", whole, frames, "", "", "needed",
     "as `camera/frames/N/frame`; with `scale`, `rotate_deg`, `translate`, else the mesh's"},
    {"/meshes/N/albedo", "", triple, share, "", "", "[0.18, 0.18, 0.18]",
     "linear RGB of the diffuse surface; or `albedo_file`"},
    {"/meshes/N/albedo_file", "", text, none, "", "", "",
     "path to a PNG (sRGB) or EXR (linear) over the OBJ's texture coordinates: (0, 0) is its lower "
     "left corner; repeated"},
    {"/meshes/N/coat/roughness", "", number, in(0.03, 1), "", "", "0.3",
     "of a clear coat: skin 0.3 to 0.5, lacquer 0.1; its square is the width of GGX"},
    {"/meshes/N/coat/eta", "", number, in(1.01, 2.5), "", "", "1.5", "its index of refraction; skin 1.4"},
    {"/meshes/N/visible", "", flag, none, "", "", "true", "whether the camera sees it"},
    {"/meshes/N/casts_shadow", "", flag, none, "", "", "true", "whether it stands in the way of lights"},
    {"/meshes/N/visible_indirect", "", flag, none, "", "", "true", "whether others get the light that it reflects"},
    {"/meshes/N/holdout", "", flag, none, "", "", "false", "black and alpha 0 where it is, for it and what is behind"},
    {"/materials/N/name", "", text, none, "", "", "material N", "distinct; grooms refer to it"},
    {"/materials/N/eta", "", number, of(fiber::eta_range), "", "", "1.55", "index of refraction"},
    {"/materials/N/eccentricity", "--eccentricity", number, of(fiber::eccentricity_range), "", "", "0.85",
     "minor over major semi-axis of the cross-section; not along strands", true},
    {"/materials/N/roughness", "--roughness", number, of(fiber::roughness_range), "", "", "0.2",
     "Beckmann roughness of the surface", true},
    {"/materials/N/presence", "", number, share, "", "", "1", "how likely a ray is to meet a strand that it comes to",
     true},
    {"/materials/N/thickness", "", number, in(0, 10), "", "", "1", "factor of the radii, beside `taper`", true},
    {"/materials/N/tilt_deg", "--cuticle-tilt", number, of(fiber::tilt_range_deg), degrees, "", "3",
     "tilt of the cuticle scales", true},
    {"/materials/N/color", "--color", either, in(0.001, 0.999), "", "file", "",
     "linear RGB that a dense lock shows in even light; \"file\": the file's; at most one of `color`, "
     "`hair`, `melanin`, `sigma_a`",
     true},
    {"/materials/N/hair", "--hair", choice, none, "",
     "black, dark brown, brown, light brown, auburn, red, blond, platinum, white, grey", "", "natural color by name",
     true},
    {"/materials/N/melanin", "--melanin", numbers_by_name, in(0, 100), "", "eumelanin, pheomelanin",
     "0 each; without any color eumelanin 1.3", "concentrations of eumelanin and pheomelanin", true},
    {"/materials/N/dye", "", triple, share, "", "", "[1, 1, 1]",
     "a dye over `melanin` or `hair`, linear RGB: color of a dense dyed lock of white hair; its "
     "absorption adds to theirs",
     true},
    {"/materials/N/sigma_a", "--sigma-a", triple, of(fiber::sigma_a_range), "", "", "",
     "absorption, RGB, per major semi-axis", true},
    {"/SOURCE/ramp", "", number, in(0, 1e6), "", "", "", "places of a source: `[[place, value], ...]`, rising"},
    {"/SOURCE/along", "", choice, none, "", "share, root_cm, tip_cm", "share",
     "what places are: shares of the length from the root, or cm from root or tip"},
    {"/SOURCE/interpolation", "", choice, none, "", "linear, smooth", "linear",
     "between the stops of a ramp; smooth: without corners at them"},
    {"/SOURCE/share", "", number, share, "", "", "of a mix needed",
     "of the second of two values: in a `mix`, or of the strands that "
     "have it by `random`",
     true},
    {"/SOURCE/seed", "", whole, seeds, "", "", "0", "of `random` and `normal`: other strands for another number"},
    {"/SOURCE/deviation", "", number, in(0, 1e4), "", "", "needed",
     "of `normal`: standard deviation, in the value's unit; of a color for all channels "
     "alike"},
    {"/SOURCE/hue", "", number, in(-100, 100), "turns", "", "0",
     "of `hsvadjust`: added to the hue; 1/3 makes green of red", true},
    {"/SOURCE/saturation", "", number, in(0, 100), "", "", "1",
     "of `hsvadjust`: factor of the saturation, which ends at 1", true},
    {"/SOURCE/value", "", number, in(0, 100), "", "", "1", "of `hsvadjust`: factor of the value, the largest channel",
     true},
    {"/SOURCE/attribute", "", text, none, "", "", "", "name of an attribute of the groom's file"},
    {"/SOURCE/texture", "", text, none, "", "", "", "a path to a PNG or EXR over the root uv of the groom"},
    {"/SOURCE/space", "", choice, none, "", "srgb, linear", "srgb",
     "of a PNG: colors in sRGB, or shares, as of a mask"},
    {"/materials/N/azimuthal_sigma_deg", "", numbers_by_name, of(fiber::azimuthal_sigma_range_deg), degrees,
     "TT, TRT, TRRT", "by the roughness", "blur of the exit azimuth, a standard deviation"},
    {"/materials/N/longitudinal_lambda_deg", "", numbers_by_name, of(fiber::longitudinal_lambda_range_deg), degrees,
     "R, TT, TRT, TRRT", "by the roughness", "logistic scale in theta_h"},
    {"/materials/N/longitudinal_shape", "", choice, none, "", "logistic, gaussian, cauchy", "logistic",
     "of the lobes in theta_h, with the same width at half height"},
    {"/materials/N/fresnel", "", choice, none, "", "exact, longitudinal, bravais, none", "exact",
     "of R; only `exact` conserves energy"},
    {"/materials/N/gain", "", numbers_by_name, of(fiber::gain_range), "", "R, TT, TRT, TRRT, residual, GLINT", "1 each",
     "factor of a lobe; above 1 a fiber may return more than it gets", true},
    {"/materials/N/tint", "", triples_by_name, share, "", "R, TT, TRT, TRRT, residual, GLINT", "[1, 1, 1] each",
     "factor by channel; GLINT without either has that of TRT", true},
    {"/materials/N/glint", "", only_true, none, "", "", "",
     "GLINT is a lobe and layer of its own, also if named above"},
    {"/materials/N/curl_diameter_cm", "", number, in(0.05, 1000), cm, "", "by the eccentricity",
     "turn of the major axis along the strand"},
    {"/materials/N/twist", "", flag, none, "", "", "true",
     "whether the major axis turns; not used beside a file's normals"},
    {"/materials/N/root_angle_deg", "", number, turn, degrees, "", "by a hash of the strand",
     "major axis at the root; not used beside a file's normals"},
    {"/materials/N/principled/roughness", "", number, share, "", "", "0.3",
     "of Blender's Principled Hair: longitudinal; with `aspect_ratio` of the surface"},
    {"/materials/N/principled/radial_roughness", "", number, share, "", "", "0.3",
     "azimuthal; not beside `aspect_ratio`"},
    {"/materials/N/principled/coat", "", number, share, "", "", "0",
     "share of roughness that R lacks; not beside `aspect_ratio`"},
    {"/materials/N/principled/eta", "", number, of(fiber::eta_range), "", "", "1.55", "index of refraction"},
    {"/materials/N/principled/offset_deg", "", number, in(-90, 90), degrees, "", "2",
     "tilt of the scales, the nearest in 0..15"},
    {"/materials/N/principled/aspect_ratio", "", number, of(fiber::eccentricity_range), "", "", "",
     "minor over major semi-axis: Huang's elliptical fibers, not Chiang's round ones"},
    {"/materials/N/principled/melanin", "", number, share, "", "", "this, `color` or `sigma_a`", "as the node has it",
     true},
    {"/materials/N/principled/redness", "", number, share, "", "", "1", "share of pheomelanin; beside `melanin`"},
    {"/materials/N/principled/tint", "", triple, share, "", "", "[1, 1, 1]",
     "a dye over the melanin, linear RGB; beside `melanin`", true},
    {"/materials/N/principled/color", "", either, share, "", "file", "",
     "multiple scattering albedo, linear RGB; \"file\": that of the file", true},
    {"/materials/N/principled/sigma_a", "", triple, of(fiber::sigma_a_range), "", "", "", "absorption, RGB, per radius",
     true},
    {"/materials/N/principled/random_color", "", number, share, "", "", "0",
     "melanin differs by a factor of 1 - this to 1 + this"},
    {"/materials/N/principled/random_roughness", "", number, share, "", "", "0", "the same of both roughnesses"},
    {"/materials/N/principled/widths", "", choice, none, "", "fitted, published", "by the model",
     "of the lobes: those by which `elliptical` looks like the node, or the node's own; by default published "
     "for `chiang2016`, fitted for others; not beside `aspect_ratio`"},
    {"/materials/N/chiang_hair_bsdf/tint_R", "", triple, share, "", "", "[1, 1, 1]",
     "of MaterialX's `chiang_hair_bsdf`: factor of the lobe, linear RGB; TRT and all after it are one"},
    {"/materials/N/chiang_hair_bsdf/tint_TT", "", triple, share, "", "", "[1, 1, 1]",
     "of MaterialX's `chiang_hair_bsdf`: factor of the lobe, linear RGB; TRT and all after it are one"},
    {"/materials/N/chiang_hair_bsdf/tint_TRT", "", triple, share, "", "", "[1, 1, 1]",
     "of MaterialX's `chiang_hair_bsdf`: factor of the lobe, linear RGB; TRT and all after it are one"},
    {"/materials/N/chiang_hair_bsdf/roughness_R", "", numbers_by_name, Range{1e-6, 10}, "", "longitudinal, azimuthal",
     "0.1, 0.1", "variance of the inclination; logistic scale of the azimuth (not used); radians"},
    {"/materials/N/chiang_hair_bsdf/roughness_TT", "", numbers_by_name, Range{1e-6, 10}, "", "longitudinal, azimuthal",
     "0.05, 0.05", "the same of TT"},
    {"/materials/N/chiang_hair_bsdf/roughness_TRT", "", numbers_by_name, Range{1e-6, 10}, "", "longitudinal, azimuthal",
     "0.2, 0.2", "the same of TRT and all after it"},
    {"/materials/N/chiang_hair_bsdf/ior", "", number, of(fiber::eta_range), "", "", "1.55", "index of refraction"},
    {"/materials/N/chiang_hair_bsdf/cuticle_angle", "", number, share, "", "", "0.5",
     "180 degrees times this less 0.5: tilt of the scales, the nearest in 0..15"},
    {"/materials/N/chiang_hair_bsdf/absorption_coefficient", "", triple, of(fiber::sigma_a_range), "", "", "[0, 0, 0]",
     "absorption, RGB, per radius"},
    {"/materials/N/marschner/specularGainR", "", number, of(fiber::gain_range), "", "", "1",
     "of RenderMan's PxrMarschnerHair: factor of the lobe; GLINTS: those of TRT"},
    {"/materials/N/marschner/specularGainTRT", "", number, of(fiber::gain_range), "", "", "1",
     "of RenderMan's PxrMarschnerHair: factor of the lobe; GLINTS: those of TRT"},
    {"/materials/N/marschner/specularGainTT", "", number, of(fiber::gain_range), "", "", "1",
     "of RenderMan's PxrMarschnerHair: factor of the lobe; GLINTS: those of TRT"},
    {"/materials/N/marschner/specularGainGLINTS", "", number, of(fiber::gain_range), "", "", "1",
     "of RenderMan's PxrMarschnerHair: factor of the lobe; GLINTS: those of TRT"},
    {"/materials/N/marschner/specularColorR", "", triple, share, "", "", "[1, 1, 1]", "tint of the lobe, linear RGB"},
    {"/materials/N/marschner/specularColorTRT", "", triple, share, "", "", "[0.4, 0.4, 0.4]",
     "tint of the lobe with its glints, linear RGB; not used beside `hair_color`"},
    {"/materials/N/marschner/specularColorTT", "", triple, share, "", "", "[0.4, 0.4, 0.4]",
     "tint of the lobe with its glints, linear RGB; not used beside `hair_color`"},
    {"/materials/N/marschner/specularConeAngleR", "", number, Range{0, 90}, degrees, "", "8",
     "standard deviation of the inclination; R's sets the roughness"},
    {"/materials/N/marschner/specularConeAngleTRT", "", number, Range{0, 90}, degrees, "", "8",
     "standard deviation of the inclination; R's sets the roughness"},
    {"/materials/N/marschner/specularConeAngleTT", "", number, Range{0, 90}, degrees, "", "8",
     "standard deviation of the inclination; R's sets the roughness"},
    {"/materials/N/marschner/specularOffset", "", number, Range{-90, 90}, degrees, "", "-3",
     "minus the tilt of the scales, the nearest in 0..15"},
    {"/materials/N/marschner/specularIor", "", number, of(fiber::eta_range), "", "", "1.55", "index of refraction"},
    {"/materials/N/marschner/specularGlintWidth", "", number, Range{0, 90}, degrees, "", "10",
     "blur of TRT's azimuth, the nearest in 0.5..45"},
    {"/materials/N/marschner/specularEccentricity", "", number, of(fiber::eccentricity_range), "", "", "1",
     "minor over major semi-axis"},
    {"/materials/N/marschner/presence", "", number, share, "", "", "1", "the same as the material's"},
    {"/materials/N/marschner/specularMixFresnel", "", number, share, "", "", "1",
     "only 1; others are left out with a warning"},
    {"/materials/N/marschner/specularEnergyCompensation", "", number, share, "", "", "0", "left out"},
    {"/materials/N/marschner/eccentricityDirection", "", triple, world, "", "", "[0, 0, 0]", "left out"},
    {"/materials/N/marschner/diffuseModelType", "", whole, share, "", "", "0", "left out"},
    {"/materials/N/marschner/diffuseGain", "", number, factor, "", "", "0", "left out"},
    {"/materials/N/marschner/diffuseColor", "", triple, share, "", "", "[0.18, 0.18, 0.18]", "left out"},
    {"/materials/N/marschner/glowGain", "", number, factor, "", "", "0", "left out"},
    {"/materials/N/marschner/glowColor", "", triple, share, "", "", "[1, 1, 1]", "left out"},
    {"/materials/N/marschner/shadowColor", "", triple, share, "", "", "[0, 0, 0]", "left out"},
    {"/materials/N/marschner/hair_color/mode", "", whole, share, "", "", "0",
     "of RenderMan's PxrHairColor: 0 for melanins, 1 for colors"},
    {"/materials/N/marschner/hair_color/melanin", "", number, share, "", "", "0.2", "eumelanin", true},
    {"/materials/N/marschner/hair_color/randomMelanin", "", number, share, "", "", "0.05",
     "half range over the strands"},
    {"/materials/N/marschner/hair_color/darkenRoots", "", number, share, "", "", "0",
     "melanin added at the root, falling to 0 at `darkenEndPosition`"},
    {"/materials/N/marschner/hair_color/darkenEndPosition", "", number, share, "", "", "0.5", "share of the length"},
    {"/materials/N/marschner/hair_color/strayDensity", "", number, share, "", "", "0.1", "share of stray strands"},
    {"/materials/N/marschner/hair_color/strayMelanin", "", number, share, "", "", "0.05", "their melanin"},
    {"/materials/N/marschner/hair_color/strayRandomMelanin", "", number, share, "", "", "0",
     "the same as `randomMelanin`"},
    {"/materials/N/marschner/hair_color/color", "", triple, share, "", "", "[0, 0.3, 0.1]", "color of a dense lock",
     true},
    {"/materials/N/marschner/hair_color/strayColor", "", triple, share, "", "", "[0.05, 0.05, 0.05]",
     "the same of stray strands"},
    {"/materials/N/marschner/hair_color/dye", "", triple, share, "", "", "[1, 1, 1]", "a dye over either, linear RGB",
     true},
    {"/materials/N/marschner/hair_color/randomDyeHue", "", number, share, "turns", "", "0",
     "strands differ in the hue of the dye by so many, uniform"},
    {"/materials/N/marschner/hair_color/randomDyeSaturation", "", number, share, "", "", "0",
     "the dye's saturation differs by a factor of 1 - this to 1 + this"},
    {"/materials/N/marschner/hair_color/darkenSlope", "", number, factor, "", "", "1",
     "only 1; others are left out with a warning"},
    {"/materials/N/marschner/hair_color/randomColor", "", triple, share, "", "", "[0, 0, 0]", "left out"},
    {"/materials/N/marschner/hair_color/strayRandomColor", "", triple, share, "", "", "[0, 0, 0]", "left out"},
    {"/materials/N/medulla/radius", "", number, of(fiber::medulla_radius_range), "", "", "needed",
     "of a core that scatters and has no pigment, as a share of the semi-axes; seen by the "
     "models `rough` and `fiber3d` only",
     true},
    {"/materials/N/medulla/scattering", "", number, of(fiber::medulla_scattering_range), "", "", "0",
     "scattering coefficient, per major semi-axis", true},
    {"/materials/N/medulla/asymmetry", "", number, of(fiber::medulla_asymmetry_range), "", "", "0",
     "mean cosine of a scattering", true},
    {"/materials/N/medulla/absorption", "", number, of(fiber::medulla_absorption_range), "", "", "0",
     "absorption coefficient of all colors, per major semi-axis", true},
    {"/materials/N/cortex/scattering", "", number, of(fiber::cortex_scattering_range), "", "", "needed",
     "scattering coefficient of the pigmented part, per major semi-axis: diffuse light of "
     "bleached and grey hair; seen by the models `rough` and `fiber3d` only",
     true},
    {"/materials/N/cortex/asymmetry", "", number, of(fiber::cortex_asymmetry_range), "", "", "0",
     "mean cosine of a scattering", true},
    {"/materials/N/wetness", "", number, of(fiber::wetness_range), "", "", "0",
     "share of the surface that a film of water covers; seen by the models `rough` and `fiber3d` only", true},
    {"/materials/N/variation/eccentricity", "", number, in(0, 0.25), "", "", "0",
     "half range over the strands, uniform"},
    {"/materials/N/variation/width", "", number, half_range, "", "", "0",
     "half range of one factor of roughness and widths"},
    {"/materials/N/variation/color", "", number, half_range, "", "", "0", "half range of one factor of the absorption"},
    {"/materials/N/variation/seed", "", whole, seeds, "", "", "0", "other strands for another number"},
    {"/grooms/N/file", "", text, none, "", "", "this or `generate`",
     "groom: .hair, .abc, .usda, .usdc, .usdz, .pbrt, .ply, .data; ####: the frame's number"},
    {"/grooms/N/points_per_strand", "--points-per-strand", whole, in(2, 65535), "", "", "as the file says, else 100",
     "of every strand, in files of bare points (PLY)"},
    {"/grooms/N/generate", "", choice, none, "",
     "curly_lock, straight, wavy, curly, layered, curtain, fur_ball, single_fiber", "",
     "a kind of groom that needs no file"},
    {"/grooms/N/name", "", text, none, "", "", "of the file or kind",
     "its name in mattes (`CryptoObject`); equal names are one matte"},
    {"/grooms/N/strands", "", whole, in(1, 1e6), "", "", "by kind", "generated only; 10^8 points at most"},
    {"/grooms/N/seed", "", whole, seeds, "", "", "0", "generated only; another groom for another number"},
    {"/grooms/N/radius_cm", "--radius", number, radius, cm, "", "the file's, or 0.004",
     "of the circle with the same mean projected width"},
    {"/grooms/N/widths", "--widths", text, none, "", "", "as they are where a unit is said",
     "files only: `file` uses them in a guessed unit too; `clamp`: radii of 0.0005 to 0.05 "
     "cm; `scale=2` doubles them; 0 hides"},
    {"/grooms/N/taper", "", numbers_by_name, in(0, 10), "", "root, tip",
     "1, 1; generated 1, 0.4 but for `single_fiber`", "factors of the radius, linear along the strand"},
    {"/grooms/N/basis", "", choice, none, "",
     "bspline, linear, catmull_rom, clamped_catmull_rom, open_bspline, open_catmull_rom, bezier, hermite",
     "the file's, else bspline",
     "of files that do not say: B-splines round bends, Catmull-Rom goes through every point (clamped: ends "
     "repeated, as Blender draws it), open ones end before their first and last point, Bezier segments have 3 "
     "n + 1 points, Hermite point and tangent in turn"},
    {"/grooms/N/up", "--up", choice, none, "", "y, z", "the file's, else z; of a bare file by how its strands fall",
     "files only: axis that points up; y becomes z, z becomes -y"},
    {"/grooms/N/cm_per_unit", "--cm-per-unit", number, per_unit, cm, "", "the file's, else longest side 30 cm",
     "files only: length of a unit of the file"},
    {"/grooms/N/normals", "", flag, none, "", "", "true",
     "files only: whether its normals are the fibers' minor axes; else the material's axes hold"},
    {"/grooms/N/scale", "", number, in(1e-6, 1e6), "", "", "1", "of the whole groom, radii too"},
    {"/grooms/N/rotate_deg", "", triple, in(-360, 360), "degrees", "", "[0, 0, 0]",
     "turns about x, then y, then z, after the scale"},
    {"/grooms/N/translate", "", triple, in(-1e6, 1e6), cm, "", "[0, 0, 0]", "after the turn"},
    {"/grooms/N/frames/N/frame", "", whole, frames, "", "", "needed", "as `meshes/N/frames/N/frame`"},
    {"/grooms/N/instances/N/scale", "", number, in(1e-6, 1e6), "", "", "1",
     "with `rotate_deg`, `translate` and `frames` as in a groom, which instances replace"},
    {"/grooms/N/material", "", text, none, "", "", "the first", "its name; without any materials: brown hair"},
    {"/grooms/N/looks/N/material", "", text, none, "", "", "needed", "another material for some of the strands"},
    {"/grooms/N/looks/N/share", "", number, share, "", "", "needed",
     "share of the strands that have it, by their roots; of all looks at most 1", true},
    {"/grooms/N/visible", "", flag, none, "", "", "true", "as `meshes/N/visible`"},
    {"/grooms/N/casts_shadow", "", flag, none, "", "", "true", "as `meshes/N/casts_shadow`; also on itself"},
    {"/grooms/N/visible_indirect", "", flag, none, "", "", "true",
     "as `meshes/N/visible_indirect`; also for its own strands"},
    {"/grooms/N/length_cm", "", number, in(0.1, 1000), cm, "", "by kind", "length along the fall"},
    {"/grooms/N/length_variation", "", number, half_range, "", "", "by kind", "half range of a factor of the length"},
    {"/grooms/N/clump", "", number, share, "", "", "by kind", "how far strands gather towards the tips"},
    {"/grooms/N/frizz", "", number, share, "", "", "by kind", "flyaways and wandering"},
    {"/grooms/N/wavelength_cm", "", number, in(0.2, 1000), cm, "", "by kind",
     "length of one wave or turn along the fall"},
    {"/grooms/N/wave_amplitude_cm", "", number, in(0, 10), cm, "", "by kind", "of waves, to one side"},
    {"/grooms/N/curl_diameter_cm", "", number, in(0, 20), cm, "", "by kind", "of curls; 0: none"},
    {"/grooms/N/width_cm", "", number, in(0.1, 1000), cm, "", "by kind", "across, at the roots"},
    {"/grooms/N/ball_radius_cm", "", number, in(0.1, 1000), cm, "", "by kind", "of the ball under the fur"},
    {"/expected/radiance", "", triple, in(0, 1e6), "", "", "", "the known answer; changes no picture"},
    {"", "--resolution", whole, pixels, "", "", "the scene's", "width and height in pixels, 2^26 in all"},
    {"", "--frame", whole, frames, "", "", "0, or the first keyframe",
     "frame of what moves: the camera, a turntable, grooms and meshes"},
    {"", "--strict", flag, none, "", "", "",
     "what a file of strands has and the picture does not show is an error, not a note"},
    {"", "--chunk", whole, in(1, 1 << 20), "", "", "1", "frames of a task"},
    {"", "--split-samples", whole, in(1, 1 << 16), "", "", "",
     "tasks that share the samples of each frame, which are merged"},
    {"", "--calibrate-first", flag, none, "", "", "",
     "the first task is the first frame alone; the others wait for it and start from its table"},
    {"", "--retries", whole, in(0, 1000), "", "", "2", "of a task that fails"},
    {"", "--at-most", whole, in(1, 1 << 20), "", "", "all", "tasks at a time"},
    {"", "--task", whole, in(0, 1 << 20), "", "", "", "its number"},
    {"", "--overwrite", flag, none, "", "", "", "of --frames: render those that are finished too"},
    {"", "--checkpoint-interval", number, in(0, 1e6), "seconds", "", "30",
     "between two writes, more where they would take more than 0.01 of the time; 0: as often as that allows"},
    {"", "--checkpoint-deadline", number, in(0, 1e6), "seconds", "", "20",
     "after SIGTERM, SIGINT or SIGHUP, in which the running pass may end; after it the checkpoint before stays"},
    {"", "--samples-from", whole, in(0, 1 << 20), "", "", "0", "the first sample of each pixel to render"},
    {"", "--samples-to", whole, in(1, 1 << 20), "", "", "the scene's number of samples", "the sample to stop before"},
    {"", "--time", number, in(0, 1e7, true), "seconds", "", "",
     "as many samples as fit, one at least; the picture then depends on the machine"},
    {"", "--noise", number, accuracy, "", "", "",
     "samples until the noise relative to the brightness of what is covered is at most this, 16384 at most"},
    {"", "--denoise", flag, none, "", "", "",
     "filter R, G, B along the hair at the end: the PNG and the layer `denoised`; biased, so that R, G, B of "
     "the EXR stay as rendered; --noise is then that of the filtered picture"},
    {"", "--threads", whole, in(1, 1024), "", "", "one per hardware thread", "threads to work with"},
    {"", "--seed", whole, in(0, past_uint64), "", "", "0",
     "same seed, same result, for any number of threads; a render without it takes the number of its frame"},
    {"", "--quadrature-points", whole, in(1, 65536), "", "", "by model",
     "points over the width of the fiber, for models that integrate at every vertex"},
    {"", "--picture-error", number, accuracy, "", "", "",
     "in place of --epsilon: the relative error that fits may make in the picture; each row is then learned "
     "as well as the light it carries asks for, and a render to --noise goes on until it is known by two "
     "standard errors whether the bias is below this, if --measure-bias or elliptical estimates it"},
    {"", "--measure-bias", number, in(0, 1, true), "", "", "",
     "share of the samples that are traced a second time without rows, 0.01 say: how far the brightness of "
     "the picture is off is reported with its standard error"},
    {"", "--components", whole, in(1, 8), "", "", "8",
     "components of a row, at most or, for learners of a fixed number, exactly"},
    {"", "--epsilon", number, accuracy, "", "", "0.01",
     "error under which a row is converged, of all rows alike: of elliptical the relative squared error; of "
     "rough chi-square, and 0.07 without the option, 0.25 at most where there is little light"},
    {"", "--table-memory", number, in(0, 1 << 20), "MB of 2^20 bytes", "", "256", "ceiling of the table"},
    {"", "--cache-limit", number, in(0, 1 << 24), "MB of 2^20 bytes", "", "1024",
     "what --warm-cache default may take of the disk: the kinds of fiber that were used longest ago go"},
    {"", "--limit", number, in(0, 1 << 24), "MB of 2^20 bytes", "", "1024",
     "what is to be left at most: the kinds of fiber that were used longest ago go"},
    {"", "--light-scale", number, factor, "", "", "1", "factor of the light of the environment and every light"},
    {"", "--e", number, of(fiber::eccentricity_range), "", "", "0.85", "minor over major semi-axis"},
    {"", "--theta-d", number, in(-89.9, 89.9), degrees, "", "30", "difference angle"},
    {"", "--phi", number, turn, degrees, "", "45", "azimuth of the known direction from the major axis"},
    {"", "--sigma", number, of(fiber::azimuthal_sigma_range_deg), degrees, "", "10", "blur of the exit azimuth"},
    {"", "--eta", number, of(fiber::eta_range), "", "", "1.55", "index of refraction"},
    {"", "--samples", whole, in(1, 1 << 20), "", "", "360", "azimuths printed"},
    {"", "--alpha", number, of(fiber::roughness_range), "", "", "0.2", "Beckmann roughness of the surface"},
    {"", "--tilt", number, of(fiber::tilt_range_deg), degrees, "", "3", "tilt of the cuticle scales"},
    {"", "--theta-r", number, in(-89.9, 89.9), degrees, "", "30",
     "inclination of the known direction, from the normal plane towards the tip"},
    {"", "--phi-r", number, turn, degrees, "", "45",
     "azimuth of the known direction from the major axis towards the minor one"},
    {"", "--bins", whole, in(1, 720), "", "", "36x36", "bins of theta_i and of phi_i"},
    {"", "--paths", whole, in(1, 1e9), "", "", "1000000",
     "paths that are traced, or directions at which a model is evaluated"},
    {"", "--fit-paths", whole, in(512, 1e8), "", "", "262144", "paths of each fiber that is tried"},
    {"", "--incidence", number, in(-89.9, 89.9), degrees, "", "the file's",
     "inclination of the source as the fiber sees it, from the normal plane towards the tip"},
    {"", "--rotation", number, turn, degrees, "", "the file's, or all rotations alike",
     "azimuth of the source from the fiber's major axis towards the minor one"},
    {"", "--detector", number, in(0.1, 30), degrees, "", "the file's, or 3", "angle that the detector is wide"},
};

/// Keys that have the same row as those of another place.
constexpr std::array<std::pair<std::string_view, std::string_view>, 25> same{
    {{"/environment/sky/sun/", "/lights/N/distant/"},
     {"/environment/light_link/exclude/N", "/environment/light_link/include/N"},
     {"/environment/shadow_link/include/N", "/environment/light_link/include/N"},
     {"/environment/shadow_link/exclude/N", "/environment/light_link/include/N"},
     {"/camera/frames/N/eye", "/camera/eye"},
     {"/camera/frames/N/look_at", "/camera/look_at"},
     {"/camera/frames/N/up", "/camera/up"},
     {"/camera/frames/N/vertical_fov_deg", "/camera/vertical_fov_deg"},
     {"/camera/frames/N/focal_length_mm", "/camera/focal_length_mm"},
     {"/environment/frames/N/rotate_deg", "/environment/rotate_deg"},
     {"/lights/N/frames/N/scale", "/lights/N/scale"},
     {"/lights/N/frames/N/rotate_deg", "/lights/N/rotate_deg"},
     {"/lights/N/frames/N/translate", "/lights/N/translate"},
     {"/meshes/N/frames/N/scale", "/meshes/N/scale"},
     {"/meshes/N/frames/N/rotate_deg", "/meshes/N/rotate_deg"},
     {"/meshes/N/frames/N/translate", "/meshes/N/translate"},
     {"/grooms/N/frames/N/scale", "/grooms/N/scale"},
     {"/grooms/N/frames/N/rotate_deg", "/grooms/N/rotate_deg"},
     {"/grooms/N/frames/N/translate", "/grooms/N/translate"},
     {"/grooms/N/instances/N/frames/N/scale", "/grooms/N/instances/N/scale"},
     {"/grooms/N/instances/N/rotate_deg", "/grooms/N/rotate_deg"},
     {"/grooms/N/instances/N/translate", "/grooms/N/translate"},
     {"/grooms/N/instances/N/frames/N/frame", "/grooms/N/frames/N/frame"},
     {"/grooms/N/instances/N/frames/N/rotate_deg", "/grooms/N/rotate_deg"},
     {"/grooms/N/instances/N/frames/N/translate", "/grooms/N/translate"}}};

/// Replaces indices by N, and places by the ones that they are like.
std::string general(std::string_view place) {
  std::string key;
  for (std::size_t i = 0; i < place.size();) {
    const std::size_t end = std::min(place.find('/', i + 1), place.size());
    const auto part = place.substr(i + 1, end - i - 1);
    const bool index = !part.empty() && std::ranges::all_of(part, [](unsigned char c) { return std::isdigit(c); });
    key.append("/").append(index ? "N" : part);
    i = end;
  }
  for (const auto& [from, to] : same)
    if (key.starts_with(from)) return std::string(to) + key.substr(from.size());
  return key;
}

bool is_named(const Parameter& parameter, std::string_view name) {
  if (parameter.kind != numbers_by_name && parameter.kind != triples_by_name) return false;
  return fmt::format(", {},", parameter.choices).find(fmt::format(", {},", name)) != std::string::npos;
}

}  // namespace

std::span<const Parameter> parameters() { return table; }

const Parameter* parameter_at(std::string_view place) {
  static const auto by_key = [] {
    std::map<std::string, const Parameter*, std::less<>> all;
    for (const Parameter& parameter : table)
      if (!parameter.key.empty()) all.emplace(parameter.key, &parameter);
    return all;
  }();
  const std::string key = general(place);
  if (const auto found = by_key.find(key); found != by_key.end()) return found->second;
  // Each part of a source has the range of the value that it replaces; a source's own keys may be in any source.
  for (const std::string_view part :
       {"/ramp/N/N", "/random/N", "/normal", "/mix/N", "/sum/N", "/hsvadjust", "/root", "/tip"}) {
    if (!key.ends_with(part)) continue;
    const Parameter* whole = parameter_at(key.substr(0, key.size() - part.size()));
    if (whole == nullptr || !whole->varies) continue;
    return part.starts_with("/ramp") && place.ends_with("/0") ? by_key.at("/SOURCE/ramp") : whole;
  }
  const std::size_t last = key.rfind('/');
  if (last == std::string::npos || last == 0) return nullptr;
  const Parameter* holder = parameter_at(std::string_view(key).substr(0, last));
  if (holder == nullptr) return nullptr;
  if (is_named(*holder, key.substr(last + 1))) return holder;
  const auto of_source = by_key.find("/SOURCE" + key.substr(last));
  return holder->varies && of_source != by_key.end() ? of_source->second : nullptr;
}

std::vector<std::string> keys_at(std::string_view place) {
  const std::string object = general(std::string(place) + "/");
  std::vector<std::string> keys;
  const auto add = [&](std::string_view key) {
    if (!key.starts_with(object) || key.starts_with("/SOURCE")) return;
    const std::string_view below = key.substr(object.size());
    const std::string_view name = below.substr(0, below.find('/'));
    if (std::ranges::find(keys, name) == keys.end()) keys.emplace_back(name);
  };
  for (const Parameter& parameter : table) add(parameter.key);
  for (const auto& from : same) add(from.first);
  const Parameter* named = keys.empty() ? parameter_at(place) : nullptr;
  if (named != nullptr && (named->kind == numbers_by_name || named->kind == triples_by_name)) return choices_of(*named);
  return keys;
}

std::vector<std::string> choices_of(const Parameter& parameter) {
  std::vector<std::string> choices;
  for (std::string_view left = parameter.choices; !left.empty();) {
    const std::size_t end = std::min(left.find(", "), left.size());
    choices.emplace_back(left.substr(0, end));
    left.remove_prefix(std::min(end + 2, left.size()));
  }
  return choices;
}

const Parameter& option_parameter(std::string_view option) {
  const auto found = std::ranges::find(table, option, &Parameter::option);
  assert(found != std::end(table));
  return found == std::end(table) ? table[0] : *found;
}

std::string words(const Parameter& parameter) {
  const Range& range = parameter.range;
  const auto end = [](double x) {
    if (x >= past_int64) return fmt::format("2^{} - 1", x == past_int64 ? 63 : 64);
    return x == std::round(x) ? fmt::format("{:.0f}", x) : fmt::format("{:g}", x);
  };
  std::string text = range.least_open || range.most_open
                         ? fmt::format("a number {} {} and {} {}", range.least_open ? ">" : ">=", end(range.least),
                                       range.most_open ? "<" : "<=", end(range.most))
                         : fmt::format("{}..{}", end(range.least), end(range.most));
  if (parameter.kind == whole) text = fmt::format("a whole number, {}", text);
  return parameter.unit.empty() ? text : fmt::format("{} {}", text, parameter.unit);
}

}  // namespace tress::scene
