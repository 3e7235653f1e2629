#include "page/columns.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace torqued
{

namespace
{

std::int32_t bits_of(const Series& series, std::size_t from, std::size_t to)
{
  std::int32_t bits = 0;
  for (std::size_t i = from; i < to; ++i)
    if (const double value = series.at(i); !std::isnan(value))
      bits |= static_cast<std::int32_t>(value);
  return bits;
}

std::vector<float> frames(const Series& series, const Thinning& thinning)
{
  std::vector<float> column;
  for (std::size_t i = 0; i < thinning.samples; i += thinning.stride)
  {
    const std::size_t end = std::min(i + thinning.stride, thinning.samples);
    column.push_back(static_cast<float>(series.bits ? bits_of(series, i, end) : series.at(i)));
  }
  return column;
}

std::vector<float> extremes(const Series& series, const Thinning& thinning)
{
  std::vector<float> column;
  for (std::size_t from = 0; from < thinning.samples; from += thinning.per_stretch)
  {
    double least = NAN, most = NAN;
    bool least_first = true;
    for (std::size_t i = from; i < std::min(from + thinning.per_stretch, thinning.samples); ++i)
    {
      const double value = series.at(i);
      if (std::isnan(value))
        continue;
      if (!(value >= least))
      {
        least = value;
        least_first = false;
      }
      if (!(value <= most))
      {
        most = value;
        least_first = true;
      }
    }
    column.push_back(static_cast<float>(least_first ? least : most));
    column.push_back(static_cast<float>(least_first ? most : least));
  }
  return column;
}

} // namespace

std::string base64(const void* data, std::size_t size)
{
  static_assert(std::endian::native == std::endian::little);
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3)
  {
    const std::size_t left = std::min<std::size_t>(3, size - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < left ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= left ? digits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

Thinning thinning_of(std::size_t samples, const Resolution& resolution)
{
  const std::size_t stride = (samples + resolution.frames - 1) / resolution.frames;
  return {samples, stride, stride > 1 ? (samples + resolution.stretches - 1) / resolution.stretches : 0};
}

Json frame_columns(const std::vector<Series>& series, const Thinning& thinning)
{
  Json columns = Json::object();
  for (const Series& one : series)
    columns[one.name] = base64(frames(one, thinning));
  return columns;
}

void add_columns(Json& to, const std::vector<Series>& series, const Thinning& thinning)
{
  to["frames"] = frame_columns(series, thinning);
  if (thinning.per_stretch == 0)
    return;
  to["curves"] = Json::object();
  for (const Series& one : series)
    if (!one.bits)
      to["curves"][one.name] = base64(extremes(one, thinning));
}

} // namespace torqued
