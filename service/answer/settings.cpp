#include "answer/settings.h"

#include "methods/constrained.h"

#include "robot/fnv.h"

#include <array>
#include <fmt/format.h>

namespace torqued
{

namespace
{

constexpr std::array<std::string_view, 3> kOnExcess{"flag", "refuse", "clamp"};
constexpr std::array<std::string_view, 3> kInfeasible{"relax", "refuse", "nearest"};
constexpr std::array<std::string_view, 2> kMetric{"mass", "angles"};
constexpr std::array<std::string_view, 2> kContacts{"rest", "as-desired"};

// Hashes each setting behind its key.
class Hash : public SettingList
{
public:
  void boolean(std::string_view key, bool& value, std::string_view) override { add(key, value ? 1.0 : 0.0); }
  void number(std::string_view key, double& value, const Range&, std::string_view) override { add(key, value); }
  void number_or(std::string_view key, std::optional<double>& value, std::string_view word, const Range&,
                 std::string_view) override
  {
    if (value)
      add(key, *value);
    else
      hash_.add(word);
  }
  void three(std::string_view key, Eigen::Vector3d& value, std::string_view, std::string_view) override
  {
    for (const double number : value)
      add(key, number);
  }
  void weights(std::string_view key, JointWeights& value) override
  {
    for (const double number : value.reshaped())
      add(key, number);
  }
  void word(std::string_view key, int& value, std::span<const std::string_view>, std::string_view) override
  {
    add(key, value);
  }
  void table(std::string_view name) override { hash_.add(name); }

  std::int64_t id() const { return hash_.id(); }

private:
  void add(std::string_view key, double number)
  {
    hash_.add(key);
    hash_.add(number);
  }

  Fnv1a hash_;
};

// Looks at weights alone.
class FitCheck : public SettingList
{
public:
  explicit FitCheck(int num_joints) : num_joints_(num_joints) {}

  void boolean(std::string_view, bool&, std::string_view) override {}
  void number(std::string_view, double&, const Range&, std::string_view) override {}
  void number_or(std::string_view, std::optional<double>&, std::string_view, const Range&, std::string_view) override {}
  void three(std::string_view, Eigen::Vector3d&, std::string_view, std::string_view) override {}
  void word(std::string_view, int&, std::span<const std::string_view>, std::string_view) override {}
  void table(std::string_view name) override { table_ = name; }
  void weights(std::string_view key, JointWeights& value) override
  {
    if (value.size() > 0 && value.rows() != num_joints_ && !complaint_)
      complaint_ =
          fmt::format("{}: {}: found {} of them; this robot has {} motors", table_, key, value.rows(), num_joints_);
  }

  const std::optional<std::string>& complaint() const { return complaint_; }

private:
  int num_joints_;
  std::string table_;
  std::optional<std::string> complaint_;
};

} // namespace

void list(AnswerSettings& settings, SettingList& with)
{
  std::vector<std::string_view> names;
  for (const Method each : all_methods())
    names.push_back(name_of(each));
  const std::span<const std::string_view> all(kOnExcess), flag_or_refuse = all.first(2);
  int method = static_cast<int>(settings.methods.method) - 1;
  with.word("method", method, names, "used when the desired state asks for none");
  settings.methods.method = static_cast<Method>(method + 1);
  with.word("consistency", settings.consistency, flag_or_refuse,
            "a motion that contradicts its contacts: flag or refuse");
  with.number("contact_speed_tolerance", settings.contact_speed_tolerance, not_negative(), "m/s, rad/s");
  with.number("contact_tolerance", settings.contact_tolerance, not_negative(), "m/s^2, rad/s^2");
  with.number("sole_tilt_tolerance", settings.sole_tilt_tolerance, not_negative(), "rad");
  with.number("contact_height_tolerance", settings.contact_height_tolerance, not_negative(),
              "m above or below the ground z = 0");
  with.number("residual_tolerance", settings.residual_tolerance, not_negative(),
              "under-actuated motion: share of the weight, or of weight x leg length");
  with.word("limits", settings.limits, all, "torque limits: flag, refuse or clamp");
  with.word("rate_limits", settings.rate_limits, all, "torque-rate limits: flag, refuse or clamp");
  with.boolean("project", settings.project, "answer the nearest motion that keeps its contacts");
  with.word("infeasible", settings.methods.infeasible, kInfeasible,
            "conditions that cannot be met: relax or refuse (constrained), or nearest: answer the nearest motion");
  settings.methods.list(with);
  with.table("nearest");
  with.word("metric", settings.nearest.metric, kMetric,
            "of the accelerations: mass (Gauss's least constraint) or angles (of the links)");
  with.word("contacts", settings.nearest.contacts, kContacts,
            "loaded contacts rest, or accelerate as-desired (measured motion of soft feet)");
  with.number("contact_damping", settings.nearest.contact_damping, not_negative(),
              "1/s, of the speed of contacts that should rest");
  with.number("margin", settings.nearest.margin, not_negative(), "m, off both ends of every sole");
}

std::int64_t settings_id(AnswerSettings settings)
{
  Hash hash;
  list(settings, hash);
  return hash.id();
}

std::optional<std::string> complaint(AnswerSettings settings, const Robot& robot)
{
  FitCheck check(robot.num_joints());
  list(settings, check);
  if (check.complaint())
    return check.complaint();
  if (settings.methods.infeasible == OnInfeasible::nearest)
  {
    const std::optional<double>& least = settings.methods.of<Constrained>().f_min;
    double sum = 0.0;
    for (const Foot& foot : robot.feet)
      sum += foot.exists() && !robot.is_root(foot) ? least.value_or(foot.f_min) : 0.0;
    if (sum >= robot.weight())
      return fmt::format(
          "f_min: the feet of {} shall carry {:.4g} N at least, expected less than its weight, {:.4g} N: "
          "the nearest motion would have to accelerate upwards",
          robot.name, sum, robot.weight());
  }
  for (const Foot& foot : robot.feet)
    if (const double half = 0.5 * (foot.toe_x() - foot.heel_x());
        foot.exists() && foot.has_extent() && settings.nearest.margin >= half)
      return fmt::format("nearest: margin: found {} m; off both ends it leaves nothing of the {} sole of {}, expected "
                         "less than {:.4g} m",
                         settings.nearest.margin, name_of(foot.side), robot.name, half);
  return {};
}

} // namespace torqued
