/// Rounds as a page for any browser.
#pragma once

#include "bench/rounds.h"

namespace torqued::bench
{

/// One HTML text that needs nothing else: every row's median, with a line from the least to the most of its rounds, and
/// what became of its promises. Rows of a group that have the same unit are on one scale.
std::string page(const Rounds& rounds);

} // namespace torqued::bench
