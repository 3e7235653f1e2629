#include "robot/files/urdf_model.h"

#include <Eigen/Geometry>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued::urdf
{

namespace
{

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
  const Eigen::Vector3d axis = unit.cross(nearest_y(unit));
  return axis.isZero(0.0) ? Eigen::Matrix3d::Identity()
                          : Eigen::AngleAxisd(from_y(unit), axis.normalized()).toRotationMatrix();
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

[[noreturn]] void refuse_axis(const Model& model, const Joint& joint, const Eigen::Vector3d& axis)
{
  model.fail(
      joint,
      fmt::format("axis: found {}, which is {} in the root's frame, {:.3g} rad from {}y{}; expected one parallel to y "
                  "within {:g} rad, as angles of five digits are: {}",
                  shown(*joint.axis), shown(axis), from_y(axis), axis.y() < 0.0 ? "-" : "+", last_rpy(model, joint),
                  kRoundedAngle,
                  joint.type == Joint::Type::revolute
                      ? "the robot moves in the x-z plane"
                      : "what slides in the x-z plane is not a sum of constant rotated vectors, unless it carries the "
                        "root: two such joints and one about y, from the world on, with no mass between them"));
}

void remember(Model& model, const std::string& name, double angle)
{
  constexpr double noted = 1e-9; // rad; what is less is nobody's rounding but that of doubles
  if (angle > noted)
    model.rounded[name] = std::max(model.rounded[name], angle);
}

// the child's frame of a joint that moves, seen from the root: in the plane by itself or, if it stands askew, by the
// joint's axis
Eigen::Matrix3d level_by_axis(Model& model, Joint& joint, const Eigen::Matrix3d& R)
{
  const Eigen::Vector3d axis = axis_of(model, joint, R);
  if (!is_about_y(model, joint, axis))
    refuse_axis(model, joint, axis);
  joint.sense = axis.y() > 0.0 ? 1.0 : -1.0;
  if (from_y(most_sideways(R)) > kRoundedAngle && is_rounded(from_y(axis)))
    return turn_to_y(axis) * R;
  return level(model, R, name_of(joint));
}

} // namespace

std::string shown(const Eigen::Vector3d& v)
{
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z());
}

std::string name_of(const Joint& joint)
{
  return fmt::format("joint '{}'", joint.name);
}

Eigen::Matrix3d level(Model& model, const Eigen::Matrix3d& R, const std::string& name)
{
  const Eigen::Vector3d sideways = most_sideways(R);
  if (!is_rounded(from_y(sideways)))
    return R;
  remember(model, name, from_y(sideways));
  return turn_to_y(sideways) * R;
}

bool is_about_y(Model& model, const Joint& joint, const Eigen::Vector3d& axis)
{
  const double angle = from_y(axis);
  if (angle > kRoundedAngle)
    return false;
  remember(model, name_of(joint), angle);
  return true;
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
  for (const int i : model.order)
  {
    Link& link = model.link(i);
    if (i != model.root)
    {
      Joint& joint = model.joint(link.joint);
      const Eigen::Matrix3d parent = model.link(joint.parent).R;
      joint.origin.at = parent * joint.origin.at;
      const Eigen::Matrix3d R = parent * joint.origin.R;
      link.R = joint.type == Joint::Type::fixed ? level(model, R, name_of(joint)) : level_by_axis(model, joint, R);
    }
    link.inertia_R = link.R * link.inertia_R;
    if (!link.inertia.isZero(0.0))
      link.inertia_R = level(model, link.inertia_R, fmt::format("the inertia of '{}'", link.name));
  }
  std::vector<std::string> rounded;
  for (const auto& [name, angle] : model.rounded)
    rounded.push_back(fmt::format("{} by {:.3g} rad", name, angle));
  if (!rounded.empty())
    model.notes.push_back(fmt::format("{}: out of the x-z plane, as rounded angles are, and read as in it: {}",
                                      model.file, fmt::join(rounded, ", ")));
}

} // namespace torqued::urdf
