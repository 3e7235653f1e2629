#include "robot/urdf_model.h"

#include <Eigen/Geometry>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued::urdf
{

namespace
{

constexpr double kNoted = 1e-9;  // rad; what is less is nobody's rounding but that of doubles
constexpr double kExact = 1e-12; // rad; so near to ±y a frame is left as it is

// the angle between a unit vector and ±y
double from_y(const Eigen::Vector3d& unit)
{
  return std::atan2(std::hypot(unit.x(), unit.z()), std::abs(unit.y()));
}

Eigen::Vector3d nearest_y(const Eigen::Vector3d& v)
{
  return {0.0, v.y() < 0.0 ? -1.0 : 1.0, 0.0};
}

// the smallest turn that makes a unit vector ±y, whichever is nearer
Eigen::Matrix3d turn_to_y(const Eigen::Vector3d& unit)
{
  return Eigen::Quaterniond::FromTwoVectors(unit, nearest_y(unit)).toRotationMatrix();
}

// that one of a frame's axes which is nearest to ±y
Eigen::Vector3d most_sideways(const Eigen::Matrix3d& R)
{
  Eigen::Index column = 0;
  R.row(1).cwiseAbs().maxCoeff(&column);
  return R.col(column);
}

bool is_rounded(double angle)
{
  return angle > kExact && angle <= kRoundedAngle;
}

// how far a frame is out of the plane, if that is what rounding does; else 0
double tilt_of(const Eigen::Matrix3d& R)
{
  const double angle = from_y(most_sideways(R));
  return is_rounded(angle) ? angle : 0.0;
}

// the last rpy by which a joint's frame is turned, as a complaint names it; empty if there is none
std::string last_rpy(const Model& model, const Joint& joint)
{
  for (const Joint* at = &joint;; at = &model.joint(model.link(at->parent).joint))
  {
    if (!at->origin.rpy.isZero(0.0))
      return fmt::format("; the rpy of joint '{}' is ({}, {}, {})", at->name, at->origin.rpy.x(), at->origin.rpy.y(),
                         at->origin.rpy.z());
    if (model.link(at->parent).joint < 0)
      return "";
  }
}

// refuses an axis that is not ±y; returns how far it is from there
double check_axis(const Model& model, const Joint& joint, const Eigen::Vector3d& axis)
{
  const double angle = from_y(axis);
  if (angle <= kRoundedAngle)
    return angle;
  const bool turns = joint.type == Joint::Type::revolute;
  model.fail(joint, fmt::format(
                        "axis: found {}, which is {} in the root's frame, {:.3g} rad from {}y{}; expected one parallel "
                        "to y within {:g} rad, as angles of five digits are: {}",
                        shown(*joint.axis), shown(axis), angle, axis.y() < 0.0 ? "-" : "+", last_rpy(model, joint),
                        kRoundedAngle,
                        turns ? "the robot moves in the x-z plane"
                              : "what slides in the x-z plane is not a sum of constant rotated vectors, unless it "
                                "carries the root: two such joints and one about y, from the world on, with no mass "
                                "between them"));
}

} // namespace

std::string shown(const Eigen::Vector3d& v)
{
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z());
}

Eigen::Matrix3d level(const Eigen::Matrix3d& R)
{
  return tilt_of(R) > 0.0 ? Eigen::Matrix3d(turn_to_y(most_sideways(R)) * R) : R;
}

Eigen::Vector3d axis_of(const Model& model, const Joint& joint, const Eigen::Matrix3d& R)
{
  if (!joint.axis)
    model.fail(joint, "axis: is missing; URDF then takes x, and here it must be parallel to y");
  const Eigen::Vector3d axis = (R * *joint.axis).stableNormalized();
  if (!(axis.norm() > 0.5))
    model.fail(joint, fmt::format("axis: found {}; expected a direction", shown(*joint.axis)));
  return axis;
}

void align_frames(Model& model)
{
  std::vector<std::string> rounded;
  for (const int i : model.order)
  {
    Link& link = model.link(i);
    double tilt = 0.0;
    if (i != model.root)
    {
      Joint& joint = model.joint(link.joint);
      const Link& parent = model.link(joint.parent);
      joint.origin.at = parent.R * joint.origin.at;
      link.R = parent.R * joint.origin.R;
      tilt = tilt_of(link.R);
      Eigen::Matrix3d R = level(link.R);
      if (joint.type != Joint::Type::fixed)
      {
        const Eigen::Vector3d axis = axis_of(model, joint, link.R);
        const double angle = check_axis(model, joint, axis);
        joint.sense = axis.y() > 0.0 ? 1.0 : -1.0;
        if (tilt == 0.0 && from_y(most_sideways(R)) > kRoundedAngle && is_rounded(angle))
          R = turn_to_y(axis) * R; // a frame that stands askew is in the plane by its axis
        tilt = std::max(tilt, angle);
      }
      link.R = R;
      if (tilt > kNoted)
        rounded.push_back(fmt::format("joint '{}' by {:.3g} rad", joint.name, tilt));
    }
    const Eigen::Matrix3d inertia_R = link.R * link.inertia_R;
    if (const double angle = tilt_of(inertia_R); angle > kNoted && !link.inertia.isZero(0.0))
      rounded.push_back(fmt::format("the inertia of '{}' by {:.3g} rad", link.name, angle));
    link.inertia_R = level(inertia_R);
  }
  if (!rounded.empty())
    model.notes.push_back(fmt::format("{}: out of the x-z plane, as rounded angles are, and read as in it: {}",
                                      model.file, fmt::join(rounded, ", ")));
}

} // namespace torqued::urdf
