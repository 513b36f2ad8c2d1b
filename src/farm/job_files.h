// A farm as a job of OpenJD and of Flamenco: the files that those take.
#pragma once

#include <filesystem>
#include <string>

#include "farm/plan.h"

namespace tress::farm {

/// A job template of Open Job Description 2023-09, as JSON: a step of tasks and a merge that depends on it; where the
/// first frame calibrates, a step before them. Source: the specification's "Template Schemas".
std::string openjd_template(const Plan& plan, const std::filesystem::path& folder, const std::string& name);

/// Flamenco 3's job type, for `scripts/` of its Manager: JavaScript, the same for every farm.
std::string flamenco_job_type();
/// The job of that type, for POST /api/v3/jobs, as JSON.
std::string flamenco_job(const Plan& plan, const std::filesystem::path& folder, const std::string& name);

}  // namespace tress::farm
