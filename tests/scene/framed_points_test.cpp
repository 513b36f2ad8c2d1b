// The same strands have the same frame, whatever basis their points are of.
#include "scene/model/framed_points.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "scene/model/camera.h"
#include "scene/read/grooms/curve_bases.h"

namespace {

using namespace tress;
using namespace tress::scene;
using ::testing::ElementsAreArray;

using Points = std::vector<glm::vec3>;

/// Points that are no round numbers, some near 0 beside far ones.
Points strand_of(int points, float seed) {
  Points strand;
  for (int i = 0; i < points; ++i) {
    const auto t = static_cast<float>(i);
    strand.emplace_back(7 * std::sin(0.9f * t + seed), 3e-4f * t + std::cos(1.3f * t * seed), 0.01f - 1.7f * t);
  }
  return strand;
}

Points framed(StrandBasis basis, const Points& strand) {
  Points out;
  append_framed_points(basis, strand, &out);
  return out;
}

Points with_mirrored_ends(const Points& strand) {
  Points out{2.0f * strand[0] - strand[1]};
  out.insert(out.end(), strand.begin(), strand.end());
  out.push_back(2.0f * strand.back() - strand[strand.size() - 2]);
  return out;
}

Points as_bezier_points(StrandBasis basis, const Points& strand) {
  const std::uint32_t first[] = {0, static_cast<std::uint32_t>(strand.size())};
  return as_bezier<glm::vec3>(basis, first, strand);
}

Groom groom_of(StrandBasis basis, const std::vector<Points>& strands) {
  Groom groom;
  groom.basis = basis;
  groom.first_point = {0};
  for (const Points& strand : strands) {
    groom.points.insert(groom.points.end(), strand.begin(), strand.end());
    groom.first_point.push_back(static_cast<std::uint32_t>(groom.points.size()));
  }
  return groom;
}

TEST(FramedPoints, PolygonsAndSplinesThroughTheirEndsHaveTheirPoints) {
  const Points strand = strand_of(6, 0.4f);
  EXPECT_THAT(framed(StrandBasis::linear, strand), ElementsAreArray(strand));
  EXPECT_THAT(framed(StrandBasis::bspline, strand), ElementsAreArray(strand));
}

/// As XGen and pbrt write a strand: the same camera to the bit, all the way round, too.
TEST(FramedPoints, OpenSplinesWithMirroredEndsHaveTheSameCamera) {
  std::vector<Points> plain, open;
  for (const float seed : {0.4f, 1.1f, 2.3f, 5.9f}) {
    plain.push_back(strand_of(9, seed));
    open.push_back(with_mirrored_ends(plain.back()));
  }
  const std::vector<Groom> a{groom_of(StrandBasis::bspline, plain)}, b{groom_of(StrandBasis::open_bspline, open)};
  const Camera one = frame_grooms(a, {}, {}), other = frame_grooms(b, {}, {});
  EXPECT_EQ(one.eye, other.eye);
  EXPECT_EQ(one.look_at, other.look_at);
  EXPECT_EQ(frame_grooms_all_round(a, {}, {}, {}).eye, frame_grooms_all_round(b, {}, {}, {}).eye);
}

/// The curve of an open B-spline begins at (a + 4 b + c) / 6. Tolerance: 4 roundings of coordinates below 16.
TEST(FramedPoints, OpenSplinesBeginWhereTheirCurvesDo) {
  const Points strand = strand_of(7, 0.4f), found = framed(StrandBasis::open_bspline, strand);
  ASSERT_EQ(found.size(), strand.size());
  const glm::vec3 begin = (strand[0] + 4.0f * strand[1] + strand[2]) / 6.0f;
  EXPECT_LT(glm::distance(found.front(), begin), 4e-6f);
  EXPECT_GT(glm::distance(found.front(), strand[1]), 0.1f);
  EXPECT_EQ(found[1], strand[1]);
}

/// As pbrt's and Blender's Bezier curves may have a spline. Tolerance: control points are found again from Bezier
/// points by three products and a difference of coordinates below 32, each rounded by 2e-6 at most.
TEST(FramedPoints, BezierSegmentsOfASplineHaveItsControlPoints) {
  const Points strand = strand_of(8, 2.3f);
  const Points of_bezier = framed(StrandBasis::bezier, as_bezier_points(StrandBasis::bspline, strand));
  ASSERT_EQ(of_bezier.size(), strand.size() + 2);  // both ends twice
  for (std::size_t i = 0; i < strand.size(); ++i) EXPECT_LT(glm::distance(of_bezier[i + 1], strand[i]), 2e-5f) << i;
}

TEST(FramedPoints, OtherBezierSegmentsHaveTheirPoints) {
  const Points corner{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {3, 0, 1}, {3, 0, 2}, {3, 0, 3}};
  EXPECT_THAT(framed(StrandBasis::bezier, corner), ElementsAreArray(corner));
  const Points one{{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}};
  EXPECT_THAT(framed(StrandBasis::bezier, one), ElementsAreArray(one));
}

TEST(FramedPoints, GroomsWithoutPointsHaveNoBox) {
  EXPECT_FALSE(box_of_strands(StrandBasis::open_bspline, std::vector<std::uint32_t>{0, 0}, {}));
  EXPECT_FALSE(middle_of({Groom{}}));
}

}  // namespace
