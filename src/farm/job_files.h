// Writes a farm as a job of OpenJD or of Flamenco, in their file formats.
#pragma once

#include <filesystem>
#include <string>

#include "farm/plan.h"

namespace tress::farm {

/// A job template of Open Job Description 2023-09, as JSON: a step of tasks, and a merge that depends on it; if the
/// first frame calibrates, it is a step before them. Source: the specification's "Template Schemas".
std::string openjd_template(const Plan& plan, const std::filesystem::path& folder, const std::string& name);

/// The job type for Flamenco 3, to be put into `scripts/` of its Manager: JavaScript, the same for every farm.
std::string flamenco_job_type();
/// The job of that type, as JSON for POST /api/v3/jobs.
std::string flamenco_job(const Plan& plan, const std::filesystem::path& folder, const std::string& name);

}  // namespace tress::farm
