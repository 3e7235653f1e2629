/// Words that are others but for a slip of the pen.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

namespace torqued
{

/// Letters that are missing, too many, wrong or swapped with the next one
inline std::size_t slips(std::string_view a, std::string_view b)
{
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j)
    {
      if (i == 0 || j == 0)
      {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] =
          std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? std::size_t{0} : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

/// Whether a name is a word with a slip or, of a word of six letters or more, two.
inline bool resembles(std::string_view name, std::string_view word)
{
  const std::size_t most = word.size() >= 6 ? 2 : 1;
  return name.size() <= word.size() + most && slips(name, word) <= most;
}

} // namespace torqued
