/// The methods: rules that choose the ground reactions of double support. Each is a file of this folder, which says
/// what the rule is, what can be set, and its number and name.
#pragma once

#include "methods/setting_list.h"
#include "stance/reactions.h"
#include "stance/refusal.h"

#include <any>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace torqued
{

/// The settings of all methods, each method's a struct of its own, Settings. Settings::kMethod: whose they are.
class MethodSettings
{
public:
  /// The methods' own defaults.
  MethodSettings();

  Method method = Method::constrained; ///< used when the desired state asks for none
  bool relax = true; ///< constrained: conditions that cannot be met are violated as little as can be; else refused

  template <typename Settings> Settings& of() { return *std::any_cast<Settings>(&of_method(Settings::kMethod)); }
  template <typename Settings> const Settings& of() const { return const_cast<MethodSettings&>(*this).of<Settings>(); }

  /// Those of each method that has any, in a table of the method's name, with _ for -.
  void list(SettingList& settings);

private:
  std::any& of_method(Method number) { return all_[static_cast<std::size_t>(number)]; }

  std::vector<std::any> all_; // by the methods' numbers
};

/// One double support, and all that a rule chooses from.
struct DoubleSupport
{
  const Robot& robot;
  const SupportEquations& equations;
  const Support& support;
  const AdmissibleReactions& all;
  const MethodSettings& settings;
};

/// A method, as its file describes it.
struct MethodRow
{
  Method method;         ///< its number in desired_state_t
  std::string_view name; ///< in configurations, on command lines and in tables
  Result<Reactions> (*choose)(const DoubleSupport&);
  std::any (*settings)() = nullptr; ///< the defaults of what can be set; null: nothing can
  void (*list)(std::any&, SettingList&) = nullptr;
};

/// A method with settings. list(Settings&, SettingList&) lists them.
template <typename Settings>
MethodRow method_row(std::string_view name, Result<Reactions> (*choose)(const DoubleSupport&))
{
  return {Settings::kMethod, name, choose, [] { return std::any(Settings()); },
          [](std::any& settings, SettingList& with)
          {
            list(*std::any_cast<Settings>(&settings), with);
          }};
}

/// All methods, in the order of their numbers, from 1 on.
const std::vector<MethodRow>& methods();
/// Rows in that order. Throws std::logic_error if they are not numbered from 1 on, each once.
std::vector<MethodRow> by_number(std::vector<MethodRow> rows);

/// A method's name; "none" for Method::none and for any number that is no method.
std::string_view name_of(Method method);
/// The method of a name; none if there is no such method.
Method method_named(std::string_view name);
/// The names, as a list in words.
std::string method_names();
/// Names and numbers as messages have them: "DEFAULT (0), PSEUDO_INVERSE (1), …".
extern const std::string kMethodNumbers;

} // namespace torqued
