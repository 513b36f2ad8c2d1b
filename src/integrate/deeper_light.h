// The light that still comes after a hit, learned from the paths themselves: what roulette and splitting go by, and
// what can be taken in place of paths.
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

/// Roulette and splitting by what a path may still bring and what following it costs: the efficiency-aware rule of
/// Rath, Grittmann, Herholz, Weier and Slusallek, "EARS: Efficiency-Aware Russian Roulette and Splitting" (2022), after
/// the adjoint-driven one of Vorba and Krivanek (2016). A hit whose paths so far were worth w, of light L to come with
/// cost C, is followed by
///
///     q = w sqrt(E[L^2] / E[C]) sqrt(C_0 / V_0)
///
/// copies in the mean, each weighing 1/q: this makes the variance of the picture times its cost least, V_0 and C_0
/// being variance and cost of one sample of a pixel. Where q is above 1 the variance of L stands for its square, since
/// copies average only that. Whatever q is, the mean is untouched: what is learned, from whatever light, costs or saves
/// time and nothing else.
///
/// E[L^2], E[L] and E[C] are kept by place, an octree that refines where hits are, and by direction of the light that
/// leaves, 24 classes. A cell that few paths have met leans on the cell around it, as if that were `prior` paths more.
/// L is in units of the picture's mean radiance, C in hits.
///
/// Thread-safety: place, copies, answer, note: any thread, during a pass; they see what the last update() left. update:
/// one thread, between passes. Notes are sums of integers, so that the threads do not show.
class DeeperLight {
 public:
  /// answers: whether answer() will be asked.
  explicit DeeperLight(const scene::Scene& scene, bool answers = false);

  static constexpr int directions = 24;
  /// Mean copies are between these: one in 20 survives at the least, and weighs 20; at the most 8 go on.
  static constexpr float least_copies = 0.05f, most_copies = 8;

  /// The cell of light that leaves `point` along `direction` (unit, world).
  std::size_t place(const glm::vec3& point, const glm::vec3& direction) const;

  /// Whether enough has been learned to go by, and the picture has noise: else the caller has a rule of its own.
  bool is_ready() const { return ready_; }
  /// Mean number of copies, [least_copies, most_copies], of a path that has the weight `throughput` by channel. Not
  /// before is_ready().
  float copies(std::size_t place, const glm::vec3& throughput) const;

  /// The mean light that leaves a place, linear RGB. Not before can_answer().
  glm::vec3 answer(std::size_t place) const;
  /// Whether it is asked to, and enough has been learned. Constant between two updates.
  bool can_answer() const { return can_answer_; }

  /// What one copy brought from its hit on, and how many hits it took. Light that is not finite is not noted.
  void note(std::size_t place, const glm::vec3& light, std::uint64_t hits) const;
  /// The same of a copy that an answer stands for, `weight` being what the answer is multiplied with, over the copy's
  /// chance of being followed: answers are means weighted so, by channel, and right in the mean over where they are
  /// asked.
  void note_for_answers(std::size_t place, const glm::vec3& light, const glm::vec3& weight) const;

  /// Of the pixels so far: what notes and copies() are measured by.
  struct PictureSoFar {
    double mean = 0;      ///< radiance of the pixels that show something, mean over channels
    double variance = 0;  ///< of one sample of a pixel, mean over pixels and channels
    double hits = 0;      ///< mean cost of a sample: hits, and 1 for what comes before them
  };
  /// Whether update() has enough to take in after so many paths: an eighth more than the last time.
  bool is_due(std::uint64_t paths) const { return paths >= paths_before_ + paths_before_ / 8 && paths > 0; }
  /// Takes in what has been noted. Without a mean above 0 the unit of light stays unknown, and nothing is noted.
  void update(const PictureSoFar& picture, std::uint64_t paths);

  std::size_t place_count() const { return nodes_.size() * directions; }
  std::uint64_t noted() const { return noted_; }  ///< copies in the table
  std::size_t bytes() const;                      ///< of the cells; up to twice as much is set aside

  /// All that it knows, for set_state() of one of the same scene, which then goes on to the same bits.
  std::string state() const;
  /// False: that is no such state; nothing is changed.
  bool set_state(std::string_view state);

 private:
  static constexpr std::size_t most_nodes = 8192;  ///< 20 MB, and room for as much while they grow
  static constexpr double prior = 64;              ///< paths
  static constexpr double refine_from = 512;       ///< notes of a node
  static constexpr double least_notes = 512;       ///< of all, to be ready
  static constexpr double answer_prior = 16;       ///< paths, as `prior`, of answer()
  static constexpr double least_answered = 4096;   ///< paths of note_for_answers(), of all

  /// Between two updates. Light in 2^-20 of the unit.
  struct Notes {
    std::atomic<std::uint64_t> count_and_hits{0};  ///< count in the upper 28 bits
    std::atomic<std::uint64_t> light{0}, squares{0};
  };
  /// Of paths that are met where answers are asked, by channel, weighted by what they are worth there.
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
  /// What copies() reads: sqrt(E[L^2] / E[C]) and the same of the variance.
  struct Answer {
    float of_square = 0, of_variance = 0;
  };
  struct Node {
    std::uint64_t parent = 0;
    std::array<Sums, directions> sums{};
    std::array<Sums, directions> expected{};  ///< a copy: the node's own, leaning on its parent's; count 1
  };

  /// Of a place, in the unit: what was noted, and its mean as Node::expected.
  struct Color {
    ColorSums sums;
    glm::dvec3 expected{0.0};
  };

  bool answers() const { return !colors_.empty(); }
  double asked() const;  ///< paths of note_for_answers()
  static Sums taken(Notes& notes);
  void gather();
  void expect();
  void refine();
  void make_room();  ///< for the notes of all nodes; drops what is noted if there was too little
  void add_children(std::uint32_t node);

  glm::vec3 low_{0.0f};
  float per_edge_ = 0;                      ///< 1/cm, of the root cube
  std::vector<Node> nodes_;                 ///< children after their parents
  std::vector<std::uint32_t> first_child_;  ///< of each node, of eight; 0: a leaf
  std::vector<std::array<Answer, directions>> answers_;
  std::unique_ptr<std::array<Notes, directions>[]> notes_;  ///< of each node
  std::vector<Color> colors_;                               ///< by place; empty: nothing is to be answered
  std::unique_ptr<ColorNotes[]> color_notes_;               ///< by place
  std::size_t room_ = 0;                                    ///< nodes that notes_ has room for
  double unit_ = 0;                                         ///< radiance; 0: not known yet
  float per_unit_ = 0;
  float scale_ = 0;  ///< what the answers are multiplied with
  bool ready_ = false, can_answer_ = false;
  std::uint64_t paths_before_ = 0, noted_ = 0;
};

}  // namespace tress::integrate
