// The light that comes after a hit, learned from the paths themselves. Roulette and splitting use it, and it can
// replace paths.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scene/model/scene.h"

namespace tress::integrate {

/// Roulette and splitting by the light that a path may still bring and by the cost of following it. This is the
/// efficiency-aware rule of Rath, Grittmann, Herholz, Weier and Slusallek, "EARS: Efficiency-Aware Russian Roulette and
/// Splitting" (2022), after the adjoint-driven one of Vorba and Krivanek (2016). A hit has the path weight w, and after
/// it comes light L at a cost C. It is followed by
///
///     q = w sqrt(E[L^2] / E[C]) sqrt(C_0 / V_0)
///
/// copies in the mean, each with weight 1/q. V_0 and C_0 are variance and cost of one sample of a pixel. This minimizes
/// the variance of the picture times its cost. Where q is above 1, the variance of L replaces its square, because
/// copies average only that. Any q leaves the mean as it is, so what is learned changes only the time that a picture
/// takes.
///
/// E[L^2], E[L] and E[C] are kept by place, in an octree that refines where hits are, and by direction of the light
/// that leaves, in 24 classes. The estimate of a cell includes that of the cell around it, with the weight of `prior`
/// paths. L is in units of the picture's mean radiance, C in hits.
///
/// Thread-safety: any thread may call place, copies, answer and note during a pass; they see the state of the last
/// update(). One thread calls update, between passes. Notes are sums of integers, so their order does not matter.
class DeeperLight {
 public:
  /// answers: whether answer() will be called.
  explicit DeeperLight(const scene::Scene& scene, bool answers = false);

  static constexpr int directions = 24;
  /// Bounds of the mean number of copies: at least one path in 20 survives, with weight 20, and at most 8 go on.
  static constexpr float least_copies = 0.05f, most_copies = 8;

  /// The cell of light that leaves `point` along `direction` (unit, world).
  std::size_t place(const glm::vec3& point, const glm::vec3& direction) const;

  /// Whether enough has been learned to use copies(), and the picture has noise. If not, the caller uses another rule.
  bool is_ready() const { return ready_; }
  /// Mean number of copies, in [least_copies, most_copies], of a path with the weight `throughput` by channel. Call it
  /// only if is_ready().
  float copies(std::size_t place, const glm::vec3& throughput) const;

  /// The mean light that leaves a place, linear RGB. Call it only if can_answer().
  glm::vec3 answer(std::size_t place) const;
  /// Whether answers were requested and enough has been learned. Constant between two updates.
  bool can_answer() const { return can_answer_; }

  /// Notes the light that one copy brought from its hit on, and its number of hits. Ignores light that is not finite.
  void note(std::size_t place, const glm::vec3& light, std::uint64_t hits) const;
  /// Notes the light of a copy that an answer replaces. weight: the factor of the answer in the picture, over the
  /// copy's chance of being followed. Answers are means with these weights, by channel, so they are right in the mean
  /// over the hits where they are used.
  void note_for_answers(std::size_t place, const glm::vec3& light, const glm::vec3& weight) const;

  /// Values of the pixels so far, which scale the notes and copies().
  struct PictureSoFar {
    double mean = 0;      ///< radiance of the pixels that show something, mean over channels
    double variance = 0;  ///< variance of one sample of a pixel, mean over pixels and channels
    double hits = 0;      ///< mean cost of a sample: its hits plus 1
  };
  /// Whether update() has enough new paths: an eighth more than at the last update.
  bool is_due(std::uint64_t paths) const { return paths >= paths_before_ + paths_before_ / 8 && paths > 0; }
  /// Learns from the notes. As long as the mean is not above 0, the unit of light is unknown and nothing is noted.
  void update(const PictureSoFar& picture, std::uint64_t paths);

  std::size_t place_count() const { return nodes_.size() * directions; }
  std::uint64_t noted() const { return noted_; }  ///< number of copies learned from
  std::size_t bytes() const;                      ///< bytes of the cells; up to twice as many are allocated

  /// All that was learned, for set_state() of an object for the same scene, which then goes on to the same bits.
  std::string state() const;
  /// Returns false and changes nothing if that is not a valid state.
  bool set_state(std::string_view state);

 private:
  static constexpr std::size_t most_nodes = 8192;  ///< 20 MB, and as much again while they grow
  static constexpr double prior = 64;              ///< weight of the cell around a cell, in paths
  static constexpr double refine_from = 512;       ///< notes of a leaf from which it gets children
  static constexpr double least_notes = 512;       ///< notes in all that is_ready() needs
  static constexpr double answer_prior = 16;       ///< `prior` for answer(), in paths
  static constexpr double least_answered = 4096;   ///< paths of note_for_answers() that can_answer() needs

  /// Notes between two updates, with light in 2^-20 of the unit.
  struct Notes {
    std::atomic<std::uint64_t> count_and_hits{0};  ///< count in the upper 28 bits
    std::atomic<std::uint64_t> light{0}, squares{0};
  };
  /// Weighted sums of note_for_answers(), by channel.
  struct ColorSums {
    glm::dvec3 light{0.0}, weight{0.0};
    double count = 0;
    void add(const ColorSums& more) {
      light += more.light;
      weight += more.weight;
      count += more.count;
    }
  };
  struct ColorNotes {
    std::array<std::atomic<std::uint64_t>, 3> light{}, weight{};
    std::atomic<std::uint64_t> count{0};
    ColorSums taken();
  };
  struct Sums {
    double count = 0, light = 0, squares = 0, hits = 0;
  };
  /// Values that copies() reads: sqrt(E[L^2] / E[C]) and the same with the variance of L.
  struct Answer {
    float of_square = 0, of_variance = 0;
  };
  struct Node {
    std::uint64_t parent = 0;
    std::array<Sums, directions> sums{};
    std::array<Sums, directions> expected{};  ///< means per copy, from the node's sums and its parent; count is 1
  };

  /// Light of a place in the unit: the notes, and their mean, as Node::expected.
  struct Color {
    ColorSums sums;
    glm::dvec3 expected{0.0};
  };

  bool answers() const { return !colors_.empty(); }
  double asked() const;  ///< number of paths of note_for_answers()
  static Sums taken(Notes& notes);
  void gather();
  void expect();
  void refine();
  void make_room();  ///< makes room for the notes of all nodes; drops notes if it allocates
  void add_children(std::uint32_t node);

  glm::vec3 low_{0.0f};
  float per_edge_ = 0;                      ///< 1 over the edge of the root cube, 1/cm
  std::vector<Node> nodes_;                 ///< children after their parents
  std::vector<std::uint32_t> first_child_;  ///< first of the eight children of each node; 0 for a leaf
  std::vector<std::array<Answer, directions>> answers_;
  std::unique_ptr<std::array<Notes, directions>[]> notes_;  ///< by node
  std::vector<Color> colors_;                               ///< by place; empty if answers were not requested
  std::unique_ptr<ColorNotes[]> color_notes_;               ///< by place
  std::size_t room_ = 0;                                    ///< number of nodes that notes_ has room for
  double unit_ = 0;                                         ///< radiance of the unit of light; 0 while it is unknown
  float per_unit_ = 0;
  float scale_ = 0;  ///< factor of the answers
  bool ready_ = false, can_answer_ = false;
  std::uint64_t paths_before_ = 0, noted_ = 0;
};

}  // namespace tress::integrate
