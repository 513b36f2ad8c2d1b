// The sliders and the color of the live page: their values for a scene, and their effect on the settings of a render.
#pragma once

#include <string>
#include <vector>

#include "cli/render_settings.h"
#include "live/render_server.h"
#include "scene/model/scene.h"

namespace tress::cli {

/// The sliders for the first material; empty if files of the render are for one picture only (checkpoint, parts of
/// samples, telemetry).
std::vector<live::RenderServer::Slider> sliders_of(const RenderSettings& settings, const scene::Scene& scene);

/// The color of the first material as that of a lock: three numbers, or a ramp of them if it varies along strands.
live::RenderServer::Json color_of(const scene::Scene& scene);

/// What is wrong with a color as JSON; empty if nothing is.
std::string fault_of_color(const std::string& json);

/// The settings that result from the same values as options of the command line. look: values of those sliders; its
/// color replaces the melanin.
RenderSettings with_look(const RenderSettings& settings, const live::RenderServer::Look& look);

}  // namespace tress::cli
