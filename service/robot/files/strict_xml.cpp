#include "robot/files/strict_xml.h"

#include "robot/files/text_file.h"
#include "text/number.h"
#include "text/printable.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sstream>

namespace torqued
{

namespace
{

// Walks over the tags as the parser will, and refuses what it must not see: it keeps every tag in memory, and compares
// each attribute of a tag with all before it.
class Doorkeeper
{
public:
  Doorkeeper(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  void inspect()
  {
    if (const std::size_t nul = text_.find('\0'); nul != std::string_view::npos)
      fail(nul, "found a NUL byte; expected XML, encoded as UTF-8");
    int tags = 0;
    while ((at_ = text_.find('<', at_)) != std::string_view::npos)
    {
      constexpr int most_tags = 20'000;
      if (++tags > most_tags)
        fail(at_, fmt::format("more than {} tags; no robot needs that", most_tags));
      if (starts("<!--"))
        skip_from(4, "-->");
      else if (starts("<![CDATA["))
        skip_from(9, "]]>");
      else if (starts("<?"))
        skip_from(2, "?>");
      else if (starts("<!"))
        fail(at_, "found <!; a file with a DOCTYPE or entities of its own is not read, only elements and comments");
      else
        inspect_tag();
    }
  }

private:
  void inspect_tag()
  {
    const std::size_t begin = at_;
    int attributes = 0;
    for (++at_; at_ < text_.size() && text_[at_] != '>'; ++at_)
    {
      if (text_[at_] != '"' && text_[at_] != '\'')
        continue;
      constexpr int most_attributes = 100;
      if (++attributes > most_attributes)
        fail(begin, fmt::format("a tag with more than {} attributes; no robot needs that", most_attributes));
      if (text_.substr(begin, 2) == "</")
        fail(begin, "a closing tag with an attribute; attributes belong to the opening tag");
      const std::size_t value = at_ + 1;
      at_ = std::min(text_.size() - 1, text_.find(text_[at_], value));
      // the parser ends a text at a character 0, whatever comes behind it
      if (text_.substr(value, at_ - value).find("&#") != std::string_view::npos)
        fail(begin, "a character as a number, &#...; expected the character itself");
    }
  }

  bool starts(std::string_view what) const { return text_.substr(at_, what.size()) == what; }
  void skip_from(std::size_t length, std::string_view end)
  {
    at_ = std::min(text_.size(), text_.find(end, at_ + length));
  }

  [[noreturn]] void fail(std::size_t at, std::string_view message) const
  {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    throw FileError(fmt::format("{}:{}: {}", file_, line, message));
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
};

std::string_view meaning(tinyxml2::XMLError error)
{
  switch (error)
  {
  case tinyxml2::XML_ERROR_PARSING_ELEMENT: return "an element is not well formed";
  case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE: return "an attribute is not well formed, or there twice";
  case tinyxml2::XML_ERROR_PARSING_TEXT: return "found text where an element <robot> is expected";
  case tinyxml2::XML_ERROR_PARSING_CDATA: return "a CDATA section does not end";
  case tinyxml2::XML_ERROR_PARSING_COMMENT: return "a comment does not end";
  case tinyxml2::XML_ERROR_PARSING_DECLARATION: return "<?...?> does not end, or does not stand at the beginning";
  case tinyxml2::XML_ERROR_EMPTY_DOCUMENT: return "there is nothing in it";
  case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT: return "an element is not closed, or another one is";
  case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED: return "elements are nested deeper than any robot needs";
  default: return "an element is not closed before the end of the file";
  }
}

} // namespace

void parse_xml(std::string_view text, const std::string& file, tinyxml2::XMLDocument& document)
{
  Doorkeeper(text, file).inspect();
  if (const tinyxml2::XMLError error = document.Parse(text.data(), text.size()); error != tinyxml2::XML_SUCCESS)
    throw FileError(fmt::format("{}:{}: not XML: {}", file, std::max(1, document.ErrorLineNum()), meaning(error)));
}

StrictElement::StrictElement(const tinyxml2::XMLElement& element, const std::string& file, std::string context)
    : element_(&element), file_(&file), context_(std::move(context))
{
}

void StrictElement::fail_at(int line, std::string_view key, const std::string& message) const
{
  std::string where = context_;
  if (!key.empty())
    where += (where.empty() ? "" : ": ") + printable(std::string(key), kLongestShown);
  throw FileError(fmt::format("{}:{}: {}{}{}", *file_, line, where, where.empty() ? "" : ": ", message));
}

void StrictElement::fail(std::string_view key, const std::string& message) const
{
  const tinyxml2::XMLAttribute* attribute = element_->FindAttribute(std::string(key).c_str());
  fail_at(attribute ? attribute->GetLineNum() : line(), key, message);
}

const tinyxml2::XMLAttribute* StrictElement::find(std::string_view key)
{
  attributes_.emplace_back(key);
  return element_->FindAttribute(attributes_.back().c_str());
}

void StrictElement::read_numbers(std::string_view key, double* values, std::size_t count, bool optional)
{
  const tinyxml2::XMLAttribute* attribute = find(key);
  if (!attribute && optional)
    return;
  const std::string expected = count == 1 ? "a number" : fmt::format("{} numbers, separated by spaces", count);
  if (!attribute)
    fail(key, "is missing; expected " + expected);
  std::istringstream words(attribute->Value());
  std::size_t read = 0;
  bool good = true;
  for (std::string word; good && words >> word; ++read)
  {
    const double number = number_in<double>(word).value_or(NAN);
    good = read < count && std::isfinite(number);
    if (good)
      values[read] = number;
  }
  if (!good || read < count)
    fail(key, fmt::format("found \"{}\"; expected {}", printable(attribute->Value(), kLongestShown), expected));
}

std::string StrictElement::text(std::string_view key, std::optional<std::string> fallback)
{
  const tinyxml2::XMLAttribute* attribute = find(key);
  if (!attribute && !fallback)
    fail(key, "is missing");
  return attribute ? attribute->Value() : *fallback;
}

double StrictElement::number(std::string_view key, std::optional<double> fallback)
{
  double value = fallback.value_or(0.0);
  read_numbers(key, &value, 1, fallback.has_value());
  return value;
}

double StrictElement::magnitude(std::string_view key)
{
  const double value = number(key);
  if (value < 0.0)
    fail(key, fmt::format("found {}; expected a number that is not negative", value));
  return value;
}

Eigen::Vector3d StrictElement::vector(std::string_view key, std::optional<Eigen::Vector3d> fallback)
{
  Eigen::Vector3d value = fallback.value_or(Eigen::Vector3d::Zero());
  read_numbers(key, value.data(), 3, fallback.has_value());
  return value;
}

std::optional<StrictElement> StrictElement::child(std::string_view name)
{
  elements_.emplace_back(name);
  const tinyxml2::XMLElement* element = element_->FirstChildElement(elements_.back().c_str());
  if (!element)
    return {};
  const std::string context = fmt::format("{}{}{}", context_, context_.empty() ? "" : ": ", name);
  if (const tinyxml2::XMLElement* second = element->NextSiblingElement(elements_.back().c_str()))
    StrictElement(*second, *file_, context).fail({}, "is there twice; expected one");
  return StrictElement(*element, *file_, context);
}

std::vector<StrictElement> StrictElement::children(std::string_view name)
{
  std::vector<StrictElement> children;
  const std::string key(name);
  elements_.push_back(key);
  for (const auto* element = element_->FirstChildElement(key.c_str()); element;
       element = element->NextSiblingElement(key.c_str()))
    children.emplace_back(*element, *file_, fmt::format("{} {}", name, children.size() + 1));
  return children;
}

void StrictElement::skip(const std::vector<std::string_view>& names)
{
  skipped_.insert(skipped_.end(), names.begin(), names.end());
}

void StrictElement::finish(const std::function<bool(const tinyxml2::XMLAttribute&)>& harmless_attribute,
                           const std::function<bool(const tinyxml2::XMLElement&)>& harmless_element) const
{
  const auto holds = [](const std::vector<std::string>& names, std::string_view name)
  {
    return std::ranges::find(names, name) != names.end();
  };
  for (const auto* attribute = element_->FirstAttribute(); attribute; attribute = attribute->Next())
    if (!holds(attributes_, attribute->Name()) && !holds(skipped_, attribute->Name()) &&
        !(harmless_attribute && harmless_attribute(*attribute)))
      fail(attribute->Name(), attributes_.empty()
                                  ? std::string("is not known here; no attribute is")
                                  : fmt::format("is not known here; known are: {}", fmt::join(attributes_, ", ")));
  for (const auto* node = element_->FirstChild(); node; node = node->NextSibling())
  {
    if (node->ToComment())
      continue;
    const std::string shown = printable(node->Value() ? node->Value() : "", kLongestShown);
    if (!node->ToElement())
      fail_at(node->GetLineNum(), {}, fmt::format("found the text \"{}\"; expected elements only", shown));
    if (holds(elements_, node->Value()) || holds(skipped_, node->Value()))
      continue;
    if (shown.starts_with("xacro:"))
      fail_at(node->GetLineNum(), {},
              fmt::format("found <{}>; expected a URDF: run the file through xacro first", shown));
    if (harmless_element && harmless_element(*node->ToElement()))
      continue;
    fail_at(node->GetLineNum(), {},
            elements_.empty()
                ? fmt::format("<{}> is not known here; no element is", shown)
                : fmt::format("<{}> is not known here; known are: {}", shown, fmt::join(elements_, ", ")));
  }
}

} // namespace torqued
