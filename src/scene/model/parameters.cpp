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

constexpr Range none{0, 0}, share{0, 1}, factor{0, 1e6}, world{-world_cm, world_cm}, length{1e-3, world_cm};
constexpr Range turn{-360, 360}, light{0, 1e9}, sky{0, 1e6}, radius{1e-4, 1}, per_unit{1e-6, 1e6};
constexpr Range frames{-1e6, 1e6}, pixels{1, 65536}, seeds{0, past_int64}, half_range{0, 0.9};
constexpr Range accuracy{0, 1, true}, paths{1, 4096};
constexpr std::string_view degrees = "degrees", cm = "cm";

/// An array of C: clang allows no deduction from more than 256 elements.
constexpr Parameter table[] = {
    Parameter{"/$schema", "", text, none, "", "", "", "for editors: where schema.json is"},
    Parameter{"/camera/frame", "", flag, none, "", "", "true without `eye`",
              "place the camera so that all grooms are seen, from 8 degrees above; excludes `eye`, `look_at`, `up`"},
    Parameter{"/camera/turn_deg", "--turn", number, turn, degrees, "", "0",
              "where a camera that sees all grooms stands: counter-clockwise from above, 0 is -y"},
    Parameter{"/camera/eye", "", triple, world, cm, "", "", "where the camera is"},
    Parameter{"/camera/look_at", "", triple, world, cm, "", "[0, 0, 0]", "the middle of the picture"},
    Parameter{"/camera/up", "", triple, world, "", "", "[0, 0, 1], straight up or down [0, 1, 0]",
              "the direction that is up in the picture"},
    Parameter{"/camera/vertical_fov_deg", "", number, {0.1, 150}, degrees, "", "30", "vertical angle of view"},
    Parameter{"/camera/focal_length_mm",
              "",
              number,
              {1, 10000},
              "mm",
              "",
              "by `vertical_fov_deg`",
              "in place of the angle of view, by the sensor"},
    Parameter{
        "/camera/sensor_mm",
        "",
        number,
        {1, 1000},
        "mm",
        "",
        "36",
        "what a side of the picture spans on the sensor: makes angles of focal lengths, and focal lengths of angles "
        "for `f_number`"},
    Parameter{"/camera/sensor_fit", "", choice, none, "", "longer, width, height", "longer", "which side that is"},
    Parameter{"/camera/orthographic_height_cm", "", number, length, cm, "", "",
              "in place of the angle of view: parallel rays, the picture is as high as this"},
    Parameter{"/camera/shift_x",
              "",
              number,
              {-10, 10},
              "",
              "",
              "0",
              "lens shift: moves the view to the right without turning it, in widths of the picture"},
    Parameter{"/camera/shift_y", "", number, {-10, 10}, "", "", "0", "the same upwards, in heights of the picture"},
    Parameter{"/camera/depth_of_field/f_number",
              "",
              number,
              {0.1, 1000},
              "",
              "",
              "this or `radius_cm`",
              "focal length over the diameter of the lens; a portrait has 2 to 4"},
    Parameter{"/camera/depth_of_field/radius_cm", "", number, {1e-4, 1000}, cm, "", "", "radius of the lens"},
    Parameter{"/camera/depth_of_field/focus_cm", "", number, length, cm, "", "that of `look_at`",
              "what is sharp: a plane across the view, so far from the eye"},
    Parameter{"/camera/depth_of_field/focus_point", "", triple, world, cm, "", "",
              "in place of `focus_cm`: a point that is sharp, in every frame"},
    Parameter{"/camera/depth_of_field/blades",
              "",
              whole,
              {3, 64},
              "",
              "",
              "a round lens",
              "corners of the lens, a regular polygon within the circle"},
    Parameter{
        "/camera/depth_of_field/blade_rotation_deg", "", number, turn, degrees, "", "0",
        "of the polygon, counter-clockwise as a bright point behind the focus shows it; 0: a corner to the right"},
    Parameter{"/camera/frames/N/frame", "", whole, frames, "", "", "needed",
              "a keyframe's number; rising; linear between keyframes, held before and after; beside it `eye` (needed), "
              "`look_at`, `up`, `vertical_fov_deg` or `focal_length_mm` as in `camera`"},
    Parameter{"/camera/turntable/frames",
              "",
              whole,
              {1, 1e6},
              "",
              "",
              "needed",
              "frames of one turn; frame 0 is seen from -y"},
    Parameter{
        "/camera/turntable/turns", "", choice, none, "", "object, camera", "object",
        "grooms and meshes turn, clockwise from above, before a camera and lights that stand still; or the camera "
        "goes around them counter-clockwise, through the lights: a frame shows the same side either way"},
    Parameter{"/camera/turntable/look_at", "", triple, world, cm, "", "the middle of the hair",
              "the axis of the turn, and what the camera looks at"},
    Parameter{"/camera/turntable/distance_cm", "", number, length, cm, "", "all hair seen, from 8 degrees above",
              "from the vertical axis through `look_at`"},
    Parameter{"/camera/turntable/height_cm", "", number, world, cm, "", "0", "above `look_at`; beside `distance_cm`"},
    Parameter{"/camera/shutter",
              "--shutter",
              numbers_by_name,
              {-10, 10},
              "frames",
              "open, close",
              "closed: nothing is blurred by its motion",
              "when it opens and closes, counted from the frame: 0 and 0.5 are half a frame from its beginning, -0.25 "
              "and 0.25 the same about its middle"},
    Parameter{"/camera/motion_samples",
              "--motion-samples",
              whole,
              {2, 64},
              "",
              "",
              "2",
              "moments of the open shutter, evenly spaced, at which all that moves is looked up; in between it goes "
              "straight, so that a turn needs more"},
    Parameter{"/camera/frames_per_second",
              "--fps",
              number,
              {0.001, 100000},
              "",
              "",
              "as the file says, else 24",
              "of Alembic files, which count in seconds; frame 24 is at 1 s"},
    Parameter{"/image/width", "", whole, pixels, "", "", "512", "pixels; width times height is 2^26 at most"},
    Parameter{"/image/height", "", whole, pixels, "", "", "512", "pixels"},
    Parameter{"/image/samples", "--spp", whole, {1, 1e6}, "", "", "64", "samples a pixel"},
    Parameter{"/image/least_width",
              "--least-width",
              number,
              {0, 100},
              "pixels",
              "",
              "0",
              "strands that are seen thinner are drawn as wide and let the rest of the light through (`presence`), so "
              "that alpha of sparse ones has less noise; 0 leaves strands as they are"},
    Parameter{"/image/curve_error",
              "--curve-error",
              number,
              {0.001, 100},
              "pixels",
              "",
              "0.1",
              "how far the straight pieces that a curve is drawn by may lie beside it; a segment has 4 to 16 of them"},
    Parameter{"/image/transparent", "--transparent", flag, none, "", "", "false",
              "R, G, B have nothing of what is behind the hair, A is the share of it that the hair covers, and the PNG "
              "has it too; the backdrop is a layer of its own either way"},
    Parameter{"/image/exposure",
              "--exposure",
              number,
              {-20, 20},
              "stops",
              "",
              "0",
              "brightness of the PNG, which is scaled by 2 to this; the EXR stays as it is"},
    Parameter{"/image/view", "--view", choice, none, "", "standard, neutral, agx", "standard",
              "how the PNG shows light that is brighter than a display: cut off at 1; Khronos PBR Neutral, which keeps "
              "colors and compresses highlights; AgX, which is like film; the EXR stays as it is"},
    Parameter{"/environment/file", "", text, none, "", "", "",
              "a path to an EXR or HDR (RGBE) picture, recognized by content; latitude-longitude, top row up; bilinear "
              "between its pixels"},
    Parameter{"/environment/constant", "", triple, sky, "", "", "", "linear RGB radiance from everywhere"},
    Parameter{"/environment/studio", "", only_true, none, "", "", "of `file`, `constant`, `studio`, `sky`",
              "soft key, rim and fill lights before a neutral background"},
    Parameter{"/environment/sky/zenith", "", triple, sky, "", "", "[0.18, 0.32, 0.7]",
              "linear RGB radiance; down to the horizon with the square root of the sine of the elevation"},
    Parameter{"/environment/sky/horizon", "", triple, sky, "", "", "[0.75, 0.82, 0.9]", "linear RGB radiance"},
    Parameter{"/environment/sky/ground", "", triple, sky, "", "", "[0.22, 0.2, 0.18]",
              "linear RGB radiance of everything below the horizon; beside it `sun`, keys as in `lights/N/distant`, "
              "which turns and scales with the sky and is not seen in the background"},
    Parameter{"/environment/rotate_deg", "--rotate", number, turn, degrees, "", "0",
              "turn of the environment about the vertical, counter-clockwise from above"},
    Parameter{"/environment/frames/N/frame", "", whole, frames, "", "", "needed",
              "a keyframe's number; rising; linear between keyframes, held before and after; beside it `rotate_deg` "
              "(needed), in place of that of the environment; the sun of a sky turns with it"},
    Parameter{"/environment/scale", "", number, factor, "", "", "1", "factor of the radiance"},
    Parameter{"/environment/group", "", text, none, "", "", "",
              "the light of the environment and its sun has a layer `light.` with this name; as `lights/N/group`"},
    Parameter{"/environment/light_link/include/N", "", text, none, "", "", "",
              "as `lights/N/light_link`, for the environment and its sun; also `exclude`, and `shadow_link`"},
    Parameter{"/environment_visible", "", flag, none, "", "", "true",
              "the environment is shown behind the hair; else it is black there"},
    Parameter{"/lights/N/distant/direction", "", triple, world, "", "", "",
              "towards the light, of any length; or `azimuth_deg` and `elevation_deg`"},
    Parameter{"/lights/N/distant/azimuth_deg", "", number, turn, degrees, "", "0",
              "0 is -y, counter-clockwise from above (+x is 90)"},
    Parameter{"/lights/N/distant/elevation_deg", "", number, {-90, 90}, degrees, "", "0", "above the horizon"},
    Parameter{"/lights/N/distant/angle_deg",
              "",
              number,
              {0.01, 180},
              degrees,
              "",
              "0.53",
              "full angular diameter; uniform within"},
    Parameter{"/lights/N/distant/radiance", "", triple, light, "", "", "this or `irradiance`",
              "linear RGB, the same in all directions that the light shines into"},
    Parameter{"/lights/N/distant/irradiance", "", triple, light, "", "", "",
              "in place of `radiance`: linear RGB, on a plane across the direction"},
    Parameter{"/lights/N/sphere/center", "", triple, world, cm, "", "needed", "shines inwards too"},
    Parameter{"/lights/N/sphere/radius_cm", "", number, length, cm, "", "needed", "of the sphere"},
    Parameter{"/lights/N/sphere/radiance", "", triple, light, "", "", "needed", "linear RGB"},
    Parameter{"/lights/N/rectangle/center", "", triple, world, cm, "", "needed", "of the rectangle"},
    Parameter{"/lights/N/rectangle/look_at", "", triple, world, cm, "", "needed", "it shines to this side only"},
    Parameter{"/lights/N/rectangle/up", "", triple, world, "", "", "[0, 0, 1], level ones [0, 1, 0]",
              "where the height runs"},
    Parameter{"/lights/N/rectangle/width_cm", "", number, length, cm, "", "needed", "full edge"},
    Parameter{"/lights/N/rectangle/height_cm", "", number, length, cm, "", "needed", "full edge"},
    Parameter{"/lights/N/rectangle/radiance", "", triple, light, "", "", "needed", "linear RGB"},
    Parameter{"/lights/N/spot/center", "", triple, world, cm, "", "needed", "of a sphere that shines into a cone"},
    Parameter{"/lights/N/spot/look_at", "", triple, world, cm, "", "needed", "a point on the axis of the cone"},
    Parameter{"/lights/N/spot/radius_cm", "", number, length, cm, "", "1",
              "of the sphere: a large one softens shadows"},
    Parameter{"/lights/N/spot/cone_deg",
              "",
              number,
              {0.1, 180},
              degrees,
              "",
              "45",
              "full angle of the cone, outside which it is dark"},
    Parameter{
        "/lights/N/spot/soft", "", number, share, "", "", "0.15",
        "share of the cone, measured in the cosine, over which the light rises smoothly from its edge, 3 t^2 - 2 t^3"},
    Parameter{"/lights/N/spot/radiance", "", triple, light, "", "", "this or `irradiance`", "linear RGB, on the axis"},
    Parameter{"/lights/N/spot/irradiance", "", triple, light, "", "", "",
              "in place of `radiance`: linear RGB, on a plane across the axis at `look_at`"},
    Parameter{"/lights/N/scale", "", number, per_unit, "", "", "1",
              "of the light about the origin: of its place, edges and radius; not of its radiance"},
    Parameter{"/lights/N/rotate_deg", "", triple, turn, degrees, "", "[0, 0, 0]",
              "turns about x, then y, then z, after the scale"},
    Parameter{"/lights/N/translate", "", triple, world, cm, "", "[0, 0, 0]", "after the turn"},
    Parameter{"/lights/N/frames/N/frame", "", whole, frames, "", "", "needed", "a keyframe's number; as of a mesh"},
    Parameter{"/lights/N/visible", "", flag, none, "", "", "false",
              "the camera sees the light, with its radiance, from the side that it shines to"},
    Parameter{
        "/lights/N/group", "", text, none, "", "", "",
        "a name of 1 to 64 letters, digits, _ and -: the light of all lights that have it is a layer `light.` with "
        "this name, and what has none is in `light.other`; 16 at most"},
    Parameter{"/lights/N/light_link/include/N", "", text, none, "", "", "all",
              "names of the grooms and meshes that the light illuminates; no others"},
    Parameter{"/lights/N/light_link/exclude/N", "", text, none, "", "", "none",
              "in place of `include`: those that it does not illuminate"},
    Parameter{"/lights/N/shadow_link/include/N", "", text, none, "", "", "all",
              "names of the grooms and meshes that cast shadows in this light; no others"},
    Parameter{"/lights/N/shadow_link/exclude/N", "", text, none, "", "", "none",
              "in place of `include`: those that cast none in this light"},
    Parameter{
        "/meshes/N/file", "", text, none, "", "", "needed",
        "a path to an OBJ file; its polygons, normals and texture coordinates, as a surface seen from both sides; #### "
        "in its name is the number of the frame"},
    Parameter{"/meshes/N/name", "", text, none, "", "", "of the file",
              "what mattes call it (`CryptoObject`, `CryptoMaterial`); equal names are one matte"},
    Parameter{"/meshes/N/up", "", choice, none, "", "y, z", "z", "axis of the file that points up; y becomes z, z -y"},
    Parameter{"/meshes/N/cm_per_unit", "", number, per_unit, cm, "", "1", "length of a unit of the file"},
    Parameter{"/meshes/N/scale", "", number, per_unit, "", "", "1", "of the whole mesh, after the above"},
    Parameter{"/meshes/N/rotate_deg", "", triple, turn, degrees, "", "[0, 0, 0]",
              "turns about x, then y, then z, after the scale"},
    Parameter{"/meshes/N/translate", "", triple, world, cm, "", "[0, 0, 0]", "after the turn"},
    Parameter{"/meshes/N/frames/N/frame", "", whole, frames, "", "", "needed",
              "a keyframe's number; rising; linear between keyframes, held before and after; beside it `scale`, "
              "`rotate_deg`, `translate`, which are those of the mesh where they are not given"},
    Parameter{"/meshes/N/albedo", "", triple, share, "", "", "[0.18, 0.18, 0.18]",
              "linear RGB of the diffuse surface; or `albedo_file`"},
    Parameter{"/meshes/N/albedo_file", "", text, none, "", "", "",
              "a path to a PNG (sRGB) or an EXR (linear), recognized by content, laid over the texture coordinates of "
              "the OBJ: (0, 0) is its lower left corner; bilinear, repeated"},
    Parameter{"/meshes/N/coat/roughness",
              "",
              number,
              {0.03, 1},
              "",
              "",
              "0.3",
              "a clear coat that mirrors, over the diffuse surface: skin 0.3 to 0.5, lacquer 0.1; the width of its GGX "
              "distribution is the square"},
    Parameter{"/meshes/N/coat/eta", "", number, {1.01, 2.5}, "", "", "1.5", "its index of refraction; skin 1.4"},
    Parameter{"/meshes/N/visible", "", flag, none, "", "", "true",
              "the camera sees it; where not, it casts shadows and reflects light all the same"},
    Parameter{"/meshes/N/casts_shadow", "", flag, none, "", "", "true", "it stands in the way of lights"},
    Parameter{"/meshes/N/visible_indirect", "", flag, none, "", "", "true",
              "other objects get the light that it reflects"},
    Parameter{"/meshes/N/holdout", "", flag, none, "", "", "false",
              "a matte: the camera sees nothing where it is, neither it nor what is behind; black, alpha 0"},
    Parameter{"/materials/N/name", "", text, none, "", "", "material N", "distinct; grooms refer to it"},
    Parameter{"/materials/N/eta", "", number, of(fiber::eta_range), "", "", "1.55", "index of refraction"},
    Parameter{"/materials/N/eccentricity", "--eccentricity", number, of(fiber::eccentricity_range), "", "", "0.85",
              "minor over major semi-axis of the cross-section; a source of it may not vary along strands", true},
    Parameter{"/materials/N/roughness", "--roughness", number, of(fiber::roughness_range), "", "", "0.2",
              "Beckmann roughness of the surface: the energies of the lobes, and the widths that are not given", true},
    Parameter{"/materials/N/presence", "", number, share, "", "", "1",
              "how likely a ray is to meet a strand that it comes to, and a strand's alpha before nothing", true},
    Parameter{"/materials/N/thickness",
              "",
              number,
              {0, 10},
              "",
              "",
              "1",
              "factor of the radii of its strands, beside their `taper`",
              true},
    Parameter{"/materials/N/tilt_deg", "--cuticle-tilt", number, of(fiber::tilt_range_deg), degrees, "", "3",
              "tilt of the cuticle scales", true},
    Parameter{
        "/materials/N/color",
        "--color",
        either,
        {0.001, 0.999},
        "",
        "file",
        "",
        "color, linear RGB, that a dense lock shows in even light; \"file\": that of the file, by strand or along "
        "it; at most one of `color`, `hair`, `melanin`, `sigma_a`",
        true},
    Parameter{"/materials/N/hair", "--hair", choice, none, "",
              "black, dark brown, brown, light brown, auburn, red, blond, platinum, white, grey", "",
              "natural color by name", true},
    Parameter{"/materials/N/melanin",
              "--melanin",
              numbers_by_name,
              {0, 100},
              "",
              "eumelanin, pheomelanin",
              "0 each; without any color eumelanin 1.3",
              "concentrations of eumelanin and pheomelanin",
              true},
    Parameter{"/materials/N/sigma_a", "--sigma-a", triple, of(fiber::sigma_a_range), "", "", "",
              "absorption, RGB, per major semi-axis", true},
    Parameter{"/SOURCE/ramp",
              "",
              number,
              {0, 1e6},
              "",
              "",
              "",
              "places of a [source](#sources): `[[place, value], ...]`, places rising"},
    Parameter{"/SOURCE/along", "", choice, none, "", "share, root_cm, tip_cm", "share",
              "what places of a ramp are: shares of the length from the root, or cm from the root or from the tip"},
    Parameter{"/SOURCE/interpolation", "", choice, none, "", "linear, smooth", "linear",
              "between the stops of a ramp; smooth: without corners at them"},
    Parameter{
        "/SOURCE/share", "", number, share, "", "", "of a mix needed",
        "of the second of two values: of `mix`, in place of the first; of `random`, the share of the strands that "
        "have it, and the others have the first",
        true},
    Parameter{"/SOURCE/seed", "", whole, seeds, "", "", "0", "of `random`: other strands for another number"},
    Parameter{"/SOURCE/attribute", "", text, none, "", "", "", "name of an attribute of the groom's file"},
    Parameter{"/SOURCE/texture", "", text, none, "", "", "", "a path to a PNG or EXR over the root uv of the groom"},
    Parameter{"/SOURCE/space", "", choice, none, "", "srgb, linear", "srgb",
              "of a PNG: its numbers are colors as sRGB has them, or shares of the largest, as of a mask"},
    Parameter{"/materials/N/azimuthal_sigma_deg", "", numbers_by_name, of(fiber::azimuthal_sigma_range_deg), degrees,
              "TT, TRT, TRRT", "by the roughness", "blur of the exit azimuth: a standard deviation"},
    Parameter{"/materials/N/longitudinal_lambda_deg", "", numbers_by_name, of(fiber::longitudinal_lambda_range_deg),
              degrees, "R, TT, TRT, TRRT", "by the roughness", "logistic scale in theta_h"},
    Parameter{"/materials/N/longitudinal_shape", "", choice, none, "", "logistic, gaussian, cauchy", "logistic",
              "of the lobes in theta_h, with the same width at half height"},
    Parameter{"/materials/N/fresnel", "", choice, none, "", "exact, longitudinal, bravais, none", "exact",
              "of R; only `exact` conserves energy"},
    Parameter{"/materials/N/gain", "", numbers_by_name, of(fiber::gain_range), "", "R, TT, TRT, TRRT, residual, GLINT",
              "1 each", "factor of a lobe; above 1 a fiber may return more than it receives", true},
    Parameter{"/materials/N/tint", "", triples_by_name, share, "", "R, TT, TRT, TRRT, residual, GLINT",
              "[1, 1, 1] each", "factor by channel; GLINT without a gain or tint has that of TRT", true},
    Parameter{"/materials/N/glint", "", only_true, none, "", "", "",
              "GLINT is a lobe and layer of its own; naming GLINT above does so too"},
    Parameter{"/materials/N/curl_diameter_cm",
              "",
              number,
              {0.05, 1000},
              cm,
              "",
              "by the eccentricity",
              "turns of the major axis along the strand"},
    Parameter{"/materials/N/twist", "", flag, none, "", "", "true",
              "false: the major axis does not turn; not used where a file's normals give it"},
    Parameter{"/materials/N/root_angle_deg", "", number, turn, degrees, "", "by a hash of the strand",
              "major axis at the root; not used where a file's normals give it"},
    Parameter{"/materials/N/principled/roughness", "", number, share, "", "", "0.3",
              "of Blender's Principled Hair and its like: longitudinal; with `aspect_ratio` that of the surface"},
    Parameter{"/materials/N/principled/radial_roughness", "", number, share, "", "", "0.3",
              "azimuthal; not beside `aspect_ratio`"},
    Parameter{"/materials/N/principled/coat", "", number, share, "", "", "0",
              "share of its roughness that the first reflection lacks; not beside `aspect_ratio`"},
    Parameter{"/materials/N/principled/eta", "", number, of(fiber::eta_range), "", "", "1.55", "index of refraction"},
    Parameter{"/materials/N/principled/offset_deg",
              "",
              number,
              {-90, 90},
              degrees,
              "",
              "2",
              "tilt of the cuticle scales, taken for the nearest in 0..15"},
    Parameter{"/materials/N/principled/aspect_ratio", "", number, of(fiber::eccentricity_range), "", "", "",
              "minor over major semi-axis: elliptical fibers (Huang), in place of round ones (Chiang)"},
    Parameter{"/materials/N/principled/melanin", "", number, share, "", "", "this, `color` or `sigma_a`",
              "as the node has it", true},
    Parameter{"/materials/N/principled/redness", "", number, share, "", "", "1",
              "share of pheomelanin; beside `melanin`"},
    Parameter{"/materials/N/principled/tint", "", triple, share, "", "", "[1, 1, 1]",
              "a dye over the melanin, linear RGB; beside `melanin`"},
    Parameter{"/materials/N/principled/color", "", either, share, "", "file", "",
              "multiple scattering albedo, linear RGB; \"file\": that of the file, by strand or along it", true},
    Parameter{"/materials/N/principled/sigma_a", "", triple, of(fiber::sigma_a_range), "", "", "",
              "absorption, RGB, per radius", true},
    Parameter{"/materials/N/principled/random_color", "", number, share, "", "", "0",
              "strands differ in melanin by a factor of 1 - this to 1 + this"},
    Parameter{"/materials/N/principled/random_roughness", "", number, share, "", "", "0",
              "the same of both roughnesses"},
    Parameter{"/materials/N/principled/widths", "", choice, none, "", "fitted, published", "by the model",
              "of the lobes: fitted, so that those of `elliptical` look like the node's; published: the node's own. "
              "Without it published for `chiang2016`, fitted for all others; not beside `aspect_ratio`"},
    Parameter{"/materials/N/chiang_hair_bsdf/tint_R", "", triple, share, "", "", "[1, 1, 1]",
              "of MaterialX's `chiang_hair_bsdf`, whose inputs these are: factor of the lobe, linear RGB"},
    Parameter{"/materials/N/chiang_hair_bsdf/tint_TT", "", triple, share, "", "", "[1, 1, 1]", "the same of TT"},
    Parameter{"/materials/N/chiang_hair_bsdf/tint_TRT", "", triple, share, "", "", "[1, 1, 1]",
              "the same of TRT and all after it"},
    Parameter{"/materials/N/chiang_hair_bsdf/roughness_R", "", numbers_by_name, Range{1e-6, 10}, "",
              "longitudinal, azimuthal", "0.1, 0.1",
              "variance of the inclination and logistic scale of the azimuth, in radians, as the node has them; the "
              "azimuth of R is that of the fiber"},
    Parameter{"/materials/N/chiang_hair_bsdf/roughness_TT", "", numbers_by_name, Range{1e-6, 10}, "",
              "longitudinal, azimuthal", "0.05, 0.05", "the same of TT"},
    Parameter{"/materials/N/chiang_hair_bsdf/roughness_TRT", "", numbers_by_name, Range{1e-6, 10}, "",
              "longitudinal, azimuthal", "0.2, 0.2", "the same of TRT and all after it"},
    Parameter{"/materials/N/chiang_hair_bsdf/ior", "", number, of(fiber::eta_range), "", "", "1.55",
              "index of refraction"},
    Parameter{"/materials/N/chiang_hair_bsdf/cuticle_angle", "", number, share, "", "", "0.5",
              "the scales are tilted by 180 degrees times this less 0.5, taken for the nearest in 0..15"},
    Parameter{"/materials/N/chiang_hair_bsdf/absorption_coefficient", "", triple, of(fiber::sigma_a_range), "", "",
              "[0, 0, 0]", "absorption, RGB, per radius"},
    Parameter{"/materials/N/marschner/specularGainR", "", number, of(fiber::gain_range), "", "", "1",
              "of RenderMan's PxrMarschnerHair, whose parameters these are, taken for fibers of this program: factor "
              "of the lobe"},
    Parameter{"/materials/N/marschner/specularGainTRT", "", number, of(fiber::gain_range), "", "", "1",
              "the same of TRT"},
    Parameter{"/materials/N/marschner/specularGainTT", "", number, of(fiber::gain_range), "", "", "1",
              "the same of TT"},
    Parameter{"/materials/N/marschner/specularGainGLINTS", "", number, of(fiber::gain_range), "", "", "1",
              "the same of the glints of TRT"},
    Parameter{"/materials/N/marschner/specularColorR", "", triple, share, "", "", "[1, 1, 1]",
              "tint of the lobe, linear RGB"},
    Parameter{"/materials/N/marschner/specularColorTRT", "", triple, share, "", "", "[0.4, 0.4, 0.4]",
              "the same of TRT and its glints; not used beside `hair_color`"},
    Parameter{"/materials/N/marschner/specularColorTT", "", triple, share, "", "", "[0.4, 0.4, 0.4]",
              "the same of TT; not used beside `hair_color`"},
    Parameter{"/materials/N/marschner/specularConeAngleR", "", number, Range{0, 90}, degrees, "", "8",
              "taken as the standard deviation of the inclination of R; the roughness follows it"},
    Parameter{"/materials/N/marschner/specularConeAngleTRT", "", number, Range{0, 90}, degrees, "", "8",
              "the same of TRT"},
    Parameter{"/materials/N/marschner/specularConeAngleTT", "", number, Range{0, 90}, degrees, "", "8",
              "the same of TT"},
    Parameter{"/materials/N/marschner/specularOffset", "", number, Range{-90, 90}, degrees, "", "-3",
              "shift of R; its negative is the tilt of the scales, taken for the nearest in 0..15"},
    Parameter{"/materials/N/marschner/specularIor", "", number, of(fiber::eta_range), "", "", "1.55",
              "index of refraction"},
    Parameter{"/materials/N/marschner/specularGlintWidth", "", number, Range{0, 90}, degrees, "", "10",
              "blur of the azimuth of TRT, taken for the nearest in 0.5..45"},
    Parameter{"/materials/N/marschner/specularEccentricity", "", number, of(fiber::eccentricity_range), "", "", "1",
              "minor over major semi-axis"},
    Parameter{"/materials/N/marschner/presence", "", number, share, "", "", "1", "the same as the material's"},
    Parameter{"/materials/N/marschner/specularMixFresnel", "", number, share, "", "", "1",
              "another value than 1 is left out, with a warning"},
    Parameter{"/materials/N/marschner/specularEnergyCompensation", "", number, share, "", "", "0",
              "left out with a warning, as all below"},
    Parameter{"/materials/N/marschner/eccentricityDirection", "", triple, world, "", "", "[0, 0, 0]", "left out"},
    Parameter{"/materials/N/marschner/diffuseModelType", "", whole, share, "", "", "0", "left out"},
    Parameter{"/materials/N/marschner/diffuseGain", "", number, factor, "", "", "0",
              "left out: light goes on from fiber to fiber until it leaves the hair"},
    Parameter{"/materials/N/marschner/diffuseColor", "", triple, share, "", "", "[0.18, 0.18, 0.18]", "left out"},
    Parameter{"/materials/N/marschner/glowGain", "", number, factor, "", "", "0", "left out"},
    Parameter{"/materials/N/marschner/glowColor", "", triple, share, "", "", "[1, 1, 1]", "left out"},
    Parameter{"/materials/N/marschner/shadowColor", "", triple, share, "", "", "[0, 0, 0]", "left out"},
    Parameter{"/materials/N/marschner/hair_color/mode", "", whole, share, "", "", "0",
              "of RenderMan's PxrHairColor: 0 takes the melanins, 1 the colors"},
    Parameter{"/materials/N/marschner/hair_color/melanin", "", number, share, "", "", "0.2", "eumelanin", true},
    Parameter{"/materials/N/marschner/hair_color/randomMelanin", "", number, share, "", "", "0.05",
              "strands have this much more or less at most"},
    Parameter{"/materials/N/marschner/hair_color/darkenRoots", "", number, share, "", "", "0",
              "melanin added at the root, falling to none at `darkenEndPosition`"},
    Parameter{"/materials/N/marschner/hair_color/darkenEndPosition", "", number, share, "", "", "0.5",
              "share of the length"},
    Parameter{"/materials/N/marschner/hair_color/strayDensity", "", number, share, "", "", "0.1",
              "share of stray strands, which have the melanin or color below"},
    Parameter{"/materials/N/marschner/hair_color/strayMelanin", "", number, share, "", "", "0.05", "their melanin"},
    Parameter{"/materials/N/marschner/hair_color/strayRandomMelanin", "", number, share, "", "", "0",
              "the same as `randomMelanin`"},
    Parameter{"/materials/N/marschner/hair_color/color", "", triple, share, "", "", "[0, 0.3, 0.1]",
              "color of a dense lock", true},
    Parameter{"/materials/N/marschner/hair_color/strayColor", "", triple, share, "", "", "[0.05, 0.05, 0.05]",
              "the same of stray strands"},
    Parameter{"/materials/N/marschner/hair_color/dye", "", triple, share, "", "", "[1, 1, 1]",
              "a dye over either, linear RGB"},
    Parameter{"/materials/N/marschner/hair_color/darkenSlope", "", number, factor, "", "", "1",
              "another value than 1 is left out, with a warning"},
    Parameter{"/materials/N/marschner/hair_color/randomColor", "", triple, share, "", "", "[0, 0, 0]",
              "left out with a warning, as all below"},
    Parameter{"/materials/N/marschner/hair_color/strayRandomColor", "", triple, share, "", "", "[0, 0, 0]", "left out"},
    Parameter{"/materials/N/marschner/hair_color/randomDyeHue", "", number, share, "", "", "0", "left out"},
    Parameter{"/materials/N/marschner/hair_color/randomDyeSaturation", "", number, share, "", "", "0", "left out"},
    Parameter{"/materials/N/medulla/radius", "", number, of(fiber::medulla_radius_range), "", "", "needed",
              "share of the semi-axes of the fiber that its core has, which scatters and has no pigment; seen by the "
              "models `rough` and `fiber3d` only",
              true},
    Parameter{"/materials/N/medulla/scattering", "", number, of(fiber::medulla_scattering_range), "", "", "0",
              "scattering coefficient, per major semi-axis", true},
    Parameter{"/materials/N/medulla/asymmetry", "", number, of(fiber::medulla_asymmetry_range), "", "", "0",
              "mean cosine of a scattering: above 0 it goes forwards", true},
    Parameter{"/materials/N/medulla/absorption", "", number, of(fiber::medulla_absorption_range), "", "", "0",
              "absorption coefficient, of all colors alike, per major semi-axis", true},
    Parameter{"/materials/N/variation/eccentricity",
              "",
              number,
              {0, 0.25},
              "",
              "",
              "0",
              "half range over the strands, uniform, absolute"},
    Parameter{"/materials/N/variation/width", "", number, half_range, "", "", "0",
              "half range of one factor of the roughness and of every width given"},
    Parameter{"/materials/N/variation/color", "", number, half_range, "", "", "0",
              "half range of one factor of the absorption"},
    Parameter{"/materials/N/variation/seed", "", whole, seeds, "", "", "0", "other strands for another number"},
    Parameter{
        "/grooms/N/file", "", text, none, "", "", "this or `generate`",
        "a path to a groom: .hair, .abc, .usda, .usdc, .usdz, .pbrt, .ply, .data, recognized by content; #### in its "
        "name is the "
        "number of the frame"},
    Parameter{"/grooms/N/points_per_strand",
              "--points-per-strand",
              whole,
              {2, 65535},
              "",
              "",
              "as the file says, else 100",
              "files of bare points (PLY): points of every strand"},
    Parameter{"/grooms/N/generate", "", choice, none, "",
              "curly_lock, straight, wavy, curly, layered, curtain, fur_ball, single_fiber", "",
              "a kind of groom that needs no file (below)"},
    Parameter{
        "/grooms/N/name", "", text, none, "", "", "of the file or kind",
        "what mattes call it (`CryptoObject`; `CryptoMaterial` has the name of its material); equal names are one "
        "matte"},
    Parameter{"/grooms/N/strands", "", whole, {1, 1e6}, "", "", "by kind", "generated only; 10^8 points at most"},
    Parameter{"/grooms/N/seed", "", whole, seeds, "", "", "0", "generated only; another groom for another number"},
    Parameter{"/grooms/N/radius_cm", "--radius", number, radius, cm, "", "the file's, or 0.004",
              "of the circle with the same mean projected width"},
    Parameter{
        "/grooms/N/widths", "--widths", text, none, "", "", "as they are where a unit is said",
        "files only: `file` takes its widths as they are, in a unit that is guessed too; `clamp` brings each to a "
        "radius of 0.0005 to 0.05 cm; `scale=2` takes them twice as large; 0 hides"},
    Parameter{"/grooms/N/taper",
              "",
              numbers_by_name,
              {0, 10},
              "",
              "root, tip",
              "1, 1; generated 1, 0.4 but for `single_fiber`",
              "factors of the radius, linear along the length of the strand"},
    Parameter{"/grooms/N/basis", "", choice, none, "",
              "bspline, linear, catmull_rom, clamped_catmull_rom, open_bspline, open_catmull_rom, bezier, hermite",
              "the file's, else bspline",
              "of what does not say: uniform cubic B-splines that the points control (through root and tip, rounding "
              "bends), straight from point to point, smooth through every point (clamped: with ends repeated, as "
              "Blender draws it); open ones end before their first and "
              "last point; Bezier segments (3 n + 1 points), point and tangent in turn"},
    Parameter{"/grooms/N/up", "--up", choice, none, "", "y, z",
              "the file's, else z; of a bare file by how its strands fall",
              "files only: axis of the file that points up; y becomes z, z becomes -y"},
    Parameter{"/grooms/N/cm_per_unit", "--cm-per-unit", number, per_unit, cm, "", "the file's, else longest side 30 cm",
              "files only: length of a unit of the file"},
    Parameter{"/grooms/N/normals", "", flag, none, "", "", "true",
              "files only: normals of the file are the minor axes of the fibers; false: axes are the material's"},
    Parameter{
        "/grooms/N/scale", "", number, {1e-6, 1e6}, "", "", "1", "of the whole groom, radii too, after the above"},
    Parameter{"/grooms/N/rotate_deg",
              "",
              triple,
              {-360, 360},
              "degrees",
              "",
              "[0, 0, 0]",
              "turns about x, then y, then z, after the scale"},
    Parameter{"/grooms/N/translate", "", triple, {-1e6, 1e6}, cm, "", "[0, 0, 0]", "after the turn"},
    Parameter{"/grooms/N/frames/N/frame", "", whole, frames, "", "", "needed", "a keyframe's number; as of a mesh"},
    Parameter{
        "/grooms/N/instances/N/scale",
        "",
        number,
        {1e-6, 1e6},
        "",
        "",
        "1",
        "of an instance, after the above; beside it `rotate_deg`, `translate` and `frames` as in a groom; instances "
        "share the groom's strands and replace it"},
    Parameter{"/grooms/N/material", "", text, none, "", "", "the first", "its name; without any materials: brown hair"},
    Parameter{"/grooms/N/looks/N/material", "", text, none, "", "", "needed",
              "the name of another material, for some of the strands; the others have the groom's"},
    Parameter{"/grooms/N/looks/N/share", "", number, share, "", "", "needed",
              "the share of strands that have it, of all together at most 1; asked at their roots", true},
    Parameter{"/grooms/N/visible", "", flag, none, "", "", "true", "as `meshes/N/visible`"},
    Parameter{"/grooms/N/casts_shadow", "", flag, none, "", "", "true", "as `meshes/N/casts_shadow`; also in itself"},
    Parameter{"/grooms/N/visible_indirect", "", flag, none, "", "", "true",
              "as `meshes/N/visible_indirect`; where not, its strands also get no light from each other"},
    Parameter{"/grooms/N/length_cm", "", number, {0.1, 1000}, cm, "", "by kind", "length along the fall"},
    Parameter{"/grooms/N/length_variation", "", number, half_range, "", "", "by kind",
              "half range of a factor of the length"},
    Parameter{"/grooms/N/clump", "", number, share, "", "", "by kind", "how far strands gather towards the tips"},
    Parameter{"/grooms/N/frizz", "", number, share, "", "", "by kind", "flyaways and wandering"},
    Parameter{"/grooms/N/wavelength_cm",
              "",
              number,
              {0.2, 1000},
              cm,
              "",
              "by kind",
              "length of one wave or turn along the fall"},
    Parameter{"/grooms/N/wave_amplitude_cm", "", number, {0, 10}, cm, "", "by kind", "of waves, to one side"},
    Parameter{"/grooms/N/curl_diameter_cm", "", number, {0, 20}, cm, "", "by kind", "of curls; 0: none"},
    Parameter{"/grooms/N/width_cm", "", number, {0.1, 1000}, cm, "", "by kind", "across, at the roots"},
    Parameter{"/grooms/N/ball_radius_cm", "", number, {0.1, 1000}, cm, "", "by kind", "of the ball under the fur"},
    Parameter{"/expected/radiance",
              "",
              triple,
              {0, 1e6},
              "",
              "",
              "",
              "the answer of a scene that has one; does not change the picture"},
    Parameter{"", "--resolution", whole, pixels, "", "", "the scene's", "width and height in pixels, 2^26 in all"},
    Parameter{"", "--frame", whole, frames, "", "", "0, or the first keyframe",
              "frame of what moves: the camera, a turntable, grooms and meshes"},
    Parameter{"", "--strict", flag, none, "", "", "",
              "what a file of strands has and the picture does not show is an error, not a note"},
    Parameter{"", "--chunk", whole, {1, 1 << 20}, "", "", "1", "frames of a task"},
    Parameter{"",
              "--split-samples",
              whole,
              {1, 1 << 16},
              "",
              "",
              "",
              "tasks that share the samples of each frame, which are merged"},
    Parameter{"", "--calibrate-first", flag, none, "", "", "",
              "the first task is the first frame alone; the others wait for it and start from its table"},
    Parameter{"", "--retries", whole, {0, 1000}, "", "", "2", "of a task that fails"},
    Parameter{"", "--at-most", whole, {1, 1 << 20}, "", "", "all", "tasks at a time"},
    Parameter{"", "--task", whole, {0, 1 << 20}, "", "", "", "its number"},
    Parameter{"", "--overwrite", flag, none, "", "", "", "of --frames: render those that are finished too"},
    Parameter{"",
              "--checkpoint-interval",
              number,
              {0, 1e6},
              "seconds",
              "",
              "30",
              "between two writes, more where they would take more than 0.01 of the time; 0: as often as that allows"},
    Parameter{
        "",
        "--checkpoint-deadline",
        number,
        {0, 1e6},
        "seconds",
        "",
        "20",
        "after SIGTERM, SIGINT or SIGHUP, in which the running pass may end; after it the checkpoint before stays"},
    Parameter{"", "--samples-from", whole, {0, 1 << 20}, "", "", "0", "the first sample of each pixel to render"},
    Parameter{
        "", "--samples-to", whole, {1, 1 << 20}, "", "", "the scene's number of samples", "the sample to stop before"},
    Parameter{"",
              "--time",
              number,
              {0, 1e7, true},
              "seconds",
              "",
              "",
              "as many samples as fit, one at least; the picture then depends on the machine"},
    Parameter{"", "--noise", number, accuracy, "", "", "",
              "samples until the noise relative to the brightness of what is covered is at most this, 16384 at most"},
    Parameter{"", "--denoise", flag, none, "", "", "",
              "filter R, G, B along the hair at the end: the PNG and the layer `denoised`; biased, so that R, G, B of "
              "the EXR stay as rendered; --noise is then that of the filtered picture"},
    Parameter{"", "--threads", whole, {1, 1024}, "", "", "one per hardware thread", "threads to work with"},
    Parameter{"",
              "--seed",
              whole,
              {0, past_uint64},
              "",
              "",
              "0",
              "same seed, same result, for any number of threads; a render without it takes the number of its frame"},
    Parameter{"", "--light-samples", whole, paths, "", "", "2", "samples of the lights at the first hit"},
    Parameter{"", "--bcsdf-samples", whole, paths, "", "", "1", "samples of the fiber at the first hit"},
    Parameter{"", "--max-depth", whole, paths, "", "", "256", "hits of a path"},
    Parameter{"",
              "--deep-light-depth",
              whole,
              {2, 1 << 20},
              "",
              "",
              "3",
              "the first hit of a path that --deep-light learned answers"},
    Parameter{"",
              "--quadrature-points",
              whole,
              {1, 65536},
              "",
              "",
              "by model",
              "points over the width of the fiber, for models that integrate at every vertex"},
    Parameter{
        "", "--picture-error", number, accuracy, "", "", "",
        "in place of --epsilon: the relative error that fits may make in the picture; each row is then learned as "
        "well as the light it carries asks for"},
    Parameter{
        "",
        "--measure-bias",
        number,
        {0, 1, true},
        "",
        "",
        "",
        "share of the samples that are traced a second time without rows, 0.01 say: how far the brightness of the "
        "picture is off is reported with its standard error"},
    Parameter{
        "",
        "--near",
        number,
        {0, 1e6},
        "",
        "",
        "2",
        "where hits are traced from the place where the ray met the fiber, which rows do not know: where a fiber "
        "is seen wider than this, in pixels (all from twice the width on); touching: there, and where fibers touch, "
        "with more noise under small lights; 0 or nowhere: at no hit; everywhere: at all"},
    Parameter{"",
              "--components",
              whole,
              {1, 8},
              "",
              "",
              "8",
              "components of a row, at most or, for learners of a fixed number, exactly"},
    Parameter{"", "--epsilon", number, accuracy, "", "", "0.01",
              "error under which a row is converged, of all rows alike: of elliptical the relative squared error; of "
              "rough chi-square, and 0.07 without the option, 0.25 at most where there is little light"},
    Parameter{"", "--table-memory", number, {0, 1 << 20}, "MB of 2^20 bytes", "", "256", "ceiling of the table"},
    Parameter{"",
              "--cache-limit",
              number,
              {0, 1 << 24},
              "MB of 2^20 bytes",
              "",
              "1024",
              "what --warm-cache default may take of the disk: the kinds of fiber that were used longest ago go"},
    Parameter{"",
              "--limit",
              number,
              {0, 1 << 24},
              "MB of 2^20 bytes",
              "",
              "1024",
              "what is to be left at most: the kinds of fiber that were used longest ago go"},
    Parameter{"", "--light-scale", number, factor, "", "", "1",
              "factor of the light of the environment and every light"},
    Parameter{"", "--e", number, of(fiber::eccentricity_range), "", "", "0.85", "minor over major semi-axis"},
    Parameter{"", "--theta-d", number, {-89.9, 89.9}, degrees, "", "30", "difference angle"},
    Parameter{"", "--phi", number, turn, degrees, "", "45", "azimuth of the known direction from the major axis"},
    Parameter{"", "--sigma", number, of(fiber::azimuthal_sigma_range_deg), degrees, "", "10",
              "blur of the exit azimuth"},
    Parameter{"", "--eta", number, of(fiber::eta_range), "", "", "1.55", "index of refraction"},
    Parameter{"", "--samples", whole, {1, 1 << 20}, "", "", "360", "azimuths printed"},
    Parameter{"", "--alpha", number, of(fiber::roughness_range), "", "", "0.2", "Beckmann roughness of the surface"},
    Parameter{"", "--tilt", number, of(fiber::tilt_range_deg), degrees, "", "3", "tilt of the cuticle scales"},
    Parameter{"",
              "--theta-r",
              number,
              {-89.9, 89.9},
              degrees,
              "",
              "30",
              "inclination of the known direction, from the normal plane towards the tip"},
    Parameter{"", "--phi-r", number, turn, degrees, "", "45",
              "azimuth of the known direction from the major axis towards the minor one"},
    Parameter{"", "--bins", whole, {1, 720}, "", "", "36x36", "bins of theta_i and of phi_i"},
    Parameter{"",
              "--paths",
              whole,
              {1, 1e9},
              "",
              "",
              "1000000",
              "paths that are traced, or directions at which a model is evaluated"},
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
  for (const std::string_view part : {"/ramp/N/N", "/random/N", "/mix/N", "/sum/N", "/root", "/tip"}) {
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
