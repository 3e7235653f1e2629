#include "answer/config.h"

#include "robot/files/strict_toml.h"
#include "text/printable.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sstream>
#include <stdexcept>

namespace torqued
{

namespace
{

constexpr std::array<std::string_view, 7> kLogLevels{"trace", "debug", "info", "warn", "error", "critical", "off"};

std::string_view word(OnExcess what)
{
  return what == OnExcess::flag ? "flag" : what == OnExcess::refuse ? "refuse" : "clamp";
}

// as a TOML text, in whatever quotes it needs
std::string toml_text(std::string_view text)
{
  std::ostringstream toml;
  toml << toml::value<std::string>(text);
  return toml.str();
}

OnExcess read_on_excess(StrictTable& table, std::string_view key, OnExcess fallback, bool may_clamp)
{
  std::vector<std::string_view> words{"flag", "refuse"};
  if (may_clamp)
    words.push_back("clamp");
  return static_cast<OnExcess>(table.choice(key, words, static_cast<int>(fallback)));
}

// a time in s
double read_duration(StrictTable& table, std::string_view key, double longest, double fallback)
{
  const double value = table.number(key, fallback);
  if (!(value > 0.0 && value <= longest))
    table.fail(key, fmt::format("found {}; expected a positive number of seconds, up to {:g}", value, longest));
  return value;
}

// a name or an address, which no line end or control character is part of
std::string read_plain(StrictTable& table, std::string_view key, const std::string& fallback)
{
  const std::string value = table.text(key, fallback);
  if (std::any_of(value.begin(), value.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }))
    table.fail(key, fmt::format("found \"{}\"; expected a text without control characters", printable(value)));
  return value;
}

double read_share(StrictTable& table, std::string_view key, double fallback, double most)
{
  const double value = table.number(key, fallback);
  if (!(value >= 0.0 && value <= most))
    table.fail(key, fmt::format("found {}; expected 0 to {}", value, most));
  return value;
}

// W of a method: [] for the unit matrix
JointWeights read_weights(StrictTable& table)
{
  const Eigen::MatrixXd W = table.matrix("weights", kMaxJoints);
  const double size = W.size() > 0 ? W.cwiseAbs().maxCoeff() : 0.0;
  for (Eigen::Index i = 0; i < W.rows(); ++i)
    for (Eigen::Index k = 0; k < i; ++k)
      if (std::abs(W(i, k) - W(k, i)) > 1e-12 * size)
        table.fail("weights", fmt::format("found {} in row {}, column {} and {} in row {}, column {}; expected a "
                                          "symmetric matrix",
                                          W(i, k), i + 1, k + 1, W(k, i), k + 1, i + 1));
  if (W.size() > 0 && W.llt().info() != Eigen::Success)
    table.fail("weights", "found a matrix that is not positive definite; expected one that is, such as positive "
                          "numbers for its diagonal");
  return 0.5 * (W + W.transpose());
}

std::string shown(const JointWeights& W)
{
  const auto row = [&W](Eigen::Index i)
  {
    return fmt::format("[{}]", fmt::join(W.row(i), ", "));
  };
  std::vector<std::string> entries;
  const bool diagonal = W.isDiagonal(0.0);
  for (Eigen::Index i = 0; i < W.rows(); ++i)
    entries.push_back(diagonal ? fmt::format("{}", W(i, i)) : row(i));
  return fmt::format("[{}]", fmt::join(entries, ", "));
}

void read_methods(StrictTable& table, MethodSettings& methods)
{
  methods.relax = table.choice("infeasible", {"relax", "refuse"}, methods.relax ? 0 : 1) == 0;
  if (auto settings = table.table("pseudo_inverse"))
  {
    methods.pseudo_inverse.weights = read_weights(*settings);
    const Eigen::MatrixXd V = settings->matrix("reaction_weights", 3);
    if (V.size() > 0)
    {
      if (V.rows() != 3 || !V.isDiagonal(0.0) || !(V.diagonal().minCoeff() > 0.0))
        settings->fail("reaction_weights", "expected three positive numbers: of f_x, of f_z and of the moment");
      methods.pseudo_inverse.reaction_weights = V.diagonal();
    }
    settings->finish();
  }
  if (auto settings = table.table("linear_transition"))
  {
    auto& leading_cop = methods.linear_transition.leading_cop;
    if (settings->is_number("cop"))
    {
      leading_cop = settings->number("cop");
      if (*leading_cop < 0.0 || *leading_cop > 1.0)
        settings->fail("cop", fmt::format("found {}; expected \"zmp\", or 0 (heel) to 1 (toe)", *leading_cop));
    }
    else if (settings->text("cop", "zmp") != "zmp")
    {
      settings->fail("cop", "expected \"zmp\", or 0 (heel) to 1 (toe)");
    }
    settings->finish();
  }
  if (auto settings = table.table("internal_wrench"))
  {
    methods.internal_wrench.sigma = read_share(*settings, "sigma", methods.internal_wrench.sigma, 1.0);
    methods.internal_wrench.weights = read_weights(*settings);
    settings->finish();
  }
  if (auto settings = table.table("torso_wrench"))
  {
    methods.torso_wrench.weights = read_weights(*settings);
    settings->finish();
  }
  if (auto settings = table.table("constrained"))
  {
    Constrained& constrained = methods.constrained;
    constrained.weights = read_weights(*settings);
    constrained.windows = settings->boolean("windows", constrained.windows);
    constrained.reference_weight = settings->magnitude("reference_weight", constrained.reference_weight);
    if (settings->is_number("f_min"))
      constrained.f_min = settings->magnitude("f_min");
    else if (settings->text("f_min", "robot") != "robot")
      settings->fail("f_min", "expected \"robot\", or a force in N");
    settings->finish();
  }
  if (auto settings = table.table("human_transition"))
  {
    HumanTransition& human = methods.human_transition;
    human.trailing_cop = read_share(*settings, "trailing_cop", human.trailing_cop, 1.0);
    human.leading_cop = read_share(*settings, "leading_cop", human.leading_cop, 1.0);
    human.time_weight = read_share(*settings, "time_weight", human.time_weight, 1.0);
    human.fade = read_share(*settings, "fade", human.fade, 0.5);
    settings->finish();
  }
}

// a setting that flags can set too: the same check, with the file's line in front
template <typename Set> void read_word(StrictTable& table, std::string_view key, Config& config, Set set)
{
  if (!table.has(key))
    return;
  const std::string value = table.text(key);
  try
  {
    set(config, value);
  }
  catch (const std::invalid_argument& error)
  {
    table.fail(key, error.what());
  }
}

} // namespace

void set_method(Config& config, const std::string& name)
{
  std::vector<std::string_view> names;
  for (const NamedMethod& known : kMethods)
  {
    names.push_back(known.name);
    if (known.name == name)
    {
      config.answers.methods.method = known.method;
      return;
    }
  }
  throw std::invalid_argument(
      fmt::format("found \"{}\"; expected one of: {}", printable(name), fmt::join(names, ", ")));
}

void set_prefix(Config& config, const std::string& prefix)
{
  // LCM reads channel names as regular expressions; these characters stand for themselves
  const auto plain = [](char c)
  {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '/';
  };
  constexpr std::size_t longest = 32;
  if (prefix.size() > longest || !std::all_of(prefix.begin(), prefix.end(), plain))
    throw std::invalid_argument(
        fmt::format("found \"{}\"; expected at most {} letters, digits, _, - or /", printable(prefix), longest));
  config.prefix = prefix;
}

void set_log_level(Config& config, const std::string& level)
{
  if (std::find(kLogLevels.begin(), kLogLevels.end(), level) == kLogLevels.end())
    throw std::invalid_argument(
        fmt::format("found \"{}\"; expected one of: {}", printable(level), fmt::join(kLogLevels, ", ")));
  config.log_level = level;
}

Config read_config(const std::string& path)
{
  return read_config(read_text_file(path), path);
}

Config read_config(std::string_view text, const std::string& file)
{
  const toml::table document = parse_toml(text, file);
  StrictTable table(document, file);
  Config config;
  config.robot = read_plain(table, "robot", config.robot);
  config.lcm_url = read_plain(table, "lcm_url", config.lcm_url);
  config.lcm_url_set_by = "lcm_url in " + file;
  read_word(table, "prefix", config, set_prefix);
  config.every_sample = table.boolean("every_sample", config.every_sample);
  config.max_age = read_duration(table, "max_age", 1.0, config.max_age);
  config.deadline = read_duration(table, "deadline", 3600.0, config.deadline);
  read_word(table, "log_level", config, set_log_level);

  AnswerSettings& answers = config.answers;
  read_word(table, "method", config, set_method);
  answers.consistency = read_on_excess(table, "consistency", answers.consistency, false);
  answers.contact_speed_tolerance = table.magnitude("contact_speed_tolerance", answers.contact_speed_tolerance);
  answers.contact_tolerance = table.magnitude("contact_tolerance", answers.contact_tolerance);
  answers.sole_tilt_tolerance = table.magnitude("sole_tilt_tolerance", answers.sole_tilt_tolerance);
  answers.contact_height_tolerance = table.magnitude("contact_height_tolerance", answers.contact_height_tolerance);
  answers.residual_tolerance = table.magnitude("residual_tolerance", answers.residual_tolerance);
  answers.limits = read_on_excess(table, "limits", answers.limits, true);
  answers.rate_limits = read_on_excess(table, "rate_limits", answers.rate_limits, true);

  answers.project = table.boolean("project", answers.project);
  read_methods(table, answers.methods);
  table.finish();
  return config;
}

void check_fits(const Config& config, const Robot& robot)
{
  if (const auto wrong = complaint(config.answers.methods, robot.num_joints()))
    throw FileError("the configuration does not fit " + robot.name + ": " + *wrong);
}

std::string to_toml(const Config& config)
{
  const AnswerSettings& answers = config.answers;
  const MethodSettings& methods = answers.methods;
  const auto cop = methods.linear_transition.leading_cop;
  const auto f_min = methods.constrained.f_min;
  return fmt::format(
      R"(# configuration of torqued

robot = {}  # a robot that ships, or a .toml or .urdf file; '': --robot must say it
lcm_url = {}  # '': LCM_DEFAULT_URL, or LCM's own default
prefix = {}  # stands before each channel's name
log_level = {}
every_sample = {}  # answer all samples in order instead of the newest
max_age = {}  # s; five times this long without an accepted sample, and another stream may begin
deadline = {}  # s, arrival to publish

method = {}
consistency = {}  # a motion that contradicts its contacts: flag or refuse
contact_speed_tolerance = {}  # m/s, rad/s
contact_tolerance = {}  # m/s^2, rad/s^2
sole_tilt_tolerance = {}  # rad
contact_height_tolerance = {}  # m above or below the ground z = 0
residual_tolerance = {}  # under-actuated motion: share of the weight, or of weight x leg length
limits = {}  # torque limits: flag, refuse or clamp
rate_limits = {}  # torque-rate limits: flag, refuse or clamp
project = {}  # answer the nearest motion that keeps its contacts
infeasible = {}  # constrained: conditions that cannot be met: relax or refuse

# weights: of each motor's torque, or a symmetric positive definite matrix; []: all 1

[pseudo_inverse]
weights = {}
reaction_weights = {}  # of f_x, f_z and moment

[linear_transition]
cop = {}  # both feet on their soles: 'zmp', or the leading foot's pressure point from 0 (heel) to 1 (toe)

[internal_wrench]
sigma = {}  # 0 to 1; changes the internal wrench, not the torques
weights = {}

[torso_wrench]
weights = {}

[constrained]
weights = {}
windows = {}  # bounds that close where contacts change, so that torques do not jump
reference_weight = {}  # of the distance to zmp-transition's reactions, x leg length, beside that of the torques
f_min = {}  # least normal force of a loaded foot, N; 'robot': as its file says

[human_transition]
trailing_cop = {}  # where the trailing sole presses, 0 (heel) to 1 (toe)
leading_cop = {}  # and the leading one
time_weight = {}  # 0 to 1: weight of load_transfer, against the lever rule, in the vertical share
fade = {}  # 0 to 0.5: share of the double support in which each end passes into single support; 0: at once
)",
      toml_text(config.robot), toml_text(config.lcm_url), toml_text(config.prefix), toml_text(config.log_level),
      config.every_sample, config.max_age, config.deadline, toml_text(name_of(answers.methods.method)),
      toml_text(word(answers.consistency)), answers.contact_speed_tolerance, answers.contact_tolerance,
      answers.sole_tilt_tolerance, answers.contact_height_tolerance, answers.residual_tolerance,
      toml_text(word(answers.limits)), toml_text(word(answers.rate_limits)), answers.project,
      toml_text(methods.relax ? "relax" : "refuse"), shown(methods.pseudo_inverse.weights),
      fmt::format("[{}]", fmt::join(methods.pseudo_inverse.reaction_weights, ", ")),
      cop ? fmt::format("{}", *cop) : toml_text("zmp"), methods.internal_wrench.sigma,
      shown(methods.internal_wrench.weights), shown(methods.torso_wrench.weights), shown(methods.constrained.weights),
      methods.constrained.windows, methods.constrained.reference_weight,
      f_min ? fmt::format("{}", *f_min) : toml_text("robot"), methods.human_transition.trailing_cop,
      methods.human_transition.leading_cop, methods.human_transition.time_weight, methods.human_transition.fade);
}

} // namespace torqued
