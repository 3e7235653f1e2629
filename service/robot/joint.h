/// The kinds of joints: what each is, in one table. Whatever depends on a joint's kind follows from its row.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace torqued
{

/// How a link moves with its parent; numbered as in model_info_t.
enum class JointKind : std::int8_t
{
  floating = 0, ///< x, z and an angle against the world: the root
  revolute = 1, ///< turns about a point of the parent
  rolling = 2,  ///< its circle rolls without slip on the parent's circle; a massless bar holds the centres together
  parallel = 3, ///< moves with a point of the parent and does not turn; only with a fixed root
  slide = 4,    ///< rides on a point of the parent and slides sideways, out of the plane
  fixed = 5     ///< rides on the parent at a constant angle; the root: on the world, at angle 0
};

/// An angle φ = own θ + parent φ_parent + world φ_world + constant, θ being the link's own coordinate.
struct AngleShares
{
  double own, parent, world;

  /// The same sum of other numbers: rates, rows of W.
  template <typename T> T of(const T& theta, const T& of_parent, const T& of_world) const
  {
    return own * theta + parent * of_parent + world * of_world;
  }
};

/// What a kind of joint is.
struct JointType
{
  /// What carries a link of this kind.
  enum class Carrier
  {
    parent,
    parent_or_world, ///< on the world it is the root
    none             ///< it is the root
  };
  /// What the link's member of θ is.
  enum class Coordinate
  {
    none,
    angle,
    displacement ///< sideways; what is N m, rad elsewhere is N, m here
  };

  std::string_view name; ///< in files
  Carrier carrier;
  Coordinate coordinate;
  AngleShares angle; ///< of the link
  /// A massless bar leads from the joint to the link. The constant angle is then the bar's, whose shares follow from
  /// the radii (Link::bar_shares()).
  bool bar;
  std::string_view constant;  ///< what Link::angle is measured against, as texts say it; empty: it is 0
  std::string_view urdf_type; ///< of the joint in a URDF; empty: none says that

  bool moves() const { return coordinate != Coordinate::none; }
  bool slides() const { return coordinate == Coordinate::displacement; }
  bool floats() const { return carrier == Carrier::none; }
};

/// By number.
// clang-format off
inline constexpr std::array<JointType, 6> kJointTypes{{
    // name       carrier                              coordinate                           own parent world    bar    constant angle         URDF
    {"floating", JointType::Carrier::none,            JointType::Coordinate::angle,        {1.0, 0.0, 0.0}, false, "",                   "floating"},
    {"revolute", JointType::Carrier::parent,          JointType::Coordinate::angle,        {1.0, 0.0, 0.0}, false, "",                   "continuous"},
    {"rolling",  JointType::Carrier::parent,          JointType::Coordinate::angle,        {1.0, 0.0, 0.0}, true,  "of the bar",         "continuous"},
    {"parallel", JointType::Carrier::parent,          JointType::Coordinate::none,         {0.0, 0.0, 1.0}, false, "against the world",  ""},
    {"slide",    JointType::Carrier::parent,          JointType::Coordinate::displacement, {0.0, 1.0, 0.0}, false, "",                   "prismatic"},
    {"fixed",    JointType::Carrier::parent_or_world, JointType::Coordinate::none,         {0.0, 1.0, 0.0}, false, "against the parent", "fixed"},
}};
// clang-format on

inline const JointType& type_of(JointKind kind)
{
  return kJointTypes[static_cast<std::size_t>(kind)];
}

} // namespace torqued
