/// XML read strictly: every attribute and element is asked for or skipped by name, every value is checked, and every
/// complaint says file, line and key. Complaints are FileError (text_file.h).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tinyxml2.h>
#include <vector>

namespace torqued
{

/// Parses XML. file: the name used in complaints. Throws FileError.
///
/// Refuses, before the parser sees it, what no file of ours needs: NUL bytes, <!DOCTYPE …> and any other <!…> that is
/// not a comment, characters given as numbers, attributes on a closing tag, and more tags, or attributes on one tag,
/// than a robot has. The parser's own limit keeps elements from nesting deeper than it can go. Entities are those of
/// XML itself: none can be declared.
void parse_xml(std::string_view text, const std::string& file, tinyxml2::XMLDocument& document);

/// One element of an XML file that is being read. Ask for each attribute and child, or skip it, then call finish(),
/// which refuses all others.
///
/// Every function throws FileError if the value is missing (where no fallback is given) or not exactly what was asked
/// for. A number is a decimal one, with or without a sign, and finite; a list of numbers is separated by white space
/// and has nothing else in it. The document and the file name must outlive the reader.
class StrictElement
{
public:
  /// context: how complaints name this element, e.g. "joint 'left_knee'"; empty for the root element.
  StrictElement(const tinyxml2::XMLElement& element, const std::string& file, std::string context = {});

  std::string text(std::string_view key, std::optional<std::string> fallback = {});
  double number(std::string_view key, std::optional<double> fallback = {});
  /// A number that must not be negative.
  double magnitude(std::string_view key);
  /// "x y z"
  Eigen::Vector3d vector(std::string_view key, std::optional<Eigen::Vector3d> fallback = {});

  /// A child element that may be there once.
  std::optional<StrictElement> child(std::string_view name);
  /// All child elements of this name. Their context is this name and their number from 1.
  std::vector<StrictElement> children(std::string_view name);
  /// Attributes and elements that may be there and are not read, nor what is in them.
  void skip(const std::vector<std::string_view>& names);

  void set_context(std::string context) { context_ = std::move(context); }
  int line() const { return element_->GetLineNum(); }
  /// Complains about an attribute of this element, or with an empty key about the element.
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;
  /// Refuses an element that holds text, or an attribute or element that nobody asked for and of which `harmless` does
  /// not say that it may be there.
  void finish(const std::function<bool(const tinyxml2::XMLAttribute&)>& harmless_attribute = {},
              const std::function<bool(const tinyxml2::XMLElement&)>& harmless_element = {}) const;
  /// The element itself, for what is looked at and not checked.
  const tinyxml2::XMLElement& xml() const { return *element_; }

private:
  const tinyxml2::XMLAttribute* find(std::string_view key);
  [[noreturn]] void fail_at(int line, std::string_view key, const std::string& message) const;
  void read_numbers(std::string_view key, double* values, std::size_t count, bool optional);

  const tinyxml2::XMLElement* element_;
  const std::string* file_;
  std::string context_;
  std::vector<std::string> attributes_, elements_, skipped_;
};

} // namespace torqued
