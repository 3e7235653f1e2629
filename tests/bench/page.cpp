#include "bench/page.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace torqued::bench
{

namespace
{

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>torqued: bench</title>
<style>
:root { color-scheme: light dark; --page: #fdfdfb; --text: #1b1f24; --quiet: #57606a; --grid: #e3e5e8; --missed: #b42318; }
@media (prefers-color-scheme: dark) {
  :root { --page: #0e1116; --text: #e8ebef; --quiet: #a0a9b5; --grid: #2a3038; --missed: #ff8a80; }
}
body {
  margin: 0 auto; padding: 1.5rem clamp(1rem, 3vw, 2.5rem) 3rem; max-width: 68rem;
  background: var(--page); color: var(--text); font-variant-numeric: tabular-nums;
  font: 15px/1.5 system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', 'Liberation Sans', sans-serif;
}
h1 { font-size: 1.35rem; font-weight: 600; margin: 0 0 0.5rem; }
h2 { font-size: 1.05rem; font-weight: 600; margin: 2.2rem 0 0.4rem; }
p { margin: 0 0 0.4rem; max-width: 46rem; }
table { width: 100%; table-layout: fixed; border-collapse: collapse; }
th, td { padding: 0; vertical-align: top; text-align: left; font-weight: 400; overflow-wrap: break-word; }
th { width: 14rem; white-space: pre-wrap; }
.median { width: 8.5rem; text-align: right; }
.median span, .scale td, .promise { color: var(--quiet); line-height: 1.5rem; }
.median span, .scale td { font-size: 0.85rem; }
.median span { display: inline-block; width: 4rem; text-align: left; padding-left: 0.4em; }
.chart { position: relative; height: 1.5rem; }
.promise { width: 20rem; padding-left: 1.5rem; font-size: 0.8rem; }
.missed { color: var(--missed); font-weight: 700; }
.scale td { padding-bottom: 0.4rem; }
svg { position: absolute; left: 1.2rem; width: calc(100% - 1.2rem); height: 100%; overflow: visible; }
.tick { stroke: var(--grid); }
.whisker { stroke: var(--quiet); stroke-width: 2; }
circle { fill: var(--text); }
text { fill: var(--quiet); font-size: 0.75rem; text-anchor: middle; }
@media (max-width: 60rem) {
  tr { display: grid; grid-template-columns: 1fr auto; padding: 0.2rem 0; border-bottom: 1px solid var(--grid); }
  .scale { border: 0; }
  th, .median, .promise { width: auto; }
  .chart, .promise { grid-column: 1 / -1; padding-left: 0; }
  .scale .median { grid-column: 1 / -1; order: 1; }
  svg { left: 0.5rem; width: calc(100% - 1.5rem); }
}
</style>
<h1>What torqued costs</h1>
)";

std::string escaped(const std::string& text)
{
  std::string result;
  for (const char c : text)
    result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return result;
}

struct Scale
{
  double begin, end;
  bool logarithmic;
  std::vector<double> ticks;

  // where on it a value is, in percent; what is infinite is at the end
  double at(double value) const
  {
    const double share =
        logarithmic ? std::log(value / begin) / std::log(end / begin) : (value - begin) / (end - begin);
    return std::isfinite(share) ? 100.0 * share : 100.0;
  }
};

Scale scale_of(const std::vector<Row>& rows)
{
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const Row& row : rows)
    for (const double value : row.rounds)
      if (std::isfinite(value)) // what was divided by nothing has no place
      {
        least = std::min(least, value);
        most = std::max(most, value);
      }

  // on a scale from 0, what is far below the most would all be in one place
  if (least > 0.0 && most > 20.0 * least)
  {
    Scale scale{least, most, true, {}};
    for (double power = std::pow(10.0, std::floor(std::log10(least))); power <= most; power *= 10.0)
      for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= least && factor * power <= most && (factor == 1.0 || most < 100.0 * least))
          scale.ticks.push_back(factor * power);
    return scale;
  }
  Scale scale{std::min(least, 0.0), most, false, {}};
  if (scale.begin == scale.end)
    scale.end = 1.0;
  // the finest of 1, 2, 5 and 10 times a power of ten that needs no more than five steps
  const double range = scale.end - scale.begin;
  double step = std::pow(10.0, std::floor(std::log10(range / 5.0)));
  for (const double factor : {2.0, 2.5, 2.0})
    if (range > 5.0 * step)
      step *= factor;
  for (int i = static_cast<int>(std::ceil(scale.begin / step)); i * step <= scale.end; ++i)
    scale.ticks.push_back(i * step);
  return scale;
}

std::string chart(const Row& row, const Scale& scale)
{
  const Spread spread = spread_of(row.rounds);
  std::string svg = fmt::format("<svg><title>{} – {}</title>", rounded(spread.least), rounded(spread.most));
  for (const double tick : scale.ticks)
    svg += fmt::format(R"(<line class="tick" x1="{0:.2f}%" x2="{0:.2f}%" y2="100%"/>)", scale.at(tick));
  return svg + fmt::format(R"(<line class="whisker" x1="{:.2f}%" x2="{:.2f}%" y1=".75rem" y2=".75rem"/>)"
                           R"(<circle cx="{:.2f}%" cy=".75rem" r="3.5"/></svg>)",
                           scale.at(spread.least), scale.at(spread.most), scale.at(spread.median));
}

std::string labels(const Scale& scale)
{
  std::string svg = "<svg>";
  for (const double tick : scale.ticks)
    svg += fmt::format(R"(<text x="{:.2f}%" y="1rem">{:.10g}</text>)", scale.at(tick), tick);
  return svg + "</svg>";
}

std::string verdicts(const Rounds& rounds, const Row& row)
{
  std::string html;
  for (const Promise& promise : rounds.promises())
    if (const auto found = rounds.found(promise); found && promise.group == row.group && promise.name == row.name)
      html += fmt::format(R"(<div class="{}">{}</div>)", Rounds::kept(promise, *found) ? "kept" : "missed",
                          escaped(words(promise, *found)));
  return html;
}

// rows of one unit, and below them their scale
std::string block(const Rounds& rounds, const std::vector<Row>& rows)
{
  const Scale scale = scale_of(rows);
  std::string html = "<tbody>\n";
  for (const Row& row : rows)
    html += fmt::format(R"(<tr><th scope="row">{}</th><td class="median">{}<span>{}</span></td>)"
                        R"(<td class="chart">{}</td><td class="promise">{}</td></tr>)"
                        "\n",
                        escaped(row.name), rounded(spread_of(row.rounds).median), escaped(row.unit), chart(row, scale),
                        verdicts(rounds, row));
  return html + fmt::format(R"(<tr class="scale"><td></td><td class="median">{}</td><td class="chart">{}</td></tr>)"
                            "\n</tbody>\n",
                            scale.logarithmic ? "logarithmic" : "", labels(scale));
}

} // namespace

std::string page(const Rounds& rounds)
{
  std::size_t number = 0, kept = 0, missed = 0;
  for (const Row& row : rounds.rows())
    number = std::max(number, row.rounds.size());
  for (const Promise& promise : rounds.promises())
    if (const auto found = rounds.found(promise))
      ++(Rounds::kept(promise, *found) ? kept : missed);

  std::string html = kHead;
  html += fmt::format("<p>Dots are medians over the rounds ({}, interleaved), lines go from the least to the most of "
                      "them; ratios are taken within a round; times of two machines or of two runs do not compare. "
                      "Scales contain 0, except where they are marked as logarithmic.</p>\n"
                      "<p><strong>Promises: {} kept, {} missed.</strong></p>\n",
                      number, kept, missed);
  for (const std::string& group : rounds.groups())
  {
    html += fmt::format("<section>\n<h2>{}</h2>\n<table>\n", escaped(group));
    std::vector<Row> left = rounds.rows();
    std::erase_if(left, [&](const Row& row) { return row.group != group; });
    while (!left.empty())
    {
      const auto same = [unit = left.front().unit](const Row& row)
      {
        return row.unit == unit;
      };
      const auto others = std::stable_partition(left.begin(), left.end(), same);
      html += block(rounds, {left.begin(), others});
      left.erase(left.begin(), others);
    }
    html += "</table>\n</section>\n";
  }
  return html + "</html>\n";
}

} // namespace torqued::bench
