#include "catch.h"

#include "bench/page.h"
#include "bench/rounds.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>

namespace rounds_test
{

using namespace torqued::bench;

namespace
{

Rounds three_rounds()
{
  Rounds rounds;
  // a machine that is ten times slower in one round: ratios 2, 3 and 1.5, medians 30 and 20
  for (const auto& [a, b] : {std::pair(20.0, 10.0), std::pair(300.0, 100.0), std::pair(30.0, 20.0)})
  {
    rounds.add("group", "a", "us", a);
    rounds.add("group", "b", "us", b);
  }
  return rounds;
}

void add(Rounds& rounds, const std::string& name, const std::string& unit, const std::vector<double>& values)
{
  for (const double value : values)
    rounds.add("group", name, unit, value);
}

// every match's groups, and before them all of it
std::vector<std::vector<std::string>> matches(const std::string& text, const std::string& pattern)
{
  const std::regex regex(pattern);
  std::vector<std::vector<std::string>> found;
  for (std::sregex_iterator match(text.begin(), text.end(), regex), end; match != end; ++match)
    found.emplace_back(match->begin(), match->end());
  return found;
}

// A row as the page shows it; where its marks are, in percent of the scale.
struct Shown
{
  std::string name, median, unit;
  double least, most, at;
  std::string promises;
};

std::vector<Shown> shown(const std::string& html)
{
  std::vector<Shown> rows;
  for (const auto& row : matches(html, "<tr><th scope=\"row\">(.*)</th><td class=\"median\">(.*)<span>(.*)</span></td>"
                                       ".*class=\"whisker\" x1=\"(.*)%\" x2=\"(.*)%\" y1.*<circle cx=\"(.*)%\".*"
                                       "<td class=\"promise\">(.*)</td></tr>"))
    rows.push_back({row[1], row[2], row[3], std::stod(row[4]), std::stod(row[5]), std::stod(row[6]), row[7]});
  return rows;
}

// where a scale says that a number is: its labels, in the page's order
std::vector<std::pair<double, double>> labels(const std::string& html)
{
  std::vector<std::pair<double, double>> found;
  for (const auto& label : matches(html, "<text x=\"([^\"]*)%\"[^>]*>([^<]*)</text>"))
    found.emplace_back(std::stod(label[2]), std::stod(label[1]));
  return found;
}

constexpr double kPercent = 0.011; // the page says two decimals

} // namespace

TEST_CASE("rows are reported by medians, and compared by the median of each round's ratio", "[rounds]")
{
  const Rounds rounds = three_rounds();
  REQUIRE(rounds.rows().size() == 2);
  CHECK(rounds.rows()[0].rounds == std::vector{20.0, 300.0, 30.0});
  CHECK(rounds.median("group", "a") == 30.0);
  CHECK(rounds.median("group", "b") == 20.0);
  CHECK(rounds.ratio("group", "a", "b") == 2.0);
  CHECK_THROWS_AS(rounds.median("group", "c"), std::out_of_range);
  CHECK_THROWS_AS(rounds.ratio("group", "a", "c"), std::out_of_range);
  CHECK_THROWS_AS(rounds.ratio("other", "a", "b"), std::out_of_range);

  Rounds even;
  for (const double value : {4.0, 1.0, 2.0, 8.0})
    even.add("group", "a", "us", value);
  CHECK(even.median("group", "a") == 3.0);
}

TEST_CASE("promises are kept or missed, up to their bound, in the table and in the JSON", "[rounds]")
{
  Rounds rounds = three_rounds();
  rounds.promise({"group", "a", "b", 2.0});
  rounds.promise({"group", "a", "b", 2.0});
  rounds.promise({"group", "a", "b", 1.9});
  rounds.promise({"group", "b", "", 20.0, true});
  rounds.promise({"group", "b", "", 20.5, true});
  rounds.promise({"group", "c", "", 1.0});
  REQUIRE(rounds.promises().size() == 5); // said again, it counts once
  CHECK(rounds.found(rounds.promises()[0]) == 2.0);
  CHECK(rounds.found(rounds.promises()[2]) == 20.0);
  CHECK_FALSE(rounds.found(rounds.promises()[4]));

  const std::string table = rounds.table();
  CAPTURE(table);
  CHECK(table.find("2.000 x b: at most 2, kept\n") != std::string::npos);
  CHECK(table.find("2.000 x b: at most 1.9, missed\n") != std::string::npos);
  CHECK(table.find("at least 20, kept\n") != std::string::npos);
  CHECK(table.find("at least 20.5, missed\n") != std::string::npos);

  const auto json = nlohmann::json::parse(rounds.json());
  CHECK(json["rows"][0]["rounds"] == std::vector{20.0, 300.0, 30.0});
  CHECK(json["rows"][0]["median"] == 30.0);
  CHECK(json["promises"][0]["found"] == 2.0);
  CHECK(json["promises"][0]["kept"] == true);
  CHECK(json["promises"][1]["kept"] == false);
  CHECK(json["promises"][3]["at_least"] == 20.5);
  CHECK(json["promises"][4]["found"].is_null());
}

TEST_CASE("bounds are said as people write them", "[rounds]")
{
  CHECK(words({"group", "a", "", 19'000.0, true}, 19'745.0) == "at least 19000, kept");
  CHECK(words({"group", "a", "b", 1.0 / 12.0}, 0.07) == "0.070 x b: at most 0.083333, kept");
}

TEST_CASE("the page shows every row once, in its group and with its median", "[rounds]")
{
  Rounds rounds = three_rounds();
  rounds.add("another", "a", "us", 7.0);
  rounds.add("group", "c", "MB", 5.0);
  rounds.add("group", "d", "us", 1.0);
  const std::string html = page(rounds);
  CAPTURE(html);
  const std::vector<Shown> rows = shown(html);
  std::vector<std::string> lines;
  for (const Shown& row : rows)
    lines.push_back(row.name + ": " + row.median + " " + row.unit);
  // those of one unit together, and they have one scale
  CHECK(lines == std::vector<std::string>{"a: 30.0 us", "b: 20.0 us", "d: 1.00 us", "c: 5.00 MB", "a: 7.00 us"});
  CHECK(matches(html, "<tr class=\"scale\">").size() == 3);
  REQUIRE(matches(html, "<h2>").size() == 2);
  CHECK(html.find("<h2>group</h2>") < html.find("30.0"));
  CHECK(html.find("5.00") < html.find("<h2>another</h2>"));
  CHECK(html.find("<h2>another</h2>") < html.find("7.00"));
  CHECK(html.find("(3, interleaved)") != std::string::npos);

  CHECK(shown(page(Rounds())).empty());
  for (const char* foreign : {"http", "src=", "href", "<script", "url(", "@import"})
    CHECK(html.find(foreign) == std::string::npos);
}

TEST_CASE("on the page a row's dot is at its median, its line from least to most, on a scale from 0", "[rounds]")
{
  Rounds rounds;
  add(rounds, "a", "us", {60.0, 20.0, 30.0});
  add(rounds, "b", "us", {10.0, 40.0, 15.0});
  add(rounds, "negative", "%", {-0.25, 0.75, 0.25});
  add(rounds, "zero", "MB", {0.0});
  add(rounds, "infinite", "1/s", {2.0, 4.0, std::numeric_limits<double>::infinity()});
  const std::string html = page(rounds);
  CAPTURE(html);
  CHECK(html.find(">logarithmic<") == std::string::npos);
  const std::vector<Shown> rows = shown(html);
  REQUIRE(rows.size() == 5);
  const auto is_at = [](const Shown& row, double least, double median, double most)
  {
    CAPTURE(row.name);
    CHECK_THAT(row.least, Catch::Matchers::WithinAbs(least, kPercent));
    CHECK_THAT(row.at, Catch::Matchers::WithinAbs(median, kPercent));
    CHECK_THAT(row.most, Catch::Matchers::WithinAbs(most, kPercent));
  };
  is_at(rows[0], 100.0 * 20.0 / 60.0, 50.0, 100.0);
  is_at(rows[1], 100.0 * 10.0 / 60.0, 25.0, 100.0 * 40.0 / 60.0);
  is_at(rows[2], 0.0, 50.0, 100.0);
  is_at(rows[3], 0.0, 0.0, 0.0);
  CHECK_THAT(rows[4].least, Catch::Matchers::WithinAbs(50.0, kPercent));
  CHECK_THAT(rows[4].at, Catch::Matchers::WithinAbs(100.0, kPercent));

  // what the labels say is what the marks mean
  std::size_t zeros = 0;
  for (const auto& [value, at] : labels(html))
    zeros += value == 0.0 ? 1 : 0;
  CHECK(zeros == 4);
  Rounds one;
  add(one, "a", "us", {60.0, 20.0, 30.0});
  REQUIRE(labels(page(one)).size() >= 3);
  for (const auto& [value, at] : labels(page(one)))
    CHECK_THAT(at, Catch::Matchers::WithinAbs(100.0 * value / 60.0, kPercent));
}

TEST_CASE("on the page values far apart are on a scale that is logarithmic and says so", "[rounds]")
{
  const double most = GENERATE(205.0, 900.0, 12'345.0, 3e6);
  CAPTURE(most);
  Rounds rounds;
  add(rounds, "a", "us", {10.0, 20.0, 40.0});
  add(rounds, "b", "us", {most});
  const std::string html = page(rounds);
  CHECK(html.find(">logarithmic<") != std::string::npos);
  const auto share = [most](double value)
  {
    return 100.0 * std::log(value / 10.0) / std::log(most / 10.0);
  };
  const std::vector<Shown> rows = shown(html);
  REQUIRE(rows.size() == 2);
  CHECK_THAT(rows[0].least, Catch::Matchers::WithinAbs(0.0, kPercent));
  CHECK_THAT(rows[0].at, Catch::Matchers::WithinAbs(share(20.0), kPercent));
  CHECK_THAT(rows[0].most, Catch::Matchers::WithinAbs(share(40.0), kPercent));
  CHECK_THAT(rows[1].at, Catch::Matchers::WithinAbs(100.0, kPercent));
  CHECK(labels(html).size() >= 3);
  CHECK(labels(html).size() <= 7);
  for (const auto& [value, at] : labels(html))
    CHECK_THAT(at, Catch::Matchers::WithinAbs(share(value), kPercent));
}

TEST_CASE("the page says of every promise whether it is kept, beside its row, and counts them", "[rounds]")
{
  Rounds rounds = three_rounds();
  rounds.promise({"group", "a", "b", 2.0});
  rounds.promise({"group", "a", "b", 1.9});
  rounds.promise({"group", "b", "", 20.0, true});
  rounds.promise({"group", "a", "", 31.0});
  rounds.promise({"group", "c", "", 1.0});
  rounds.add("other", "a", "us", 1.0);
  rounds.promise({"other", "a", "", 0.5});
  const std::string html = page(rounds);
  CAPTURE(html);
  const std::vector<Shown> rows = shown(html);
  REQUIRE(rows.size() == 3);
  CHECK(rows[0].promises == "<div class=\"kept\">2.000 x b: at most 2, kept</div>"
                            "<div class=\"missed\">2.000 x b: at most 1.9, missed</div>"
                            "<div class=\"kept\">at most 31, kept</div>");
  CHECK(rows[1].promises == "<div class=\"kept\">at least 20, kept</div>");
  CHECK(rows[2].promises == "<div class=\"missed\">at most 0.5, missed</div>");
  CHECK(html.find("Promises: 3 kept, 2 missed.") != std::string::npos);
}

TEST_CASE("the page shows names as they are, whatever they contain", "[rounds]")
{
  Rounds rounds;
  rounds.add("<i>", "a & <b>", "<u>", 1.0);
  rounds.promise({"<i>", "a & <b>", "a & <b>", 1.0});
  const std::string html = page(rounds);
  CAPTURE(html);
  CHECK(html.find("<h2>&lt;i&gt;</h2>") != std::string::npos);
  const std::vector<Shown> rows = shown(html);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].name == "a &amp; &lt;b&gt;");
  CHECK(rows[0].unit == "&lt;u&gt;");
  CHECK(rows[0].promises.find("x a &amp; &lt;b&gt;: at most 1") != std::string::npos);
  for (const char* raw : {"<i>", "<b>", "<u>", "& "})
    CHECK(html.find(raw) == std::string::npos);
}

} // namespace rounds_test
