/// The methods' names and settings, for those who only name or set them; method.h has what they do.
#pragma once

#include "methods/setting_list.h"
#include "stance/desired_state.h"

#include <any>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// All methods, in the order of their numbers, from 1 on.
std::vector<Method> all_methods();
/// A method's name; "none" for Method::none and for any number that is no method.
std::string_view name_of(Method method);
/// The method of a name; none if there is no such method.
Method method_named(std::string_view name);
/// The names, as a list in words.
std::string method_names();
/// Names and numbers as messages have them: "DEFAULT (0), PSEUDO_INVERSE (1), …".
extern const std::string kMethodNumbers;

/// What becomes of a motion whose conditions of contacts and motors cannot all be met.
enum class OnInfeasible
{
  relax,  ///< constrained violates them as little as can be
  refuse, ///< constrained refuses the desired state
  nearest ///< the nearest motion that can be had is answered, by every method (nearest/nearest_motion.h)
};

/// The settings of all methods, each method's a struct of its own, Settings. Settings::kMethod: whose they are.
class MethodSettings
{
public:
  /// The methods' own defaults.
  MethodSettings();

  Method method = Method::constrained; ///< used when the desired state asks for none
  OnInfeasible infeasible = OnInfeasible::relax;

  template <typename Settings> Settings& of() { return *std::any_cast<Settings>(&of_method(Settings::kMethod)); }
  template <typename Settings> const Settings& of() const { return const_cast<MethodSettings&>(*this).of<Settings>(); }

  /// Those of each method that has any, in a table of the method's name, with _ for -.
  void list(SettingList& settings);

private:
  std::any& of_method(Method number) { return all_[static_cast<std::size_t>(number)]; }

  std::vector<std::any> all_; // by the methods' numbers
};

} // namespace torqued
