#include "robot/assembly/steps.h"

#include <algorithm>
#include <set>

namespace torqued
{

namespace
{

// Turns the links of a description into a mechanism.
class LinkAssembly
{
public:
  explicit LinkAssembly(const RobotDescription& description) : description_(description) {}

  Robot robot()
  {
    resolve_links();
    number_coordinates();
    place_links();
    Robot robot{.name = description_.name,
                .source = description_.source,
                .links = links_,
                .order = order_,
                .absolute_names = absolute_names_,
                .mechanism = mechanism()};
    if (!fixed_root())
      robot.base_names = description_.base_names;
    return robot;
  }

private:
  Link& at(int index) { return links_[static_cast<std::size_t>(index)]; }
  const Link& at(int index) const { return links_[static_cast<std::size_t>(index)]; }

  void resolve_links()
  {
    if (description_.links.empty())
      fail(description_, 1, "there is no [[link]]; a robot needs at least its root");
    if (description_.links.size() > kMaxLinks)
      fail(description_, description_.links[kMaxLinks],
           fmt::format("there are {} links; at most {} are possible", description_.links.size(), kMaxLinks));
    std::set<std::string_view> names;
    for (const auto& entry : description_.links)
    {
      if (!names.insert(entry.link.name).second)
        fail(description_, entry, fmt::format("two links are called \"{}\"; names must differ", entry.link.name));
      links_.push_back(entry.link);
    }
    for (std::size_t i = 0; i < links_.size(); ++i)
    {
      const auto& entry = description_.links[i];
      const bool on_world = entry.parent == kWorld;
      const JointType& joint = links_[i].type();
      if (joint.carrier != JointType::Carrier::none && !on_world)
        links_[i].parent =
            link_index(description_, entry.parent, entry, fmt::format("link '{}': parent", links_[i].name));
      else if (on_world && joint.carrier != JointType::Carrier::parent_or_world)
        fail(description_, entry,
             fmt::format("link '{}' is {} on the world; a root that does not float is fixed there", links_[i].name,
                         joint.name));
      else if (root_ >= 0)
        fail(description_, entry,
             fmt::format("links '{}' and '{}' are both roots; one root carries all others", at(root_).name,
                         links_[i].name));
      else
        root_ = static_cast<int>(i);
    }
    if (root_ < 0)
      fail(description_, description_.links.front(),
           "there is no root: one link must have joint = \"floating\", or joint = \"fixed\" and parent = \"world\"");
    order_from_root();
  }

  // parents before children, whatever the file's order
  void order_from_root()
  {
    order_ = {root_};
    for (std::size_t done = 0; done < order_.size(); ++done)
      for (std::size_t i = 0; i < links_.size(); ++i)
        if (links_[i].parent == order_[done])
          order_.push_back(static_cast<int>(i));
    for (std::size_t i = 0; i < links_.size(); ++i)
      if (std::find(order_.begin(), order_.end(), static_cast<int>(i)) == order_.end())
        fail(description_, description_.links[i],
             fmt::format("link '{}' does not hang on the root: its parents form a circle", links_[i].name));
  }

  // θ: the coordinates in the file's order, then the angle of a fixed root
  void number_coordinates()
  {
    for (std::size_t i = 0; i < links_.size(); ++i)
    {
      if (!links_[i].type().moves())
        continue;
      links_[i].coordinate = num_theta_++;
      absolute_names_.push_back(description_.links[i].coordinate);
      if (num_theta_ + (fixed_root() ? 1 : 0) + 2 > kMaxCoordinates)
        fail(description_, description_.links[i],
             fmt::format("link '{}' is one too many that moves; at most {} are possible", links_[i].name,
                         num_theta_ - 1));
    }
    if (fixed_root())
      at(root_).coordinate = num_theta_++;
  }

  // Each link's direction and origin. The first directions are the members of θ, though what slides turns nothing; bars
  // follow.
  void place_links()
  {
    W_ = Eigen::MatrixXd::Identity(num_theta_, num_theta_);
    for (const int i : order_)
    {
      Link& link = at(i);
      link.direction = link.coordinate;
      if (i != root_)
        place_link(link, at(link.parent), description_.links[static_cast<std::size_t>(i)]);
      link.heading = unit(link.direction_angle);
    }
  }

  void place_link(Link& link, const Link& parent, const RobotDescription::LinkEntry& entry)
  {
    const JointType& joint = link.type();
    if (joint.angle.world != 0.0 && !fixed_root())
      fail(description_, entry,
           fmt::format("link '{}' is parallel to the world, but the root floats: nothing could hold it; the "
                       "root must be fixed to the world",
                       link.name));
    link.origin = point_of(parent, link.at);
    link.slides = parent.slides;
    if (joint.slides())
      link.slides.push_back(link.coordinate);
    if (joint.bar)
      place_bar(link, parent, entry);

    // the link's angle: that of a direction that is there, or a mixture of such
    const auto& [own, of_parent, of_world] = joint.angle;
    link.direction = own == 1.0 && of_parent == 0.0 && of_world == 0.0   ? link.coordinate
                     : own == 0.0 && of_parent == 1.0 && of_world == 0.0 ? parent.direction
                     : own == 0.0 && of_parent == 0.0 && of_world == 1.0 ? at(root_).direction
                                                                         : add_direction(joint.angle, link, parent);
    link.direction_angle =
        of_parent * parent.direction_angle + (joint.bar || joint.constant.empty() ? 0.0 : link.angle);
  }

  // the bar between the circles' centres, a direction of its own
  void place_bar(Link& link, const Link& parent, const RobotDescription::LinkEntry& entry)
  {
    const double length = link.parent_radius + link.child_radius;
    if (!(length > 0.0))
      fail(description_, entry,
           fmt::format("link '{}': parent_radius and child_radius are both 0; that is a revolute joint", link.name));
    const AngleShares shares = link.bar_shares();
    const double angle = shares.parent * parent.direction_angle + link.angle;
    link.origin.push_back({add_direction(shares, link, parent), rotate(unit(angle), {0.0, -length})});
  }

  int add_direction(const AngleShares& shares, const Link& link, const Link& parent)
  {
    using Row = Eigen::RowVectorXd;
    const Row own = link.coordinate < 0 ? Row::Zero(num_theta_) : Row(W_.row(link.coordinate));
    const Row row = shares.of<Row>(own, W_.row(parent.direction), W_.row(at(root_).direction));
    W_.conservativeResize(W_.rows() + 1, Eigen::NoChange);
    W_.bottomRows<1>() = row;
    return static_cast<int>(W_.rows()) - 1;
  }

  bool fixed_root() const { return !at(root_).type().floats(); }

  Mechanism mechanism() const
  {
    std::vector<Body> bodies;
    double mass = 0.0;
    for (const Link& link : links_)
    {
      bodies.push_back(body_of(link));
      mass += link.mass;
    }
    if (!(mass > 0.0))
      fail(description_, description_.links.front(), "all links are massless; the robot's mass must be positive");
    return Mechanism(W_, bodies, description_.gravity);
  }

  const RobotDescription& description_;
  std::vector<Link> links_;
  std::vector<int> order_;
  std::vector<std::string> absolute_names_;
  Eigen::MatrixXd W_;
  int root_ = -1, num_theta_ = 0;
};

} // namespace

Point point_of(const Link& link, const Eigen::Vector2d& r)
{
  Point point = link.origin;
  const Eigen::Vector2d turned = rotate(unit(link.direction_angle), r);
  const auto same =
      std::find_if(point.begin(), point.end(), [&](const Arm& arm) { return arm.direction == link.direction; });
  if (same != point.end())
    same->r += turned;
  else
    point.push_back({link.direction, turned});
  return point;
}

Robot assemble_links(const RobotDescription& description)
{
  return LinkAssembly(description).robot();
}

} // namespace torqued
