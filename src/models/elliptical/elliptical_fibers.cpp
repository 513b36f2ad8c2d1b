#include "models/elliptical/elliptical_fibers.h"

#include <algorithm>
#include <utility>

#include "models/elliptical/vertex_trace.h"
#include "tress/fiber/elliptical_model.h"

namespace tress::inline v0_2::fiber {

std::array<std::optional<adaptive::SliceDescription>, 4> elliptical_slices(const FiberParameters& fiber) {
  const std::array<float, 3> sigmas = azimuthal_sigmas(fiber);
  const std::array<float, 4> sigma{sigmas[0], sigmas[1], sigmas[2], sigmas[1]};
  const std::array<int, 4> slice_lobes{1, fiber.split_glint ? trt_rest_slice : 2, 3, glint_slice};
  std::array<std::optional<adaptive::SliceDescription>, 4> slices;
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    if (row_lobes[i] == Lobe::glint && !fiber.split_glint) continue;
    slices[i] =
        elliptical_slice(slice_lobes[i], fiber.eta, fiber.eccentricity, std::max(sigma[i], smallest_grid_sigma));
  }
  return slices;
}

FiberId EllipticalFibers::add(const FiberParameters& parameters) {
  const auto slices = elliptical_slices(parameters);
  const auto is_refused = [this](const auto& slice) { return slice && !service_->add_slice(*slice); };
  if (service_ != nullptr && std::ranges::any_of(slices, is_refused)) return no_fiber;
  const FiberId id = store_.add(parameters);
  if (id < fibers_.size()) return id;

  EllipticalFiber fiber;
  fiber.parameters = parameters;
  fiber.widths = LobeWidths::as_traced(parameters);
  const std::array<float, 3> sigmas = azimuthal_sigmas(parameters);
  fiber.sigma = {sigmas[0], sigmas[1], sigmas[2], sigmas[1]};
  fiber.energies = store_[id].energies;
  fiber.answers_by_rows = service_ != nullptr;
  for (std::size_t i = 0; i < row_lobes.size(); ++i) {
    fiber.vertex_rays = std::max(fiber.vertex_rays, vertex_ray_count(fiber.sigma[i]));
    fiber.proposes_only[i] = is_below_grid(fiber.sigma[i]);
    fiber.answers_by_rows = fiber.answers_by_rows && !fiber.proposes_only[i];
    if (service_ != nullptr && slices[i]) fiber.rows[i] = rows_of(*slices[i], parameters.sigma_a);
  }
  fibers_.push_back(std::move(fiber));
  return id;
}

std::shared_ptr<const ColoredRows> EllipticalFibers::rows_of(const adaptive::SliceDescription& description,
                                                             const glm::vec3& sigma_a) {
  std::shared_ptr<const SliceRows>& slice = slices_[description.key];
  if (!slice) slice = std::make_shared<const SliceRows>(*service_, description);
  std::shared_ptr<const ColoredRows>& shared = colored_rows_[{slice->slice, {sigma_a.r, sigma_a.g, sigma_a.b}}];
  if (!shared) shared = std::make_shared<const ColoredRows>(*service_, slice, sigma_a);
  return shared;
}

std::size_t EllipticalFibers::bytes() const {
  std::size_t bytes = store_.bytes() + fibers_.size() * sizeof(EllipticalFiber);
  for (const auto& [key, rows] : colored_rows_) bytes += rows->bytes();
  return bytes;
}

}  // namespace tress::inline v0_2::fiber
