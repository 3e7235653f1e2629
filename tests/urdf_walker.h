/// A small URDF with room for whatever an exporter may write.
#pragma once

#include "robot/files/strict_toml.h"
#include "robot/files/urdf_robot.h"
#include "robot/robot.h"

#include <fmt/format.h>
#include <string>
#include <string_view>

namespace torqued
{

/// A trunk on two thighs; every part has mass to the side of the plane, and products of inertia, so that no tilt of a
/// frame goes unseen.
struct Walker
{
  std::string head, left_hip, right_hip, tail;
  std::string left_origin = "<origin xyz=\"0.02 0.1 -0.05\"/>", left_axis = "0 -1 0";
  std::string left_com = "0.01 0.03 -0.12", left_inertia_rpy = "0 0 0";

  std::string text() const
  {
    const std::string tensor =
        "<inertia ixx=\"0.4\" ixy=\"0.01\" ixz=\"0.02\" iyy=\"0.42\" iyz=\"0.03\" izz=\"0.05\"/>";
    return "<robot name=\"walker\">\n" + head +
           "\n<link name=\"trunk\"><inertial><origin xyz=\"0.01 0.02 0.25\"/><mass value=\"11\"/>" + tensor +
           "</inertial></link>\n<link name=\"left_thigh\"><inertial><origin xyz=\"" + left_com + "\" rpy=\"" +
           left_inertia_rpy + "\"/><mass value=\"6\"/>" + tensor +
           "</inertial></link>\n<link name=\"right_thigh\"><inertial><origin xyz=\"0.01 -0.03 -0.12\"/><mass "
           "value=\"6\"/>" +
           tensor + "</inertial></link>\n" +
           "<joint name=\"left_hip\" type=\"revolute\"><parent link=\"trunk\"/><child link=\"left_thigh\"/>" +
           left_origin + "<axis xyz=\"" + left_axis + "\"/>" + left_hip + "</joint>\n" +
           "<joint name=\"right_hip\" type=\"continuous\"><parent link=\"trunk\"/><child link=\"right_thigh\"/>"
           "<origin xyz=\"0.02 -0.1 -0.05\"/><axis xyz=\"0 -1 0\"/>" +
           right_hip + "</joint>\n" + tail + "</robot>\n";
  }

  Robot robot() const { return read_urdf_robot(text(), "w.urdf"); }

  std::string complaint() const
  {
    try
    {
      robot();
      return "";
    }
    catch (const FileError& error)
    {
      return error.what();
    }
  }
};

inline Walker with_head(const std::string& head)
{
  Walker walker;
  walker.head = head;
  return walker;
}

inline Walker with_tail(const std::string& tail)
{
  Walker walker;
  walker.tail = tail;
  return walker;
}

inline Walker with_hip(const std::string& left_hip)
{
  Walker walker;
  walker.left_hip = left_hip;
  return walker;
}

inline std::string link_element(std::string_view name, std::string_view mass = "")
{
  return mass.empty() ? fmt::format("<link name=\"{}\"/>", name)
                      : fmt::format("<link name=\"{}\"><inertial><mass value=\"{}\"/><inertia ixx=\"0.2\" ixy=\"0\" "
                                    "ixz=\"0\" iyy=\"0.2\" iyz=\"0\" izz=\"0.2\"/></inertial></link>",
                                    name, mass);
}

inline std::string joint_element(std::string_view name, std::string_view type, std::string_view parent,
                                 std::string_view child, std::string_view axis = "", std::string_view more = "")
{
  return fmt::format("<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/>{}{}</joint>", name, type,
                     parent, child, axis.empty() ? "" : fmt::format("<axis xyz=\"{}\"/>", axis), more);
}

inline std::string all_notes(const Robot& robot)
{
  std::string text;
  for (const std::string& note : robot.notes)
    text += note + "\n";
  return text;
}

} // namespace torqued
