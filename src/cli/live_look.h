// The sliders of the live page: what they are of a scene, and what they make of the settings of a render.
#pragma once

#include <vector>

#include "cli/render_settings.h"
#include "live/render_server.h"
#include "scene/model/scene.h"

namespace tress::cli {

/// Of the first material; empty where the files of the render tell of one picture alone (checkpoint, parts of samples,
/// telemetry).
std::vector<live::RenderServer::Slider> sliders_of(const RenderSettings& settings, const scene::Scene& scene);

/// The settings that the same values would make as options of the command line. look: of those sliders.
RenderSettings with_look(const RenderSettings& settings, const live::RenderServer::Look& look);

}  // namespace tress::cli
