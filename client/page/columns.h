/// Numbers along a motion as columns of a document, fewer where a motion has too many samples.
#pragma once

#include "page/report_page.h"

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace torqued
{

using Json = nlohmann::ordered_json;

/// Bytes as they lie in memory, little-endian, in base64, RFC 4648.
std::string base64(const void* data, std::size_t size);
template <typename Number> std::string base64(const std::vector<Number>& column)
{
  return base64(column.data(), column.size() * sizeof(Number));
}

/// A quantity along a motion: its column's name, and its value at a sample.
struct Series
{
  std::string name;
  std::function<double(std::size_t)> at;
  bool bits = false; ///< flags: of several samples, those of all
};

/// Which samples a page holds: every `stride`-th as a frame; of a motion that has too many, curves over `per_stretch`
/// samples each, else 0.
struct Thinning
{
  std::size_t samples, stride, per_stretch;
};
Thinning thinning_of(std::size_t samples, const Resolution& resolution);

/// By name: of each frame the value.
Json frame_columns(const std::vector<Series>& series, const Thinning& thinning);
/// The same as to["frames"] and, if there are stretches, to["curves"]: of each one the least and the largest value, in
/// the order in which they come; twice NaN where there is none.
void add_columns(Json& to, const std::vector<Series>& series, const Thinning& thinning);

} // namespace torqued
